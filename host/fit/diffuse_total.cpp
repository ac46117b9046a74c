#include "fit/diffuse_total.h"

#include <algorithm>

namespace lamella::fit {

namespace {

constexpr float kNormalError_rad = 0.05f;   // of the specular normal, 3 degrees
constexpr float kLedError = 0.015f;         // relative, where nothing is hidden
constexpr float kShadeError = 0.25f;        // of what is hidden: light bounced from the blockers
constexpr float kSmallestCosine = 0.02f;
constexpr float kSmallestVisibility = 0.05f;
constexpr float kDarkest = 1e-4f;           // albedo whose logarithm is still taken

}  // namespace

DiffuseTotal::DiffuseTotal(const Burst& burst, const Geometry& geometry, const Normals& normals)
    : burst_(burst),
      geometry_(geometry),
      normals_(normals),
      leds_(led_irradiance_over(burst.session->stage, geometry.position_mm)) {}

Vec3 DiffuseTotal::normal(int y, int x) const {
  const Vec3& n = normals_.specular(y, x);
  return is_finite(n) ? n : normals_.diffuse[1](y, x);
}

TotalAtPixel DiffuseTotal::from_leds(int y, int x) const {
  const float visible = std::max(normals_.ambient_visibility(y, x), kSmallestVisibility);
  const Vec3 light = leds_.at(normal(y, x), geometry_.position_mm(y, x)) * visible;
  TotalAtPixel total;
  for (int c = 0; c < 3; ++c) {
    total.albedo[c] = 2 * burst_.full.cross(y, x)[c] / std::max(light[c], 1e-3f);
  }
  total.sigma = kLedError + kShadeError * (1 - visible) / visible;
  return total;
}

TotalAtPixel DiffuseTotal::from_projector(int y, int x) const {
  const float cosine = dot(normal(y, x), geometry_.to_projector(y, x));
  const float clamped = std::max(cosine, kSmallestCosine);
  const float light = (1 - burst_.black_level) * geometry_.projector_irradiance(y, x) * clamped;
  const float sine = std::sqrt(std::max(0.f, 1 - clamped * clamped));
  return {burst_.front_lit(y, x) * (2 / light), kLedError + kNormalError_rad * sine / clamped};
}

TotalAtPixel DiffuseTotal::from_both(int y, int x) const {
  const TotalAtPixel leds = from_leds(y, x), projector = from_projector(y, x);
  const float a = 1 / (leds.sigma * leds.sigma), b = 1 / (projector.sigma * projector.sigma);
  TotalAtPixel both;
  both.sigma = std::sqrt(1 / (a + b));
  for (int c = 0; c < 3; ++c) {
    const float p = std::max(leds.albedo[c], kDarkest), q = std::max(projector.albedo[c], kDarkest);
    both.albedo[c] = std::exp((a * std::log(p) + b * std::log(q)) / (a + b));
  }
  return both;
}

}  // namespace lamella::fit
