// Images that begin as one value, written by all cores: most of the time that a large image takes
// is the first touch of its memory.
#pragma once

#include <algorithm>

#include "base/parallel.h"
#include "base/vec.h"

namespace lamella {

// `Image`: of cv::Mat_.
template <class Image>
Image filled(cv::Size size, const typename Image::value_type& value) {
  constexpr int kRows = 32;  // a core fills at a time
  Image image(size);
  parallel_for(
      image.rows, [&](int y) { std::fill(image[y], image[y] + image.cols, value); }, kRows);
  return image;
}

}  // namespace lamella
