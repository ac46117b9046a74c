// A part of an image.
#pragma once

#include <opencv2/core.hpp>

namespace lamella {

struct PixelWindow {
  cv::Size whole;  // pixels of the image
  cv::Rect area;   // of them, lies in the image
};

inline PixelWindow whole_window(cv::Size size) { return {size, cv::Rect({0, 0}, size)}; }

}  // namespace lamella
