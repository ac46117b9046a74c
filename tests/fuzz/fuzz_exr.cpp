// Any bytes as an OpenEXR file. Only the size of an image is bounded here, for the fuzzer's memory.
#include <fcntl.h>

#include <algorithm>

#include "fuzz_input.h"
#include "io/exr.h"

namespace {

constexpr int kMostPixels = 1 << 16;

std::string whole_file(lamella::PixelType type) {
  std::string name = "/tmp/lamella-fuzz-XXXXXX";
  const int fd = mkstemp(name.data());
  lamella::write_exr_rgb(name, lamella::Image3(9, 7, lamella::Vec3(0.5f, 1, 2)), type);
  std::string text(std::filesystem::file_size(name), '\0');
  const int whole = open(name.c_str(), O_RDONLY);
  if (read(whole, text.data(), text.size()) != ssize_t(text.size())) std::abort();
  close(whole);
  close(fd);
  std::filesystem::remove(name);
  return text;
}

// Small whole files, which mutations start from, of every compression that is unpacked here.
const std::string& seed(unsigned which) {
  static const std::string zip = whole_file(lamella::PixelType::kHalf);
  static const std::string runs = whole_file(lamella::PixelType::kHalfInRuns);
  return which % 2 ? runs : zip;
}

}  // namespace

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned number) {
  const std::string& start = seed(number);
  if (size < 8 && max_size >= start.size()) {
    std::copy(start.begin(), start.end(), data);
    size = start.size();
  }
  return LLVMFuzzerMutate(data, size, max_size);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  const fuzz::MemoryFile file(bytes, size);
  fuzz::expect_error_or_nothing([&] {
    if (exr_size(file.path()).area() > kMostPixels) return;
    read_exr(file.path(), exr_channels(file.path()));
    read_exr_rgb(file.path());
  });
  return 0;
}
