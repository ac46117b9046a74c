#include <algorithm>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "base/filled.h"
#include "base/parallel.h"
#include "calib/pattern_scale.h"
#include "fit/diffuse_total.h"
#include "fit/order_statistics.h"
#include "fit/scattering.h"
#include "fit/share_detail.h"
#include "fit/stripe_shape.h"
#include "fit/surface_pattern.h"
#include "fit/turns.h"

namespace lamella::fit {

namespace {

constexpr float kShadow = 1e-3f;  // FRONT - BLACK below this is shadow
// Of FRONT - BLACK, squared: what a planar, even surface leaves out.
constexpr float kModelVariance = 0.01f * 0.01f;
constexpr double kShapeRidge = 10;  // the kernel that gives the stripes their shape
constexpr double kDetail_mm = 2;    // what shares differ by within this may be noise
constexpr int kPhaseWindow_px = 3;
constexpr float kPhaseError_turns = 0.06f;  // on the flanks a sample tells phase more than swing
constexpr float kLeastOfRegion = 0.4f;      // of the region's swing
constexpr float kSwingSpread = 0.15f;       // how far one pixel's swing is from its region's
constexpr float kSigmaAtHalfTrust = 0.1f;   // relative
// Of the variance that errors of phase and model give one pixel by itself, what is left of a share
// that leans on its neighbours.
constexpr float kLeftOfVariance = 0.1f;
constexpr float kLeastRest = 0.01f;  // of a total, as a divisor
// Sums are gathered in as many parts, whatever processors there are, so that they are the same to
// the last bit.
constexpr int kParts = 16;
constexpr int kWitnessStep = 3;  // pixels between those that are asked whether the stripes fit

using BinsPerChannel = std::array<StripeBins, 3>;
using Shapes = std::vector<std::array<StripeShape, 3>>;  // by label - 1

// Whether no sample of the pixel is clipped.
bool has_whole_stripes(const Burst& burst, int y, int x) {
  return !is_clipped(burst.clipped_projector, y, x) && !is_clipped(burst.clipped_stripes, y, x);
}

class Stripes {
 public:
  Stripes(const Burst& burst, const Geometry& geometry, const Normals& normals)
      : burst_(burst), geometry_(geometry), normals_(normals) {
    const Camera& projector = burst.session->projector;
    const Patterns& patterns = burst.session->patterns;
    period_px_ = float(patterns.stripe_period_px);
    shift_turns_ = float(patterns.stripe_shift_px / patterns.stripe_period_px);
    const double facing = 1 / projector.pixel_mm();
    offset_turns_ = filled<Image1>(burst.regions.size(), 0.f);
    find_measured();
    for (size_t k = 0; k < 4; ++k) {
      projector_px_[k] = moved_projector_px(geometry.projector_px, burst.stripes_place[k]);
    }
    highest_cycles_per_mm_ = 1.2 * facing / patterns.stripe_period_px;
  }

  double highest_cycles_per_mm() const { return highest_cycles_per_mm_; }

  bool measured(int y, int x) const { return measured_(y, x) != 0; }

  // As they lie on skin that faces the camera.
  StripeBlocks blocks() const {
    const int bin_px = burst_.quality.bin_px;
    return {bin_px, 1 / (bin_px * pattern_scale(*burst_.session).stripe_px)};
  }

  // Turns from the middle of a white stripe in pattern k.
  float phase(int y, int x, int k) const {
    return projector_px_[size_t(k)](y, x)[0] / period_px_ - 0.25f - float(k) * shift_turns_ -
           offset_turns_(y, x);
  }

  // The stripes are finer than the fringes: what they say of their own phase, averaged over a few
  // pixels, is better than what the geometry says, and knows what is meant by a pattern's column.
  void find_offset() {
    auto sums = filled<Image2>(burst_.regions.size(), Vec2(0, 0));
    parallel_for(burst_.regions.rows, [&](int y) {
      for (int x = 0; x < burst_.regions.cols; ++x) {
        if (measured(y, x) && has_whole_stripes(burst_, y, x)) sums(y, x) = wave(y, x);
      }
    });
    cv::boxFilter(sums, sums, -1, cv::Size(kPhaseWindow_px, kPhaseWindow_px));
    Image1 turns(sums.size());
    parallel_for(sums.rows, [&](int y) {
      for (int x = 0; x < sums.cols; ++x) {
        turns(y, x) = turns_of(sums(y, x)[1], sums(y, x)[0]);
      }
    });
    offset_turns_ = turns;
    coherence_ = coherence_of(sums, kWitnessStep);
    find_places();
  }

