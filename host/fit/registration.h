// How far one photograph of a surface is shifted against another that is lit otherwise. Skin's fine
// texture is the same under any light, its shading is not: what is compared is the logarithm of
// the light without what varies slowly.
#pragma once

#include "base/vec.h"

namespace lamella::fit {

// `image` as it is seen where it has moved to: out(x) = image(x + by_px), Lanczos of order 3,
// pixels beyond the edge as at the edge. By zero, the same pixels.
cv::Mat shifted(const cv::Mat& image, const cv::Vec2d& by_px);

// The same of a mask: 255 wherever one of the four pixels around is.
Mask shifted_mask(const Mask& mask, const cv::Vec2d& by_px);

// A photograph's texture, fine and in blocks of 4 x 4 pixels.
struct Texture {
  struct Level {
    Image1 detail;  // of the logarithm, 0 on average
    Mask trusted;   // 255 where nothing from outside the subject is in it
  };
  Level fine, coarse;
};

// `light`: a photograph, one number a pixel. `subject`: 255 where it shows the subject, lit.
// `detail_px`: what is wider than this counts as shading.
Texture texture_of(const Image1& light, const Mask& subject, double detail_px);

struct Registration {
  bool is_found = false;
  cv::Vec2d shift_px{0, 0};  // `to` at x + shift shows what `from` shows at x
  cv::Vec2d sigma_px{0, 0};  // one sigma of what differs between the two
};

// Gauss-Newton on the squared difference, robust, coarse before fine. Not found where the two have
// hardly anything in common.
Registration register_textures(const Texture& from, const Texture& to);

}  // namespace lamella::fit
