// JPEG pictures in memory.
#pragma once

#include <vector>

#include "base/vec.h"

namespace lamella::exporting {

// The bytes of a file: baseline, 4:2:0, `quality` 1 to 100, of pixels b, g, r. Throws Error where
// there is no pixel, or a side is over the 65500 pixels of the format.
std::vector<uchar> encode_jpeg(const cv::Mat3b& bgr, int quality);

}  // namespace lamella::exporting
