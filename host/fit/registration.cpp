#include "fit/registration.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace lamella::fit {

namespace {

constexpr int kLanczos = 3;
constexpr int kCoarse = 4;             // pixels of a block, each way
constexpr double kGrainPx = 0.8;       // noise between neighbours is averaged away
constexpr float kLeastTexture = 0.2f;  // of the median light: the logarithm of less is noise
constexpr int kMostRounds = 8;
constexpr double kSettledPx = 2e-3;
constexpr double kMostStepPx = 1;
constexpr double kMostShiftPx = 8;
constexpr double kLeastCommon = 0.2;  // correlation
constexpr size_t kFewestTrusted = 500;
constexpr double kSigmasInOutlier = 2;   // where a pixel's weight has fallen to half
constexpr double kCorrelatedPixels = 2;  // neighbours' differences are alike: of sigma

double lanczos(double x) {
  if (std::abs(x) < 1e-9) return 1;
  if (std::abs(x) >= kLanczos) return 0;
  const double a = CV_PI * x;
  return kLanczos * std::sin(a) * std::sin(a / kLanczos) / (a * a);
}

// Taps of out(x) = sum of k_i in(x + i - reach), for a shift along one axis.
std::vector<float> shift_taps(double by_px) {
  const int reach = int(std::ceil(std::abs(by_px))) + kLanczos;
  std::vector<float> taps;
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) sum += lanczos(i - by_px);
  for (int i = -reach; i <= reach; ++i) taps.push_back(float(lanczos(i - by_px) / sum));
  return taps;
}

float median_light(const Image1& light, const Mask& subject) {
  std::vector<float> some;
  for (int y = 0; y < light.rows; y += 3) {
    for (int x = 0; x < light.cols; x += 3) {
      if (subject(y, x)) some.push_back(light(y, x));
    }
  }
  if (some.empty()) return 0;
  const auto middle = some.begin() + std::ptrdiff_t(some.size() / 2);
  std::nth_element(some.begin(), middle, some.end());
  return *middle;
}

void blur_twice(Image1* image, int side_px) {
  for (int i = 0; i < 2; ++i) cv::blur(*image, *image, cv::Size(side_px, side_px));
}

Texture::Level level_of(const Image1& light, const Mask& subject, double detail_px) {
  const int side_px = 2 * std::max(1, int(std::lround(detail_px * 0.6))) + 1;  // of two boxes
  const float floor = std::max(kLeastTexture * median_light(light, subject), 1e-6f);
  Image1 log_light, inside, shading;
  cv::log(cv::max(light, floor), log_light);
  subject.convertTo(inside, CV_32F, 1 / 255.);
  log_light = log_light.mul(inside);
  shading = log_light.clone();
  blur_twice(&shading, side_px);
  Image1 weight = inside.clone();
  blur_twice(&weight, side_px);
  Texture::Level level;
  level.detail = log_light - shading.mul(1 / cv::max(weight, 1e-3f));
  level.detail = level.detail.mul(inside);
  cv::GaussianBlur(level.detail, level.detail, cv::Size(0, 0), kGrainPx);
  const Mask bright = light > floor;
  cv::erode(subject & bright, level.trusted,
            cv::getStructuringElement(cv::MORPH_RECT, cv::Size(2 * side_px - 1, 2 * side_px - 1)));
  return level;
}

// Sums over the pixels that both trust, of one round.
struct Normal {
  double xx = 0, xy = 0, yy = 0, xr = 0, yr = 0;  // of gradients and differences, weighted
  double aa = 0, bb = 0, ab = 0;                  // of the two
  size_t count = 0;
};

// `b`: `to`, shifted back by what is known so far.
Normal gather(const Texture::Level& from, const Image1& b, const Mask& trusted, double spread) {
  const Image1& a = from.detail;
  const float half = float(1 / (kSigmasInOutlier * spread * kSigmasInOutlier * spread));
  Normal n;
  for (int y = 1; y + 1 < a.rows; ++y) {
    float xx = 0, xy = 0, yy = 0, xr = 0, yr = 0, aa = 0, bb = 0, ab = 0;
    for (int x = 1; x + 1 < a.cols; ++x) {
      if (!trusted(y, x) || !from.trusted(y, x)) continue;
      const float p = a(y, x), q = b(y, x), r = q - p;
      const float gx = 0.25f * (a(y, x + 1) - a(y, x - 1) + b(y, x + 1) - b(y, x - 1));
      const float gy = 0.25f * (a(y + 1, x) - a(y - 1, x) + b(y + 1, x) - b(y - 1, x));
      const float w = 1 / (1 + r * r * half);
      xx += w * gx * gx, xy += w * gx * gy, yy += w * gy * gy, xr += w * gx * r, yr += w * gy * r;
      aa += p * p, bb += q * q, ab += p * q;
      ++n.count;
    }
    n.xx += double(xx), n.xy += double(xy), n.yy += double(yy);
    n.xr += double(xr), n.yr += double(yr);
    n.aa += double(aa), n.bb += double(bb), n.ab += double(ab);
  }
  return n;
}

