#include "fit/intensity.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "base/filled.h"
#include "base/parallel.h"
#include "model/single_scattering.h"
#include "model/torrance_sparrow.h"

namespace lamella::fit {

namespace {

constexpr float kIntensityMinCosine = 0.05f;  // towards camera and projector
constexpr float kLedModelError = 0.08f;       // relative, of W: errors of the lobe in it
constexpr float kLedNormalError = 0.06f;      // radians, and what of the lobe's tail grows alike
constexpr float kShadowError = 2.f;       // relative, of W, per share of the light that is hidden
constexpr float kStrayError = 0.03f;      // light from other skin, relative to an open pixel's
constexpr float kFrontModelError = 0.1f;  // relative, of p at its peak
constexpr float kNormalError = 0.1f;      // radians, on the flank of p
constexpr float kSingleError = 0.1f;      // relative, of single scattering under the projector
constexpr int kNeighbourhoodPx = 31;
constexpr float kLocalSpread = 0.25f;  // of c within a neighbourhood, relative
constexpr float kRegionWeight = 1.f;   // of the region's c in a neighbourhood, in pixels' weights

struct ResponseMaker {
  const Burst& burst;
  const Geometry& geometry;
  const Normals& normals;
  const LightVisibility& visibility;
  const std::vector<SkinModel>& skins;
  LedField field;
  Responses* out;

  void front(int y, int x, const SkinModel& skin) const {
    const Vec3 n = normals.specular(y, x), v = geometry.to_camera(y, x);
    const Vec3 l = geometry.to_projector(y, x), h = unit(l + v);
    const float n_l = dot(n, l), n_v = dot(n, v), v_h = dot(v, h), n_h = dot(n, h);
    const float share = visibility.projector_share(y, x);
    if (n_l < kIntensityMinCosine || n_v < kIntensityMinCosine || share <= 0) return;
    const float radiance = kPi * share * geometry.projector_irradiance(y, x);
    out->front_lobe(y, x) = radiance * model::lobe_times_cosine(skin.lobe, n_h, n_v, n_l, v_h);
    out->front_single(y, x) =
        radiance * n_l * model::single_scattering(skin.transmittance, skin.g, n, l, v);
    const float theta = std::acos(std::min(1.f, n_h)), step = 0.02f;
    const float nearer = skin.lobe.density(std::cos(std::max(0.f, theta - step)));
    const float farther = skin.lobe.density(std::cos(theta + step));
    out->front_slope(y, x) =
        nearer > 0 ? 2 * (nearer - farther) / (nearer + farther) / (2 * step) : 0;
  }

  // W falls as 1/(n.v) does: by tan(theta_v) per radian.
  static float slope_of(float n_v) {
    const float cosine = std::max(n_v, kIntensityMinCosine);
    return std::sqrt(std::max(0.f, 1 - cosine * cosine)) / cosine;
  }

  void pixel(int y, int x, const LedCell& cell) const {
    const SkinModel& skin = skins[size_t(burst.regions(y, x) - 1)];
    const Vec3 n = normals.specular(y, x);
    const LedResponse led = led_response(cell, skin, n, geometry.to_camera(y, x));
    out->led_share(y, x) = led.share;
    out->led_lobe(y, x) = led.lobe;
    out->led_single(y, x) = led.single;
    out->led_slope(y, x) = slope_of(dot(n, geometry.to_camera(y, x)));
    out->front_lobe(y, x) = out->front_single(y, x) = out->front_slope(y, x) = 0;
    front(y, x, skin);
  }

  void cells(int cell_row) const {
    const int step = visibility.step_px();
    const cv::Size size = burst.regions.size();
    LedCell cell;
    for (int x0 = 0; x0 < size.width; x0 += step) {
      bool entered = false;
      for (int y = cell_row * step; y < std::min(size.height, (cell_row + 1) * step); ++y) {
        for (int x = x0; x < std::min(size.width, x0 + step); ++x) {
          if (!burst.regions(y, x) || !is_finite(geometry.position_mm(y, x))) continue;
          const Vec3 n = normals.specular(y, x);
          if (!is_finite(n)) continue;
          if (!entered) {
            field.enter_cell(y, x, {geometry.position_mm(y, x), n, geometry.to_camera(y, x)},
                             &cell);
          }
          entered = true;
          field.enter_pixel(y, x, n, &cell);
          pixel(y, x, cell);
        }
      }
    }
  }
};

float square(float a) { return a * a; }

// The weight of a measurement of c, one over its variance, and c times that; 0 where there is none.
// On the flank of a narrow lobe c itself is a quotient of two nothings.
struct Evidence {
  float weighted_c = 0, weight = 0;
  float noise_variance = 0;  // of `weighted_c`
};

class Weigher {
 public:
  Weigher(const Burst& burst, const Responses& responses, const std::vector<RegionFit>& fits)
      : burst_(burst), responses_(responses), fits_(fits) {}

  Evidence from_leds(int y, int x) const {
    const float gain = responses_.led_lobe(y, x);
    if (!(gain > 0) || is_clipped(burst_.clipped_led, y, x)) return {};
    const float share = responses_.led_share(y, x);
    const float open = expected(y, x, gain) / std::max(0.02f, share);
    const float model = square(kLedModelError) + square(kShadowError * (1 - share)) +
                        square(kLedNormalError * responses_.led_slope(y, x));
    const float single = amplitude(fit(y, x)) * responses_.led_single(y, x);
    return evidence(y, x, {burst_.full, burst_.led_parallel_noise, burst_.led_noise, gain, single},
                    model * square(expected(y, x, gain)) + square(kStrayError * open));
  }

