#include "base/filled.h"
#include "base/parallel.h"
#include "fit/diffuse_total.h"
#include "fit/scattering.h"

namespace lamella::fit {

namespace {

constexpr float kSigmaAtHalfConfidence = 0.1f;

}  // namespace

Albedo fit_albedo(const Burst& burst, const Geometry& geometry, const Normals& normals) {
  Albedo albedo;
  const cv::Size size = burst.regions.size();
  albedo.total = filled<Image3>(size, Vec3(kNaN, kNaN, kNaN));
  albedo.confidence = filled<Image1>(size, 0.f);
  const DiffuseTotal total(burst, geometry, normals);
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!burst.regions(y, x) || !is_finite(geometry.position_mm(y, x))) continue;
      const bool clipped = is_clipped(burst.clipped_led_cross, y, x);
      const TotalAtPixel whole = clipped ? total.from_both(y, x) : total.from_leds(y, x);
      albedo.total(y, x) = whole.albedo;
      albedo.confidence(y, x) = 1 / (1 + whole.sigma / kSigmaAtHalfConfidence);
    }
  });
  return albedo;
}

}  // namespace lamella::fit
