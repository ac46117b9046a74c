// S: light that keeps its polarization, reflected at the surface (eq. 1) or scattered once (eq. 3).
#pragma once

#include <vector>

#include "model/lobe.h"
#include "model/transmittance.h"
#include "render/lights.h"
#include "render/subject.h"

namespace lamella::render {

// What a point of skin does to light, all that varies over the face.
struct SkinPoint {
  int region = 0;              // label
  Vec3 normal;                 // unit
  Vec3 to_camera;              // unit
  float intensity = 0;         // c of eq. 1
  Vec3 single_alpha{0, 0, 0};  // of eq. 3 as printed
};

class Reflection {
 public:
  explicit Reflection(const Subject& subject);

  // Radiance towards the camera of light `incident` that nothing shades. Without a lobe (a region
  // whose specular layer was dropped) the surface reflects nothing, likewise for single scattering.
  Vec3 radiance(const SkinPoint& point, const Incident& incident) const;

 private:
  struct Region {
    bool has_lobe = false;
    model::LobeTable lobe;
    model::TransmittanceTable transmittance;
  };

  std::vector<Region> regions_;  // by label
  Vec3 g_;
};

// alpha of eq. 3 at every label and channel, from the regions' amplitudes and the global g; for
// pixels without an alpha of their own.
Vec3 region_single_alpha(const Subject& subject, int label);

}  // namespace lamella::render
