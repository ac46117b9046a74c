// The subject in front of the rig's two cameras: photographs of any exposure, remembering what it
// has seen under each state of the light.
#pragma once

#include <list>
#include <vector>

#include "twin/exposure.h"
#include "twin/photographer.h"
#include "twin/sensor.h"

namespace lamella::twin {

struct RawPhotograph {
  RawImage raw;
  Vec3 radiance_scale{1, 1, 1};
};

class Studio {
 public:
  // `seed`: of the sensor's noise.
  Studio(const Photographer& photographer, uint64_t seed);

  // The same sensor before a subject that has moved.
  Studio with(const Photographer& moved) const { return {moved, seed_}; }

  // One photograph; `serial` makes its noise its own.
  RawPhotograph take(const Exposure& exposure, uint64_t serial);

  // Works out the depolarized light of states that will be asked for, several at once.
  void prepare(int camera, const std::vector<LightState>& lights);

  // Radiance of an exposure without sensor, in the colours of the light that was on.
  Image3 radiance(const Exposure& exposure);

 private:
  // What a camera sees of one state; S only where it was needed.
  struct Seen {
    int camera;
    LightState light;
    Radiance depolarized, polarized;
  };

  Seen& seen(int camera, const LightState& light);
  std::vector<float> levels_of(const LightState& light) const;
  PatchLight light_on_surface(const LightState& light) const;
  Radiance polarized(int camera, const LightState& light) const;
  Image3 emitted_by(const LightState& light) const;
  const Receivers& receivers(int camera) const;

  const Photographer& photographer_;
  uint64_t seed_;
  std::list<Seen> memory_;  // newest first
};

// Levels of an LED pattern as 12-bit codes.
LightState led_state(const std::vector<float>& levels);

// Stored units of a photograph are radiance over this: so chosen per kind of light that skin uses
// the sensor's range and only highlights clip.
Vec3 radiance_scale(const Exposure& exposure);

}  // namespace lamella::twin
