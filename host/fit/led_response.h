// What a pixel shows of its surface under GRADIENT_FULL: eq. 1 and eq. 3 summed over the LEDs that
// are really there and really reach it.
#pragma once

#include <array>
#include <vector>

#include "fit/light_visibility.h"
#include "model/lobe.h"
#include "model/transmittance.h"

namespace lamella::fit {

// The LEDs as one point sees them, those that do not reach it left out: directions and strengths as
// separate arrays, padded with lights of no strength to a whole number of vector registers.
struct LightsAtPoint {
  static constexpr size_t kLanes = 8;
  std::vector<float> x, y, z;   // unit, towards the light
  std::vector<float> radiance;  // of white facing it, mean of the channels, share that reaches
  size_t count = 0;

  void clear();
  void add(const Vec3& direction, float radiance_facing);
  void pad();
};

// Looks LEDs up by pixel: directions and strengths are constant over a node's cell, the share that
// reaches a pixel is interpolated within it.
class LedField {
 public:
  LedField(const LightStage& stage, const LightVisibility& visibility)
      : stage_(stage), visibility_(visibility) {}

  // One cell of kStep x kStep pixels around a point of the surface.
  struct Cell {
    std::vector<Vec3> direction;
    std::vector<float> radiance;
    std::array<std::vector<float>, 4> share;  // at the corners
  };
  void enter_cell(int y, int x, const Vec3& position_mm, Cell* cell) const;

  // Lights above the horizon of `normal` that reach a pixel of that cell. Returns the share, cosine
  // weighted, of the light above the horizon that they are.
  float lights_at(const Cell& cell, int y, int x, const Vec3& normal, LightsAtPoint* lights) const;

 private:
  const LightStage& stage_;
  const LightVisibility& visibility_;
};

struct LedResponse {
  float lobe = 0;    // W: radiance of the lobe with c = 1
  float single = 0;  // radiance of single scattering with amplitude 1
};

// The skin of one region, ready for evaluation.
struct SkinModel {
  model::LobeTable lobe;
  model::TransmittanceTable transmittance;
  float g = 0.65f;
};

// `n`, `v` unit; 0 where the camera is below the surface.
LedResponse led_response(const LightsAtPoint& lights, const SkinModel& skin, const Vec3& n,
                         const Vec3& v);

}  // namespace lamella::fit
