#include "io/whole_file.h"

#include <unistd.h>

#include <atomic>
#include <fstream>
#include <iterator>

#include "base/error.h"

namespace lamella {

namespace {

fs::path beside(const fs::path& path) {
  static std::atomic<int> count{0};
  fs::path clean = path;
  if (!clean.has_filename()) clean = clean.parent_path();
  const std::string name = "." + clean.filename().string() + ".part-" + std::to_string(getpid()) +
                           "-" + std::to_string(count++);
  return clean.parent_path() / name;
}

}  // namespace

void write_whole_file(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  const fs::path temporary = beside(path);
  try {
    if (path.has_parent_path()) fs::create_directories(path.parent_path());
    write(temporary);
    fs::rename(temporary, path);
  } catch (const std::exception& e) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    if (dynamic_cast<const Error*>(&e)) throw;
    throw_bad_input(path.string(), std::string("cannot be written (") + e.what() + ")",
                    "check the folder and the space on its disk");
  }
}

void write_whole_text(const fs::path& path, const std::string& text) {
  write_whole_file(path, [&](const fs::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out.exceptions(std::ios::failbit | std::ios::badbit);
    out.write(text.data(), std::streamsize(text.size()));
    out.close();
  });
}

WholeFolder::WholeFolder(fs::path place) : place_(std::move(place)) {
  if (!place_.has_filename()) place_ = place_.parent_path();
  temporary_ = beside(place_);
  std::error_code failed;
  fs::create_directories(temporary_, failed);
  if (failed) {
    throw_bad_input(place_.string(), "cannot be created (" + failed.message() + ")",
                    "check the folder above it");
  }
}

WholeFolder::~WholeFolder() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

void WholeFolder::commit() {
  std::error_code failed;
  const fs::path old = beside(place_);
  const bool replaces = fs::exists(place_);
  if (replaces) fs::rename(place_, old, failed);
  if (!failed) fs::rename(temporary_, place_, failed);
  if (failed) {
    std::error_code ignored;
    if (replaces && !fs::exists(place_)) fs::rename(old, place_, ignored);
    throw_bad_input(place_.string(), "cannot be replaced (" + failed.message() + ")");
  }
  committed_ = true;
  if (replaces) fs::remove_all(old, failed);
}

std::string read_text(const fs::path& path, size_t max_bytes) {
  std::error_code failed;
  const auto size = fs::file_size(path, failed);
  if (failed) throw_bad_input(path.string(), "cannot be read (" + failed.message() + ")");
  if (size > max_bytes) {
    throw_bad_input(path.string(), std::to_string(size) + " bytes; at most " +
                                       std::to_string(max_bytes) + " are read");
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) throw_bad_input(path.string(), "cannot be opened");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace lamella
