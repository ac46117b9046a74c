#include "base/outline.h"

#include <opencv2/imgproc.hpp>

namespace lamella {

namespace {

Image1 distance_inside(const Mask& mask) {
  cv::Mat d;
  cv::distanceTransform(mask, d, cv::DIST_L2, 5);
  return d;
}

}  // namespace

Mask grown(const Mask& mask, float radius_px) { return distance_inside(~mask) <= radius_px; }
Mask shrunk(const Mask& mask, float radius_px) { return distance_inside(mask) > radius_px; }

Mask closed(const Mask& mask, float radius_px) {
  // With room around the picture, or shrinking would not come back from its border.
  const int room = int(radius_px) + 2;
  Mask roomy;
  cv::copyMakeBorder(mask, roomy, room, room, room, room, cv::BORDER_CONSTANT, cv::Scalar(0));
  const Mask whole = shrunk(grown(roomy, radius_px), radius_px);
  return whole(cv::Rect({room, room}, mask.size())) | mask;
}

Mask opened(const Mask& mask, float radius_px) {
  return grown(shrunk(mask, radius_px), radius_px) & mask;
}

Image1 signed_distance_px(const Mask& mask) {
  return distance_inside(mask) - distance_inside(~mask);
}

}  // namespace lamella
