// What a pixel shows of its surface under GRADIENT_FULL: eq. 1 and eq. 3 summed over the LEDs that
// are really there and really reach it.
#pragma once

#include <array>
#include <vector>

#include "fit/light_visibility.h"
#include "model/lobe.h"
#include "model/transmittance.h"

namespace lamella::fit {

// An LED from where it is seen: unit direction, and radiance of white facing it, mean of the
// channels.
struct SeenLed {
  Vec3 direction;
  float radiance = 0;
};

// A point of the surface, with unit vectors.
struct SurfacePoint {
  Vec3 position_mm, normal, to_camera;
};

// The LEDs as the surface sees them within one cell of LightVisibility::step_px() pixels squared,
// as separate arrays, padded with lights of no strength to a whole number of vector registers.
// Those that the surface faces most come first.
struct LedCell {
  static constexpr size_t kLanes = 8;
  SurfacePoint point;  // of one pixel of the cell
  LightVisibility::Corners corners{};
  std::vector<SeenLed> near;  // by number; of LEDs that have a distance
  std::vector<size_t> led;    // numbers, by the upper bound of their cosine to the normal
  std::vector<float> facing;  // which is this, falling
  // Of as many lights as any pixel entered yet has above its horizon.
  size_t known = 0;
  std::vector<float> x, y, z;               // unit, towards the light
  std::vector<float> radiance;              // of white facing it, mean of the channels
  std::array<std::vector<float>, 4> share;  // of it that reaches each corner
  size_t open = 0;                          // so many of the first reach them all
  // From light and camera alone, which hardly turn within a cell: l.v, 1/(v.h), Fresnel at v.h.
  std::vector<float> l_v, per_v_h, fresnel;
  // At the pixel entered last: radiance x share, of as many lights as may be above its horizon.
  std::vector<float> reached;
  size_t used = 0;
};

class LedField {
 public:
  LedField(const LightStage& stage, const LightVisibility& visibility);

  // The cell that pixel (x, y) is in, as it is seen there.
  void enter_cell(int y, int x, const SurfacePoint& point, LedCell* cell) const;

  // What reaches a pixel of that cell whose normal is `n`.
  void enter_pixel(int y, int x, const Vec3& n, LedCell* cell) const;

 private:
  std::vector<SeenLed> seen_from(const Vec3& x_mm) const;
  void know(size_t count, LedCell* cell) const;

  const LightStage& stage_;
  const LightVisibility& visibility_;
  std::vector<SeenLed> far_;  // by number; none where an LED has a distance
};

struct LedResponse {
  float lobe = 0;    // W: radiance of the lobe with c = 1
  float single = 0;  // radiance of single scattering with amplitude 1
  float share = 0;   // of the light above the horizon, cosine weighted, that reaches the pixel
};

// The skin of one region, ready for evaluation.
struct SkinModel {
  model::LobeTable lobe;
  model::TransmittanceTable transmittance;
  float g = 0.65f;
};

// At the pixel that `cell` entered last, with the same `n`. `n`, `v` unit; 0 where the camera is
// below the surface.
LedResponse led_response(const LedCell& cell, const SkinModel& skin, const Vec3& n, const Vec3& v);

// LEDs lower than this above the surface are left out: eq. 1 has no limit at the horizon.
inline constexpr float kLedHorizon = 0.02f;

}  // namespace lamella::fit
