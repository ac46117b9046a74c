// The lights of a view as a list of samples: far directions and near points.
//
// Unit everywhere: the radiance that a white Lambertian surface facing the light shows, so that the
// cosine-weighted sum over samples is the radiance of a white surface.
#pragma once

#include <vector>

#include "io/session.h"
#include "io/view.h"

namespace lamella::render {

// Light of one sample as it reaches one point.
struct Incident {
  Vec3 direction;     // unit, from the point towards the light
  Vec3 irradiance;    // rgb, as if the surface faced it
  float distance_mm;  // how far a shadow ray must look
};

struct LightSample {
  bool far = false;     // `place` is a unit direction, else a position in mm
  bool framed = false;  // shines through the projector's frame only
  Vec3 place;
  Vec3 strength;  // far: irradiance; near: irradiance times distance_mm squared
};

class Lights {
 public:
  // An environment map becomes about `environment_cells` directions: its sphere is cut into cells
  // of equal solid angle, each with all the light of its texels, at their luminance-weighted mean
  // direction. Map convention: centre +Z, up +Y, seen from inside, so that the right half is -X.
  Lights(const View& view, const LightStage& stage, const Camera& projector, int environment_cells);

  size_t size() const { return samples_.size(); }

  // Light of sample `i` at `x_mm`, shadows aside. Irradiance 0 outside the projector's frame.
  Incident at(size_t i, const Vec3& x_mm) const;

  Vec3 irradiance_at_origin(size_t i) const { return at(i, Vec3(0, 0, 0)).irradiance; }

 private:
  void add_leds(const Light& light, const LightStage& stage);

  std::vector<LightSample> samples_;
  Camera projector_;
};

// The directions that stand for a latitude-longitude image; irradiance is radiance times the
// cell's solid angle over pi.
std::vector<LightSample> cut_environment(const Image3& lat_long, int cells);

}  // namespace lamella::render
