#include "io/whole_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <system_error>
#include <vector>

#include "base/error.h"

namespace lamella {

namespace {

fs::path without_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

constexpr const char* kUnderWay = "part";
constexpr const char* kReplaced = "old";
constexpr const char* kLock = ".lock";  // in a folder that is under way, or to be removed
constexpr const char* kLockToBe = ".lock-to-be";

// ".session.part-1234-0"; remove_abandoned() knows them by it.
fs::path beside(const fs::path& path, const char* kind) {
  static std::atomic<int> count{0};
  const fs::path clean = without_slash(path);
  std::string name = ".";
  name += clean.filename().string() + "." + kind + "-" + std::to_string(getpid()) + "-" +
          std::to_string(count++);
  return clean.parent_path() / name;
}

// The file gets its name once it is locked: whoever finds it without a lock finds no owner either.
// Not every file system has locks: then nothing in it counts as abandoned.
int lock_folder(const fs::path& folder) {
  const fs::path unnamed = folder / kLockToBe;
  const int fd = open(unnamed.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (fd < 0) return fd;
  flock(fd, LOCK_EX | LOCK_NB);
  std::error_code failed;
  fs::rename(unnamed, folder / kLock, failed);
  return fd;
}

// The kernel drops a lock with the process that held it. The number of that process says nothing:
// it may have been given to another, or be of another container.
bool is_locked(const fs::path& folder) {
  const int fd = open((folder / kLock).c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return true;  // without one it is somebody else's, of such a name
  const bool locked = flock(fd, LOCK_EX | LOCK_NB) != 0;
  close(fd);
  return locked;
}

// What beside() made of a path.
struct Beside {
  std::string name, kind;
};

// Takes "-" and one to nine digits from the end of `text`; false where there are none.
bool take_number(std::string* text) {
  const size_t dash = text->rfind('-');
  if (dash == std::string::npos) return false;
  const std::string digits = text->substr(dash + 1);
  const bool all = digits.find_first_not_of("0123456789") == std::string::npos;
  if (digits.empty() || digits.size() > 9 || !all) return false;
  text->resize(dash);
  return true;
}

std::optional<Beside> read_beside(std::string text) {
  if (!take_number(&text) || !take_number(&text)) return {};
  const size_t dot = text.rfind('.');
  if (text[0] != '.' || dot < 2) return {};
  const Beside read{text.substr(1, dot - 1), text.substr(dot + 1)};
  if (read.kind != kUnderWay && read.kind != kReplaced) return {};
  return read;
}

bool is_abandoned(const fs::directory_entry& entry) {
  const auto read = read_beside(entry.path().filename().string());
  if (!read || entry.symlink_status().type() != fs::file_type::directory) return false;
  // What is to be replaced is all there is until the new one is in its place.
  const fs::path place = entry.path().parent_path() / read->name;
  if (read->kind == kReplaced && !fs::exists(place)) return false;
  return !is_locked(entry.path());
}

// Makes `folder` and those above it; returns the outermost that was not there, or nothing.
fs::path make_folders(const fs::path& folder) {
  fs::path first;
  for (fs::path p = folder; !p.empty() && !fs::exists(p); p = p.parent_path()) {
    first = p;
    if (p == p.parent_path()) break;
  }
  if (!folder.empty()) fs::create_directories(folder);  // empty: the current folder
  return first;
}

// Removes `folder` and those above it, up to `first`, as long as they are empty.
void remove_folders(fs::path folder, const fs::path& first) {
  if (first.empty()) return;
  std::error_code failed;
  while (fs::remove(folder, failed) && folder != first) folder = folder.parent_path();
}

struct Begun {
  fs::path temporary;
  fs::path first_made;  // outermost folder made for it; empty: none
};

std::mutex& outputs_lock() {
  static std::mutex mutex;
  return mutex;
}

std::vector<Begun>& begun_outputs() {
  static std::vector<Begun> begun;
  return begun;
}

// Makes the folder `temporary` and those above it; returns the lock that says that it is being
// filled.
int begin_output(const fs::path& temporary) {
  {
    const std::lock_guard lock(outputs_lock());
    begun_outputs().push_back({temporary, make_folders(temporary.parent_path())});
  }
  fs::create_directory(temporary);
  return lock_folder(temporary);
}

// With the lock held.
void forget_output(const fs::path& temporary) {
  std::erase_if(begun_outputs(), [&](const Begun& b) { return b.temporary == temporary; });
}

// Removes it, with the folders that were made for it; nothing where it was not begun.
void give_up_output(const fs::path& temporary, int lock) {
  const std::lock_guard held(outputs_lock());
  std::error_code ignored;
  for (const Begun& output : begun_outputs()) {
    if (output.temporary != temporary) continue;
    fs::remove_all(temporary, ignored);
    remove_folders(temporary.parent_path(), output.first_made);
  }
  forget_output(temporary);
  if (lock >= 0) close(lock);
}

std::string with_other_name(std::string message, const std::string& name,
                            const std::string& other) {
  for (size_t at = 0; (at = message.find(name, at)) != std::string::npos; at += other.size()) {
    message.replace(at, name.size(), other);
  }
  return message;
}

[[noreturn]] void cannot_write(const fs::path& path, const std::string& why) {
  throw_bad_input(path.string(), "cannot be written (" + why + ")",
                  "check the folder and the space on its disk");
}

// What failed about `temporary`, which nobody knows of.
std::string reason(const std::exception& e, const fs::path& temporary, const fs::path& path) {
  if (const auto* of_call = dynamic_cast<const std::system_error*>(&e);
      of_call && of_call->code().category() == std::generic_category()) {
    return of_call->code().message();
  }
  const auto* of_system = dynamic_cast<const fs::filesystem_error*>(&e);
  if (of_system) return of_system->code().message();
  return with_other_name(e.what(), temporary.string(), path.string());
}

// A folder may only be replaced by one of its own kind.
void require_replaceable(const fs::path& place, const std::string& marker) {
  require_folder_place(place);
  if (!fs::exists(place)) return;
  if (fs::is_symlink(place)) {
    throw_bad_input(place.string(), "is a link to " + fs::read_symlink(place).string(),
                    "remove the link, or give that folder itself");
  }
  if (marker.empty() || fs::is_empty(place) || fs::exists(place / marker)) return;
  throw_bad_input(place.string(), "exists and holds no " + marker + ", so it is not replaced",
                  "choose another place");
}

// A process's own links, as /dev/stdout leads to one: what is open there, whatever they say.
bool is_open_file(const fs::path& link) {
  std::error_code failed;
  const fs::path folder = fs::canonical(link.parent_path(), failed);
  return !failed && folder.string().starts_with("/proc/");
}

// The first path behind `path` that is no link, or that is one of a process's own.
fs::path end_of_links(fs::path path) {
  constexpr int kMostLinks = 40;  // as the kernel has it
  std::error_code failed;
  for (int i = 0; i < kMostLinks && fs::is_symlink(fs::symlink_status(path, failed)); ++i) {
    if (is_open_file(path)) break;
    path = path.parent_path() / fs::read_symlink(path);
  }
  return path;
}

}  // namespace

fs::path file_behind(const fs::path& path) { return end_of_links(path); }

bool is_same_file(const fs::path& a, const fs::path& b) {
  if (a.empty() || b.empty()) return false;
  std::error_code failed;
  if (fs::equivalent(a, b, failed)) return true;
  const fs::path place_a = fs::weakly_canonical(fs::absolute(file_behind(a)), failed);
  return !failed && place_a == fs::weakly_canonical(fs::absolute(file_behind(b)), failed);
}

void require_file_place(const fs::path& path) {
  if (!path.has_filename())
    throw_bad_input("\"" + path.string() + "\"", "is no name of a file", "name one");
  if (fs::is_directory(path)) throw_bad_input(path.string(), "is a folder", "give a file");
  // A device, a pipe or a socket would be replaced by a file of that name.
  const bool is_regular = !fs::exists(path) || fs::is_regular_file(path);
  if (!is_regular || fs::is_symlink(file_behind(path))) {
    throw_bad_input(path.string(), "is no file", "give the name of a file");
  }
}

bool lies_in(const fs::path& place, const fs::path& folder) {
  const fs::path inner = fs::weakly_canonical(fs::absolute(without_slash(place)));
  const fs::path outer = fs::weakly_canonical(fs::absolute(without_slash(folder)));
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

void require_folder_place(const fs::path& path) {
  const bool is_there = fs::exists(path);
  if (!is_there && fs::is_symlink(path)) {
    throw_bad_input(path.string(),
                    "is a link to " + fs::read_symlink(path).string() + ", which is not there",
                    "remove the link or choose another place");
  }
  if (is_there && !fs::is_directory(path)) {
    throw_bad_input(path.string(), "exists and is not a folder", "choose another place");
  }
}

void abandon_outputs() {
  outputs_lock().lock();  // never to be unlocked
  std::error_code failed;
  // Threads that still write into a folder may put something into it while it is being removed.
  for (const Begun& output : begun_outputs()) {
    for (int i = 0; i < 100 && fs::exists(output.temporary, failed); ++i) {
      fs::remove_all(output.temporary, failed);
    }
    remove_folders(output.temporary.parent_path(), output.first_made);
  }
}

void write_whole_file(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  require_file_place(path);
  const fs::path place = file_behind(path);
  const fs::path folder = beside(place, kUnderWay), temporary = folder / path.filename();
  int lock = -1;
  try {
    lock = begin_output(folder);
    write(temporary);
    const std::lock_guard held(outputs_lock());
    fs::rename(temporary, place);
    std::error_code ignored;
    fs::remove_all(folder, ignored);
    forget_output(folder);
    if (lock >= 0) close(lock);
  } catch (const std::exception& e) {
    give_up_output(folder, lock);
    const auto* error = dynamic_cast<const Error*>(&e);
    if (!error) cannot_write(path, reason(e, temporary, path));
    throw Error(error->fault(), "", with_other_name(e.what(), temporary.string(), path.string()));
  }
}

void write_whole_text(const fs::path& path, const std::string& text) {
  write_whole_file(path, [&](const fs::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    if (out) out.write(text.data(), std::streamsize(text.size()));
    if (out) out.close();
    if (!out) throw std::system_error(errno, std::generic_category());
  });
}

WholeFolder::WholeFolder(fs::path place, const std::string& marker)
    : place_(without_slash(place)), temporary_(beside(place_, kUnderWay)) {
  if (place_.empty()) throw_bad_input("\"\"", "is no name of a folder", "name one");
  require_replaceable(place_, marker);
  replaceable_ = fs::exists(place_) && !fs::is_empty(place_);
  try {
    lock_ = begin_output(temporary_);
  } catch (const std::exception& e) {
    give_up_output(temporary_, lock_);
    cannot_write(place_, reason(e, temporary_, place_));
  }
}

WholeFolder::~WholeFolder() {
  if (!committed_) {
    give_up_output(temporary_, lock_);
  } else if (lock_ >= 0) {
    close(lock_);
  }
}

// With the lock held, once it is in its place.
void WholeFolder::settle() {
  committed_ = true;
  std::error_code ignored;
  fs::remove(place_ / kLock, ignored);
  forget_output(temporary_);
}

bool WholeFolder::commit_at(const fs::path& place) {
  const std::lock_guard lock(outputs_lock());
  std::error_code failed;
  fs::rename(temporary_, place, failed);
  if (failed == std::errc::directory_not_empty || failed == std::errc::file_exists) return false;
  if (failed) cannot_write(place, failed.message());
  place_ = place;
  settle();
  return true;
}

void WholeFolder::commit() {
  const std::lock_guard lock(outputs_lock());
  std::error_code failed;
  const fs::path old = beside(place_, kReplaced);
  const bool replaces = fs::exists(place_) && !fs::is_empty(place_, failed);
  if (replaces && !replaceable_) {
    throw_bad_input(place_.string(), "was made by somebody else meanwhile, so it is not replaced",
                    "choose another place");
  }
  if (replaces) fs::rename(place_, old, failed);
  if (!failed) fs::rename(temporary_, place_, failed);
  if (failed) {
    std::error_code ignored;
    if (replaces && !fs::exists(place_)) fs::rename(old, place_, ignored);
    throw_bad_input(place_.string(), "cannot be replaced (" + failed.message() + ")",
                    "see who may write there, or choose another place");
  }
  settle();
  if (!replaces) return;
  close(lock_folder(old));  // from here on it may be removed by whoever finds it
  fs::remove_all(old, failed);
}

std::string WholeFolder::in_place(const std::string& message) const {
  return with_other_name(message, temporary_.string(), place_.string());
}

std::string WholeFolder::inside(const std::string& message) const {
  return with_other_name(message, temporary_.string() + "/", "");
}

void WholeFolder::blame_place(const std::function<void()>& fill) const {
  try {
    fill();
  } catch (const Error& e) {
    throw Error(e.fault(), "", in_place(e.what()));
  }
}

int remove_abandoned(const fs::path& folder) {
  std::error_code failed;
  std::vector<fs::path> abandoned;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, failed)) {
    if (is_abandoned(entry)) abandoned.push_back(entry.path());
  }
  int count = 0;
  for (const fs::path& path : abandoned) {
    fs::remove_all(path, failed);
    if (!failed) ++count;
  }
  return count;
}

void sync_to_disk(const fs::path& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = fd >= 0 && syncfs(fd) == 0;
  if (fd >= 0) close(fd);
  if (!done) cannot_write(path, "its disk does not take it");
}

std::string read_text(const fs::path& path, size_t max_bytes) {
  std::error_code failed;
  const auto size = fs::file_size(path, failed);
  if (failed)
    throw_bad_input(path.string(), "cannot be read (" + failed.message() + ")",
                    "is the name right, and may you read it?");
  if (size > max_bytes) {
    throw_bad_input(
        path.string(),
        std::to_string(size) + " bytes; at most " + std::to_string(max_bytes) + " are read",
        "is it the right file?");
  }
  std::ifstream in(path, std::ios::binary);
  if (!in) throw_bad_input(path.string(), "cannot be opened", "may you read it?");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace lamella
