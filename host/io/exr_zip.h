// Pixels of ZIP-compressed scanline files, decompressed by libdeflate: half of the time of reading
// a burst went into zlib, which OpenEXR 3.1 uses itself.
#pragma once

#include <OpenEXR/ImfInputFile.h>

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace lamella {

// Where one channel goes, as floats.
struct ExrPlane {
  std::string name;
  char* base;  // first pixel of what is read
  size_t x_stride, y_stride;
};

// Reads `planes`, all of which the file has, without subsampling, of `area`, and returns true;
// false, with nothing read, where the file is not of that kind (another compression, tiles,
// subsampled or integer channels). Throws std::exception where the file is damaged, be it below
// the area.
bool read_zip_planes(Imf::InputFile* file, const std::vector<ExrPlane>& planes,
                     const cv::Rect& area);

}  // namespace lamella
