// Any bytes as a raw photograph of any pixel format and size: developed to as many pixels, or
// to none where the number of bytes is wrong.
#include "calib/develop.h"
#include "fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  if (size < 3) return 0;
  const auto pixels = RawPixels(bytes[2] % 6);
  const cv::Size shape(int(bytes[0]) - 2, int(bytes[1]) - 2);
  const std::vector<uint8_t> raw(bytes + 3, bytes + size);
  const Image3 image = develop(raw, shape, {64, 1.0 / 4000, 1.0, pixels});
  // No bytes are a photograph of no pixels, nor of a mosaic too small to have every colour.
  const bool any = shape.width > 0 && shape.height > 0;
  const size_t needed = any ? raw12_bytes(pixels, size_t(shape.width), size_t(shape.height)) : 0;
  const bool whole = needed > 0 && raw.size() == needed;
  if (image.empty() == whole || (whole && image.size() != shape)) std::abort();
  return 0;
}