  // How far the stripes' phases agree that the geometry leaves: 1 where they all say the same.
  double coherence() const { return coherence_; }

  std::vector<BinsPerChannel> gather() const {
    std::vector<BinsPerChannel> sum(burst_.region_names.size() - 1);
    std::vector<std::vector<BinsPerChannel>> parts(kParts, sum);
    parallel_for(kParts, [&](int part) {
      for (int y = part; y < burst_.regions.rows; y += kParts) {
        for (int x = 0; x < burst_.regions.cols; ++x) {
          if (!measured(y, x) || !has_whole_stripes(burst_, y, x)) continue;
          add_pixel(y, x, &parts[size_t(part)]);
        }
      }
    });
    for (const auto& part : parts) {
      for (size_t i = 0; i < sum.size(); ++i) {
        for (size_t c = 0; c < 3; ++c) sum[i][c] += part[i][c];
      }
    }
    return sum;
  }

  struct Swing {
    float share;           // A/(FRONT - BLACK)
    float variance;        // with errors of phase and of the model
    float noise_variance;  // of the camera's noise alone
  };

  // Of one pixel: the swing of the region's shape that is nearest to four samples, from where the
  // region's own swing would have it.
  Swing swing(int y, int x, int channel, const StripeShape& shape) const {
    const Place& place = places_(y, x);
    const int row = place[0];
    const float lit = burst_.front_lit(y, x)[channel];
    const float prior = 1 / (kSwingSpread * kSwingSpread);
    float top = shape.swing(row) * prior, bottom = prior, noise = 0;
    if (lit > kShadow && has_whole_stripes(burst_, y, x)) {
      const RelativeLight relative(burst_.projector_noise, lit);
      for (size_t k = 0; k < 4; ++k) {
        const int column = place[int(k) + 1];
        const float g = shape.at(row, column);
        const float value = burst_.stripes[k](y, x)[channel];
        const float off_phase = kPhaseError_turns * shape.slope(row, column);
        const float variance = relative.variance(value);
        const float weight = 1 / (variance + kModelVariance + off_phase * off_phase);
        top += weight * g * relative.swing(value);
        bottom += weight * g * g;
        noise += weight * weight * g * g * variance;
      }
    }
    // Far below its region's: the phase is wrong, as at a silhouette, not the skin.
    if (top / bottom < kLeastOfRegion * shape.swing(row)) return {shape.swing(row), 1 / prior, 0};
    return {std::min(top / bottom, 1.f), 1 / bottom, noise / (bottom * bottom)};
  }

  // Of one pixel's four samples about the half: what of their squares the shape leaves at the swing
  // that suits them best, and all of them; both without the noise's.
  cv::Vec2d misfit(int y, int x, int channel, const StripeShape& shape) const {
    const Place& place = places_(y, x);
    const float lit = burst_.front_lit(y, x)[channel];
    if (lit < 10 * kShadow || !has_whole_stripes(burst_, y, x)) return {0, 0};
    const RelativeLight relative(burst_.projector_noise, lit);
    float squares = 0, along = 0, shapes = 0, noise = 0;
    for (size_t k = 0; k < 4; ++k) {
      const float g = shape.at(place[0], place[int(k) + 1]);
      const float value = burst_.stripes[k](y, x)[channel], off = relative.swing(value);
      squares += off * off;
      along += off * g;
      shapes += g * g;
      noise += relative.variance(value);
    }
    const float told = shapes > 0 ? along * along / shapes : 0;
    return {squares - told - 0.75f * noise, squares - noise};
  }

 private:
  // In the tables of stripes: the row of the frequency, and the column of each pattern's phase.
  using Place = cv::Vec<uchar, 5>;

  // In units of the highest frequency.
  float frequency(int y, int x) const {
    const PatternGradient g = pattern_gradient(
        burst_.session->projector, geometry_.position_mm(y, x), normals_.diffuse[1](y, x));
    return float(length(g.u) / period_px_ / highest_cycles_per_mm_);
  }

  void find_places() {
    places_ = cv::Mat_<Place>(burst_.regions.size());
    parallel_for(places_.rows, [&](int y) {
      for (int x = 0; x < places_.cols; ++x) {
        if (!measured(y, x)) continue;
        Place& place = places_(y, x);
        place[0] = uchar(StripeBins::row(frequency(y, x)));
        for (int k = 0; k < 4; ++k) place[k + 1] = uchar(StripeBins::column(phase(y, x, k)));
      }
    });
  }

