// PNG pictures in memory. libpng prints nothing: what is wrong is an Error's one line.
#pragma once

#include <string>

#include "base/vec.h"

namespace lamella {

struct PngHeader {
  cv::Size size;
  int bits = 0;          // a channel
  bool is_grey = false;  // without colour, palette or alpha
};

// Of a whole PNG image, before anything is allocated for it. Throws Error, about `where`, where the
// bytes are no PNG image or are cut, or the image is over kMaxImageSide or kMaxImagePixels.
PngHeader png_header(const std::string& bytes, const std::string& where);

// 8 or 16 bits a channel, 1 channel (grey) or 3 (b, g, r), as the file has them: grey of 1, 2 or 4
// bits is stretched to 8, a palette looked up, alpha left out. A file's word on gamma or colour
// space changes no value. Throws Error as png_header() does, and where the image is damaged.
cv::Mat decode_png(const std::string& bytes, const std::string& where);

enum class PngEffort {
  kQuick,  // a fast single filter and runs alone: smaller than zlib's level 1 makes it
  kSmall,  // for pictures that are kept and shown
};

// The bytes of a file, of a picture of 8 bits and 1 channel (grey), 3 (b, g, r) or 4 (with alpha).
std::string encode_png(const cv::Mat& picture, PngEffort effort = PngEffort::kQuick);

}  // namespace lamella
