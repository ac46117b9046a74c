// Pixels of scanline files that ZIP or run lengths compress, decompressed by libdeflate: half of
// the time of reading a burst went into zlib, which OpenEXR 3.1 uses itself.
#pragma once

#include <OpenEXR/ImfInputFile.h>

#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace lamella {

// Where one channel goes, as floats.
struct ExrPlane {
  std::string name;
  char* base;  // first pixel of what is read
  size_t x_stride, y_stride;
};

// A sample that is NaN or infinity.
class NonFinitePixel : public std::runtime_error {
 public:
  explicit NonFinitePixel(const cv::Point& at);
};

struct ExrPart {
  cv::Rect area;
  bool is_finite = false;  // refuses what is not, be it outside of the area
};

// Reads `planes`, all of which the file has, without subsampling, of `part`, and returns true;
// false, with nothing read, where the file is not of that kind (another compression, tiles,
// subsampled or integer channels). Throws std::exception where the file is damaged, by
// the CRC that packed_exr() gave it too.
bool read_packed_planes(Imf::InputFile* file, const std::vector<ExrPlane>& planes,
                        const ExrPart& part);

}  // namespace lamella