// One sigma of the difference, from its median.
double spread_of(const Texture::Level& from, const Image1& b, const Mask& trusted) {
  std::vector<float> off;
  for (int y = 1; y < b.rows; y += 3) {
    for (int x = 1; x < b.cols; x += 3) {
      if (trusted(y, x) && from.trusted(y, x)) off.push_back(std::abs(b(y, x) - from.detail(y, x)));
    }
  }
  if (off.empty()) return 1;
  const auto middle = off.begin() + std::ptrdiff_t(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return std::max(1.4826 * double(*middle), 1e-6);
}

// From a first guess; stays at it where there is too little to go by.
Registration refine(const Texture::Level& from, const Texture::Level& to, cv::Vec2d at_px) {
  Registration result;
  result.shift_px = at_px;
  for (int round = 0; round < kMostRounds; ++round) {
    const Image1 b = shifted(to.detail, result.shift_px);
    const double spread = spread_of(from, b, to.trusted);
    const Normal n = gather(from, b, to.trusted, spread);
    const double det = n.xx * n.yy - n.xy * n.xy;
    if (n.count < kFewestTrusted || !(det > 0)) return result;
    const cv::Vec2d step(-(n.yy * n.xr - n.xy * n.yr) / det, -(n.xx * n.yr - n.xy * n.xr) / det);
    const double far = std::max(1., cv::norm(step) / kMostStepPx);
    result.shift_px += step / far;
    const double sigma = spread * kCorrelatedPixels;
    result.sigma_px = {sigma * std::sqrt(n.yy / det), sigma * std::sqrt(n.xx / det)};
    if (cv::norm(result.shift_px) > kMostShiftPx) return result;
    if (cv::norm(step) < kSettledPx) {
      result.is_found = n.ab > kLeastCommon * std::sqrt(n.aa * n.bb);
      return result;
    }
  }
  return result;
}

}  // namespace

cv::Mat shifted(const cv::Mat& image, const cv::Vec2d& by_px) {
  cv::Mat out;
  cv::sepFilter2D(image, out, -1, shift_taps(by_px[0]), shift_taps(by_px[1]), cv::Point(-1, -1), 0,
                  cv::BORDER_REPLICATE);
  return out;
}

Mask shifted_mask(const Mask& mask, const cv::Vec2d& by_px) {
  const int x0 = int(std::floor(by_px[0])), y0 = int(std::floor(by_px[1]));
  Mask out(mask.size(), 0);
  if (mask.empty() || cv::countNonZero(mask) == 0) return out;
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      for (int k = 0; k < 4; ++k) {
        const int i = std::clamp(x + x0 + k % 2, 0, out.cols - 1);
        const int j = std::clamp(y + y0 + k / 2, 0, out.rows - 1);
        out(y, x) |= mask(j, i);
      }
    }
  }
  return out;
}

Texture texture_of(const Image1& light, const Mask& subject, double detail_px) {
  const cv::Size blocks(light.cols / kCoarse, light.rows / kCoarse);
  const cv::Rect whole(0, 0, blocks.width * kCoarse, blocks.height * kCoarse);
  Image1 coarse;
  cv::resize(light(whole), coarse, blocks, 0, 0, cv::INTER_AREA);
  Mask coarse_subject;
  cv::resize(subject(whole), coarse_subject, blocks, 0, 0, cv::INTER_AREA);
  return {level_of(light, subject, detail_px), level_of(coarse, coarse_subject == 255, detail_px)};
}

Registration register_textures(const Texture& from, const Texture& to) {
  const Registration rough = refine(from.coarse, to.coarse, {0, 0});
  const cv::Vec2d start = rough.is_found ? rough.shift_px * double(kCoarse) : cv::Vec2d(0, 0);
  return refine(from.fine, to.fine, start);
}

}  // namespace lamella::fit
