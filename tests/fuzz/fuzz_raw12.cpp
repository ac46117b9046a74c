// Any bytes as a raw photograph of any size: unpacked whole and packed again, or not at all.
#include <cstring>

#include "fuzz_input.h"
#include "io/raw12.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  if (size < 2) return 0;
  const cv::Size shape(int(bytes[0]) - 2, int(bytes[1]) - 2);
  const RawImage image = unpack_rgb12p(bytes + 2, size - 2, shape);
  if (image.empty()) return 0;
  const std::vector<uint8_t> again = pack_rgb12p(image);
  const size_t whole = image.total() * 3 / 2 * 3;  // the padding of an odd last sample is lost
  if (again.size() != size - 2 || std::memcmp(again.data(), bytes + 2, whole) != 0) std::abort();
  return 0;
}
