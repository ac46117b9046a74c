// Any bytes as an OpenEXR file. Only the size of an image is bounded here, for the fuzzer's memory.
#include <fcntl.h>

#include <algorithm>

#include "fuzz_input.h"
#include "io/exr.h"

namespace {

constexpr int kMostPixels = 1 << 16;

// A small whole file, which mutations start from.
const std::string& seed() {
  static const std::string bytes = [] {
    std::string name = "/tmp/lamella-fuzz-XXXXXX";
    const int fd = mkstemp(name.data());
    lamella::write_exr_rgb(name, lamella::Image3(9, 7, lamella::Vec3(0.5f, 1, 2)),
                           lamella::PixelType::kHalf);
    std::string text(std::filesystem::file_size(name), '\0');
    const int whole = open(name.c_str(), O_RDONLY);
    if (read(whole, text.data(), text.size()) != ssize_t(text.size())) std::abort();
    close(whole);
    close(fd);
    std::filesystem::remove(name);
    return text;
  }();
  return bytes;
}

}  // namespace

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned) {
  if (size < 8 && max_size >= seed().size()) {
    std::copy(seed().begin(), seed().end(), data);
    size = seed().size();
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