  Evidence from_front(int y, int x) const {
    const float gain = responses_.front_lobe(y, x);
    if (!(gain > 0) || is_clipped(burst_.clipped_projector, y, x)) return {};
    const float model =
        square(kFrontModelError) + square(kNormalError * responses_.front_slope(y, x));
    const float single = amplitude(fit(y, x)) * responses_.front_single(y, x);
    return evidence(
        y, x, {burst_.front, burst_.front_parallel_noise, burst_.projector_noise, gain, single},
        model * square(expected(y, x, gain)) + square(kSingleError * single));
  }

 private:
  // A pixel under one light: radiance of S per c, and of single scattering.
  struct Lit {
    const AnalyserPair& photographs;
    const NoiseModel &parallel_noise, &cross_noise;
    float gain, single;
  };

  Evidence evidence(int y, int x, const Lit& lit, float model_variance) const {
    const Vec3 cross = lit.photographs.cross(y, x);
    const float s = mean(lit.photographs.parallel(y, x) - cross);
    const float radiance = mean(cross), polarized = expected(y, x, lit.gain) + lit.single;
    const float noise_variance =
        (lit.parallel_noise.variance(radiance + polarized) + lit.cross_noise.variance(radiance)) /
        3;
    const float variance = noise_variance + model_variance;
    return {lit.gain * (s - lit.single) / variance, square(lit.gain) / variance,
            square(lit.gain / variance) * noise_variance};
  }

  const RegionFit& fit(int y, int x) const { return fits_[size_t(burst_.regions(y, x) - 1)]; }

  // Of S: the region's c, not the pixel's, so that noise does not choose its own weight.
  float expected(int y, int x, float gain) const { return float(fit(y, x).intensity) * gain; }

  static float amplitude(const RegionFit& fit) {
    double sum = 0;
    for (double a : fit.single.amplitude) sum += a;
    return float(sum / 3);
  }

  const Burst& burst_;
  const Responses& responses_;
  const std::vector<RegionFit>& fits_;
};

}  // namespace

Responses skin_responses(const Burst& burst, const Geometry& geometry, const Normals& normals,
                         const LightVisibility& visibility, const std::vector<SkinModel>& skins) {
  Responses out;
  for (Image1* map : {&out.led_lobe, &out.led_single, &out.front_lobe, &out.front_single,
                      &out.led_share, &out.front_slope, &out.led_slope}) {
    *map = filled<Image1>(burst.regions.size(), kNaN);
  }
  const ResponseMaker maker{burst,      geometry, normals,
                            visibility, skins,    LedField(burst.session->stage, visibility),
                            &out};
  const int cell_rows = (burst.regions.rows - 1) / visibility.step_px() + 1;
  parallel_for(cell_rows, [&](int i) { maker.cells(i); });
  return out;
}

IntensityMap estimate_intensity(const Burst& burst, const Responses& responses,
                                const std::vector<RegionFit>& fits) {
  const cv::Size size = burst.regions.size();
  Image1 weight(size, 0.f), weighted(size, 0.f), noise_variance(size, 0.f);
  const Weigher weigher(burst, responses, fits);
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!burst.regions(y, x)) continue;
      const Evidence leds = weigher.from_leds(y, x), front = weigher.from_front(y, x);
      weight(y, x) = leds.weight + front.weight;
      weighted(y, x) = leds.weighted_c + front.weighted_c;
      noise_variance(y, x) = leds.noise_variance + front.noise_variance;
    }
  });
  Image1 local_weight, local_weighted;
  const cv::Size window(kNeighbourhoodPx, kNeighbourhoodPx);
  cv::blur(weight, local_weight, window);
  cv::blur(weighted, local_weighted, window);
  IntensityMap map{filled<Image1>(size, kNaN), filled<Image1>(size, 0.f),
                   filled<Image1>(size, kNaN)};
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      // Where no surface is known, as of a label in the dark, a region's c is nobody's.
      if (!burst.regions(y, x) || !is_finite(responses.led_lobe(y, x))) continue;
      const float typical = std::max(1e-4f, float(fits[size_t(burst.regions(y, x) - 1)].intensity));
      const float least = kRegionWeight / square(kLocalSpread * typical);
      const float local = (local_weighted(y, x) + least * typical) / (local_weight(y, x) + least);
      const float prior = 1.f / square(kLocalSpread * std::max(local, 0.1f * typical));
      const float total = weight(y, x) + prior;
      const float c = (weighted(y, x) + prior * local) / total;
      map.c(y, x) = std::max(0.f, c);
      // Without light of its own it has only what is known of its neighbourhood.
      map.stddev(y, x) =
          weight(y, x) > 0 ? std::sqrt(noise_variance(y, x)) / total : 1 / std::sqrt(total);
      // Of its neighbours' c: noise must not choose its own confidence.
      const float relative = 1.f / (std::sqrt(total) * std::max(local, 0.1f * typical));
      map.confidence(y, x) = 1.f / (1.f + relative);
    }
  });
  return map;
}

}  // namespace lamella::fit
