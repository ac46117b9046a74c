#include "fit/diffuse_total.h"

#include <algorithm>
#include <array>

namespace lamella::fit {

namespace {

constexpr float kNormalError_rad = 0.05f;  // of the specular normal, 3 degrees
constexpr float kLedError = 0.015f;        // relative, where nothing is hidden
constexpr float kShadeError = 0.25f;       // of what is hidden: light bounced from the blockers
constexpr float kSmallestCosine = 0.02f;
constexpr float kSmallestVisibility = 0.05f;
constexpr float kBrightest = 1.f;
constexpr int kCeilingStep_px = 3;
constexpr float kKnownSigma = 0.03f;
constexpr size_t kFewestKnown = 100;
constexpr float kAboveKnown = 1.2f;
constexpr float kClippedError = 10;  // relative: next to the other light, no weight
constexpr float kDarkest = 1e-4f;    // albedo whose logarithm is still taken

float relative_variance(float variance, float radiance) {
  const float lit = std::max(radiance, kDarkest);
  return variance / (lit * lit);
}

}  // namespace

DiffuseTotal::DiffuseTotal(const Burst& burst, const Geometry& geometry, const Normals& normals)
    : burst_(burst),
      geometry_(geometry),
      normals_(normals),
      leds_(led_irradiance_over(burst.session->stage, geometry.position_mm,
                                burst.quality.irradiance_cells)),
      ceiling_(burst.region_names.size(), Vec3(kBrightest, kBrightest, kBrightest)) {
  find_ceilings();
}

// Where both ways are sure, the irradiance is known: what skin of the region reflects there.
void DiffuseTotal::find_ceilings() {
  std::vector<std::array<std::vector<float>, 3>> known(ceiling_.size());
  for (int y = 0; y < burst_.regions.rows; y += kCeilingStep_px) {
    for (int x = 0; x < burst_.regions.cols; x += kCeilingStep_px) {
      if (!burst_.regions(y, x) || !is_finite(geometry_.position_mm(y, x))) continue;
      const TotalAtPixel total = from_both(y, x);
      if (!(total.sigma < kKnownSigma)) continue;
      for (int c = 0; c < 3; ++c) {
        known[burst_.regions(y, x)][size_t(c)].push_back(total.albedo[c]);
      }
    }
  }
  for (size_t label = 1; label < known.size(); ++label) {
    for (int c = 0; c < 3; ++c) {
      std::vector<float>& values = known[label][size_t(c)];
      if (values.size() < kFewestKnown) continue;
      const auto high = values.begin() + std::ptrdiff_t(values.size() * 49 / 50);
      std::nth_element(values.begin(), high, values.end());
      ceiling_[label][c] = std::min(kBrightest, kAboveKnown * *high);
    }
  }
}

void DiffuseTotal::limit(int y, int x, TotalAtPixel* total) const {
  const Vec3& ceiling = ceiling_[burst_.regions(y, x)];
  float excess = 1;
  for (int c = 0; c < 3; ++c) excess = std::max(excess, total->albedo[c] / ceiling[c]);
  total->albedo *= 1 / excess;
  total->sigma += excess - 1;
}

Vec3 DiffuseTotal::normal(int y, int x) const {
  const Vec3& n = normals_.specular(y, x);
  return is_finite(n) ? n : normals_.diffuse[1](y, x);
}

TotalAtPixel DiffuseTotal::from_leds(int y, int x) const {
  const float visible = std::max(normals_.ambient_visibility(y, x), kSmallestVisibility);
  const Vec3 light = leds_.at(normal(y, x), geometry_.position_mm(y, x)) * visible;
  TotalAtPixel total;
  for (int c = 0; c < 3; ++c) {
    const float radiance = burst_.full.cross(y, x)[c];
    total.albedo[c] = 2 * radiance / std::max(light[c], 1e-3f);
    total.noise_variance[c] = relative_variance(burst_.led_noise.variance(radiance), radiance);
  }
  total.sigma = kLedError + kShadeError * (1 - visible) / visible;
  if (is_clipped(burst_.clipped_led_cross, y, x)) total.sigma += kClippedError;
  limit(y, x, &total);
  return total;
}

TotalAtPixel DiffuseTotal::from_projector(int y, int x) const {
  const float cosine = dot(normal(y, x), geometry_.to_projector(y, x));
  const float clamped = std::max(cosine, kSmallestCosine);
  const float light = (1 - burst_.black_level) * geometry_.projector_irradiance(y, x) * clamped;
  const float sine = std::sqrt(std::max(0.f, 1 - clamped * clamped));
  TotalAtPixel total{
      burst_.front_lit(y, x) * (2 / light), kLedError + kNormalError_rad * sine / clamped, {}};
  if (is_clipped(burst_.clipped_projector, y, x)) total.sigma += kClippedError;
  const float dark = burst_.projector_noise.variance(0);  // of BLACK, which hardly has photons
  for (int c = 0; c < 3; ++c) {
    const float radiance = burst_.front_lit(y, x)[c];
    total.noise_variance[c] =
        relative_variance(burst_.projector_noise.variance(radiance) + dark, radiance);
  }
  limit(y, x, &total);
  return total;
}

TotalAtPixel DiffuseTotal::from_both(int y, int x) const {
  const TotalAtPixel leds = from_leds(y, x), projector = from_projector(y, x);
  const float a = 1 / (leds.sigma * leds.sigma), b = 1 / (projector.sigma * projector.sigma);
  TotalAtPixel both;
  both.sigma = std::sqrt(1 / (a + b));
  for (int c = 0; c < 3; ++c) {
    const float p = std::max(leds.albedo[c], kDarkest), q = std::max(projector.albedo[c], kDarkest);
    both.albedo[c] = std::exp((a * std::log(p) + b * std::log(q)) / (a + b));
    both.noise_variance[c] =
        (a * a * leds.noise_variance[c] + b * b * projector.noise_variance[c]) /
        ((a + b) * (a + b));
  }
  return both;
}

}  // namespace lamella::fit
