#include "calib/demosaic.h"

#include <algorithm>

#include "base/parallel.h"

namespace lamella {

namespace {

// Column and row, 0 or 1, of the red sample in each 2 x 2 block.
cv::Point red_site(RawPixels order) {
  switch (order) {
    case RawPixels::kGrbg:
      return {1, 0};
    case RawPixels::kGbrg:
      return {0, 1};
    case RawPixels::kBggr:
      return {1, 1};
    default:
      return {0, 0};
  }
}

int mirrored(int i, int count) {
  if (i < 0) return -i;
  return i < count ? i : 2 * (count - 1) - i;
}

// The mosaic around one pixel.
class Neighbours {
 public:
  Neighbours(const Image1& mosaic, cv::Point at, float clipped)
      : clipped_(clipped),
        left_(mirrored(at.x - 1, mosaic.cols)),
        right_(mirrored(at.x + 1, mosaic.cols)),
        x_(at.x),
        above_(mosaic[mirrored(at.y - 1, mosaic.rows)]),
        here_(mosaic[at.y]),
        below_(mosaic[mirrored(at.y + 1, mosaic.rows)]) {}

  float centre() const { return here_[x_]; }
  float across() const { return mean({here_[left_], here_[right_]}); }
  float along() const { return mean({above_[x_], below_[x_]}); }
  float beside() const { return mean({here_[left_], here_[right_], above_[x_], below_[x_]}); }
  float diagonal() const {
    return mean({above_[left_], above_[right_], below_[left_], below_[right_]});
  }

 private:
  float mean(std::initializer_list<float> samples) const {
    const float largest = std::max(samples);
    if (largest >= clipped_) return largest;
    float sum = 0;
    for (float sample : samples) sum += sample;
    return sum / float(samples.size());
  }

  float clipped_;
  int left_, right_, x_;
  const float *above_, *here_, *below_;
};

Vec3 colour(const Neighbours& n, bool red_row, bool red_column) {
  if (red_row && red_column) return {n.centre(), n.beside(), n.diagonal()};
  if (!red_row && !red_column) return {n.diagonal(), n.beside(), n.centre()};
  if (red_row) return {n.across(), n.centre(), n.along()};
  return {n.along(), n.centre(), n.across()};
}

}  // namespace

Image3 demosaic(const Image1& mosaic, RawPixels order, float clipped) {
  const cv::Point red = red_site(order);
  Image3 image(mosaic.size());
  parallel_for(
      mosaic.rows,
      [&](int y) {
        for (int x = 0; x < mosaic.cols; ++x) {
          image(y, x) = colour(Neighbours(mosaic, {x, y}, clipped), y % 2 == red.y, x % 2 == red.x);
        }
      },
      16);
  return image;
}

}  // namespace lamella
