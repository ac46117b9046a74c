// Compressed scanline files to be written: libdeflate compresses faster than zlib, which
// OpenEXR 3.1 uses itself, and chunks are compressed on all processors. The same pixels give the
// same bytes, which ISA-L, faster still, does not keep to.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "base/pixel_window.h"

namespace lamella {

// CRC-32C of all chunks as they are stored, from the top: an int of the header. Run lengths decode
// whatever they are, and so do pixels that are stored as they are.
inline constexpr const char* kExrCrc = "lamella_crc32c";

// ZIP but for the last: run lengths, for what is noise within and one value around. That takes a
// third of the time, and 1.4 times the bytes.
enum class PixelType { kHalf, kFloat, kHalfInRuns };

// Where the floats of one channel are.
struct ExrSource {
  std::string name;
  const char* base;  // first pixel
  size_t x_stride, y_stride;
};

// What is around pixels that are a part of a file.
struct ExrSurroundings {
  PixelWindow window;  // where in the file they lie
  float value;         // of every other pixel
};

// The bytes of a file that has `sources`, of different names, as channels of `stored`, in the
// window. The same floats give the same bytes. Throws std::exception where OpenEXR refuses.
std::string packed_exr(const ExrSurroundings& around, std::vector<ExrSource> sources,
                       PixelType stored);

}  // namespace lamella