  // The first harmonic of the four samples about the phase that the geometry gives.
  Vec2 wave(int y, int x) const {
    Vec2 sum(0, 0);
    for (int k = 0; k < 4; ++k) {
      const float value = mean(burst_.stripes[size_t(k)](y, x) - burst_.front_lit(y, x) * 0.5f);
      const float angle = 2 * kPi * phase(y, x, k);
      sum += Vec2(std::cos(angle), std::sin(angle)) * value;
    }
    return sum;
  }

  // Of a stripes' sample over FRONT's light there.
  class RelativeLight {
   public:
    RelativeLight(const NoiseModel& noise, float lit)
        : noise_(noise), per_lit_(1 / lit), lit_variance_(0.25f * noise.variance(lit)) {}

    float swing(float value) const { return value * per_lit_ - 0.5f; }
    float variance(float value) const {
      return (noise_.variance(value) + lit_variance_) * (per_lit_ * per_lit_);
    }

   private:
    const NoiseModel& noise_;
    float per_lit_, lit_variance_;
  };

  void find_measured() {
    measured_ = Mask(burst_.regions.size());
    parallel_for(measured_.rows, [&](int y) {
      for (int x = 0; x < measured_.cols; ++x) {
        measured_(y, x) = burst_.regions(y, x) && is_finite(geometry_.position_mm(y, x)) &&
                          is_finite(normals_.diffuse[1](y, x)) &&
                          is_finite(geometry_.projector_px(y, x)[0]);
      }
    });
  }

  void add_pixel(int y, int x, std::vector<BinsPerChannel>* bins) const {
    const Place& place = places_(y, x);
    BinsPerChannel& of_region = (*bins)[burst_.regions(y, x) - 1u];
    for (int c = 0; c < 3; ++c) {
      const float lit = burst_.front_lit(y, x)[c];
      if (lit < 10 * kShadow) continue;
      const RelativeLight relative(burst_.projector_noise, lit);
      for (size_t k = 0; k < 4; ++k) {
        const float value = burst_.stripes[k](y, x)[c];
        of_region[size_t(c)].add(place[0], place[int(k) + 1], relative.swing(value),
                                 1 / (relative.variance(value) + kModelVariance));
      }
    }
  }

  const Burst& burst_;
  const Geometry& geometry_;
  const Normals& normals_;
  float period_px_, shift_turns_;
  std::array<Image2, 4> projector_px_;  // of every pattern
  Mask measured_;
  cv::Mat_<Place> places_;
  Image1 offset_turns_;  // white stripe's middle against where the geometry has it
  double highest_cycles_per_mm_;
  double coherence_ = 0;
};

Shapes shapes_of(const Stripes& stripes) {
  const std::vector<BinsPerChannel> bins = stripes.gather();
  const StripeDesign design(stripes.highest_cycles_per_mm(), stripes.blocks());
  Shapes shapes(bins.size());
  parallel_for(int(bins.size() * 3), [&](int i) {
    const size_t region = size_t(i) / 3, c = size_t(i) % 3;
    const Kernel kernel = solve_kernel(bins[region][c].equations(design), 1e-6, kShapeRidge);
    shapes[region][c] = StripeShape(kernel.weight, design);
  });
  return shapes;
}

// Four quarter shifts are two stripes and their complements: twice the evenly lit photograph.
double closure(const Burst& burst) {
  std::vector<cv::Vec2d> rows(size_t(burst.regions.rows), cv::Vec2d(0, 0));  // sum, count
  parallel_for(burst.regions.rows, [&](int y) {
    for (int x = 0; x < burst.regions.cols; ++x) {
      if (!burst.regions(y, x) || !has_whole_stripes(burst, y, x)) continue;
      for (int c = 0; c < 3; ++c) {
        const float lit = burst.front_lit(y, x)[c];
        if (lit < 10 * kShadow) continue;
        float stripes = 0;
        for (const Image3& image : burst.stripes) stripes += image(y, x)[c];
        const double error = stripes / (2 * lit) - 1;
        rows[size_t(y)] += cv::Vec2d(error * error, 1);
      }
    }
  });
  const cv::Vec2d sum = std::accumulate(rows.begin(), rows.end(), cv::Vec2d(0, 0));
  return sum[1] > 0 ? std::sqrt(sum[0] / sum[1]) : 0;
}

// Median over the pixels of the share of their samples' squares that no swing of the stripes
// explains.
double misfit_of(const Burst& burst, const Stripes& stripes, const Shapes& shapes) {
  std::vector<float> shares;
  for (int y = 0; y < burst.regions.rows; y += kWitnessStep) {
    for (int x = 0; x < burst.regions.cols; x += kWitnessStep) {
      if (!stripes.measured(y, x)) continue;
      cv::Vec2d pixel(0, 0);
      for (int c = 0; c < 3; ++c) {
        pixel += stripes.misfit(y, x, c, shapes[burst.regions(y, x) - 1u][size_t(c)]);
      }
      if (pixel[1] > 0) shares.push_back(float(pixel[0] / pixel[1]));
    }
  }
  return shares.empty() ? std::nan("") : std::max(0.f, median_of(&shares));
}

// Shares of every pixel that is measured; the mean over the channels of their variance without the
// noise's goes to `other_variance`.
ShareMap shares_of(const Burst& burst, const Stripes& stripes, const Shapes& shapes,
                   Image1* other_variance) {
  const cv::Size size = burst.regions.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  ShareMap map{filled<Image3>(size, nowhere), filled<Image3>(size, nowhere)};
  *other_variance = filled<Image1>(size, 0.f);
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!stripes.measured(y, x)) continue;
      for (int c = 0; c < 3; ++c) {
        const StripeShape& shape = shapes[burst.regions(y, x) - 1u][size_t(c)];
        const Stripes::Swing swing = stripes.swing(y, x, c, shape);
        map.share(y, x)[c] = swing.share;
        map.noise_variance(y, x)[c] = swing.noise_variance;
        (*other_variance)(y, x) += std::max(0.f, swing.variance - swing.noise_variance) / 3;
      }
    }
  });
  return map;
}

