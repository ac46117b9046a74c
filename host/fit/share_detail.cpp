#include "fit/share_detail.h"

#include <opencv2/imgproc.hpp>

#include "base/parallel.h"

namespace lamella::fit {

namespace {

constexpr double kFewestPixels = 100;  // that tell a covariance
constexpr double kLeastNoise = 1e-10;  // of a share, squared: none

using Mat33 = cv::Matx33d;

// One region's part of the map, within its bounding box.
class RegionShare {
 public:
  RegionShare(const Labels& regions, int label, ShareMap* map)
      : box_(cv::boundingRect(regions == label)),
        share_(map->share(box_)),
        noise_(map->noise_variance(box_)),
        inside_(box_.size(), 0.f) {
    for (int y = 0; y < box_.height; ++y) {
      for (int x = 0; x < box_.width; ++x) {
        if (regions(box_.y + y, box_.x + x) != label || !is_finite(share_(y, x))) continue;
        inside_(y, x) = 1;
        count_ += 1;
      }
    }
  }

  double count() const { return count_; }

  void find_mean(int window_px) {
    const cv::Size window(window_px, window_px);
    Image3 sum(box_.size(), Vec3(0, 0, 0));
    share_.copyTo(sum, inside_ > 0);
    cv::boxFilter(sum, mean_, -1, window, {-1, -1}, false, cv::BORDER_CONSTANT);
    cv::boxFilter(inside_, neighbours_, -1, window, {-1, -1}, false, cv::BORDER_CONSTANT);
    for (int y = 0; y < box_.height; ++y) {
      for (int x = 0; x < box_.width; ++x) {
        if (inside_(y, x) > 0) mean_(y, x) *= 1 / neighbours_(y, x);
      }
    }
  }

  // G, from all pixels' differences and their mean noise.
  Mat33 gain() const {
    Mat33 covariance = Mat33::zeros(), noise = Mat33::zeros();
    for (int y = 0; y < box_.height; ++y) {
      for (int x = 0; x < box_.width; ++x) {
        if (!(inside_(y, x) > 0)) continue;
        const Vec3d difference(share_(y, x) - mean_(y, x));
        covariance += difference * difference.t();
        noise += Mat33::diag(Vec3d(noise_(y, x)));
      }
    }
    return without_noise(covariance * (1 / count_), noise * (1 / count_));
  }

  void apply(const Mat33& gain) {
    const cv::Matx33f g(gain);
    for (int y = 0; y < box_.height; ++y) {
      for (int x = 0; x < box_.width; ++x) {
        if (!(inside_(y, x) > 0)) continue;
        share_(y, x) = mean_(y, x) + g * (share_(y, x) - mean_(y, x));
        const float mean_share = 1 / neighbours_(y, x);  // the pixel's own, in the mean
        for (int c = 0; c < 3; ++c) {
          noise_(y, x)[c] *= mean_share + std::max(0.f, g(c, c)) * (1 - mean_share);
        }
      }
    }
  }

 private:
  // Of C - N what is positive.
  static Mat33 without_noise(const Mat33& covariance, const Mat33& noise) {
    Vec3d values;
    Mat33 vectors, skin = Mat33::zeros();
    cv::eigen(covariance - noise, values, vectors);
    for (int i = 0; i < 3; ++i) {
      const cv::Matx13d v = vectors.row(i);
      if (values[i] > 0) skin += v.t() * v * values[i];
    }
    return skin * (skin + noise + Mat33::eye() * kLeastNoise).inv(cv::DECOMP_SVD);
  }

  cv::Rect box_;
  Image3 share_, noise_, mean_;  // the first two are the map's own
  Image1 inside_, neighbours_;   // 1 where there is a pixel; how many a mean is of
  double count_ = 0;
};

}  // namespace

void remove_share_noise(const Labels& regions, int region_count, int window_px, ShareMap* map) {
  parallel_for(region_count, [&](int i) {
    RegionShare region(regions, i + 1, map);
    if (region.count() < kFewestPixels) return;
    region.find_mean(window_px);
    region.apply(region.gain());
  });
}

}  // namespace lamella::fit
