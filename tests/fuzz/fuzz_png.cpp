// Any bytes as a PNG picture. Only the size of a picture is bounded here, for the fuzzer's memory.
#include <zlib.h>

#include "fuzz_input.h"
#include "io/picture_png.h"

namespace {

constexpr int kMostPixels = 1 << 16;

uint32_t number_at(const uint8_t* bytes) {
  return uint32_t(bytes[0]) << 24 | bytes[1] << 16 | bytes[2] << 8 | bytes[3];
}

// Else hardly any mutation would get past its chunk's checksum.
void mend_checksums(uint8_t* bytes, size_t size) {
  size_t at = 8;
  while (size >= 12 && at <= size - 12) {
    const size_t length = number_at(bytes + at);
    if (length > size - at - 12) return;
    const uLong crc = crc32(0, bytes + at + 4, uInt(length + 4));
    for (size_t i = 0; i < 4; ++i) bytes[at + 8 + length + i] = uint8_t(crc >> (24 - 8 * i));
    at += 12 + length;
  }
}

}  // namespace

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size,
                                          unsigned random) {
  size = LLVMFuzzerMutate(data, size, max_size);
  if (random % 4 != 0) mend_checksums(data, size);
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  const std::string png(reinterpret_cast<const char*>(bytes), size);
  fuzz::expect_error_or_nothing([&] {
    const PngHeader header = png_header(png, "fuzz");
    if (header.size.area() > kMostPixels) return;
    const cv::Mat picture = decode_png(png, "fuzz");
    if (picture.size() != header.size || (picture.channels() != 1 && picture.channels() != 3)) {
      std::abort();
    }
  });
  return 0;
}