// Of share and rest of a total that have errors of their own.
void put_stddev(const Vec3& share, const Vec3& share_variance, const TotalAtPixel& total,
                Vec3* shallow, Vec3* deep) {
  for (int c = 0; c < 3; ++c) {
    const float rest = 1 - share[c], own = share_variance[c], common = total.noise_variance[c];
    (*shallow)[c] = total.albedo[c] * std::sqrt(own + share[c] * share[c] * common);
    (*deep)[c] = total.albedo[c] * std::sqrt(own + rest * rest * common);
  }
}

// 0 to 1: in a part of a total, given the relative variance of that part's share.
float trust_in_part(float share_variance, const TotalAtPixel& total) {
  const float relative = std::sqrt(share_variance + total.sigma * total.sigma);
  return 1 / (1 + relative / kSigmaAtHalfTrust);
}

// Odd, as a window is.
int detail_px(const Camera& camera) {
  const double px = kDetail_mm / camera.pixel_mm();
  return std::max(3, int(px)) | 1;
}

}  // namespace

Separation separate_layers(const Burst& burst, const Geometry& geometry, const Normals& normals) {
  Separation separation;
  const cv::Size size = burst.regions.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  separation.shallow_albedo = filled<Image3>(size, nowhere);
  separation.deep_albedo = filled<Image3>(size, nowhere);
  separation.shallow_stddev = filled<Image3>(size, nowhere);
  separation.deep_stddev = filled<Image3>(size, nowhere);
  separation.confidence = filled<Image1>(size, 0.f);
  separation.deep_confidence = filled<Image1>(size, 0.f);
  separation.closure_rms = closure(burst);
  Stripes stripes(burst, geometry, normals);
  stripes.find_offset();
  Image1 other_variance;
  const Shapes shapes = shapes_of(stripes);
  separation.stripe_coherence = stripes.coherence();
  separation.stripe_misfit = misfit_of(burst, stripes, shapes);
  ShareMap map = shares_of(burst, stripes, shapes, &other_variance);
  remove_share_noise(burst.regions, int(burst.region_names.size()) - 1,
                     detail_px(burst.session->left), &map);
  const DiffuseTotal total(burst, geometry, normals);
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!stripes.measured(y, x)) continue;
      const TotalAtPixel whole = total.from_both(y, x);
      const Vec3 shallow = map.share(y, x);
      separation.shallow_albedo(y, x) = shallow.mul(whole.albedo);
      separation.deep_albedo(y, x) = (Vec3(1, 1, 1) - shallow).mul(whole.albedo);
      put_stddev(shallow, map.noise_variance(y, x), whole, &separation.shallow_stddev(y, x),
                 &separation.deep_stddev(y, x));
      const float noise = mean(map.noise_variance(y, x)), other = other_variance(y, x);
      separation.confidence(y, x) = trust_in_part(other + noise, whole);
      const float rest = std::max(kLeastRest, 1 - mean(shallow));
      separation.deep_confidence(y, x) =
          trust_in_part((noise + kLeftOfVariance * other) / (rest * rest), whole);
    }
  });
  return separation;
}

}  // namespace lamella::fit
