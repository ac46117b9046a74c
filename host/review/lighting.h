// The lights of a portrait: softboxes made of a few distant lights each, so that their shadows and
// highlights are soft.
#pragma once

#include <string>
#include <vector>

#include "base/vec.h"

namespace lamella::review {

struct DistantLight {
  Vec3 direction;  // unit, towards the light, rig frame
  Vec3 colour;     // radiance of a white surface that faces it
};

struct Softbox {
  Vec3 direction;
  Vec3 colour;       // all of its lights together
  float radius_rad;  // as seen from the face
  int lights;
};

struct Lighting {
  Softbox key, fill, left_rim, right_rim, dome;
};

inline constexpr int kMostLights = 24;

// The key from above the right, a dim fill, two cool rims from behind, a little from everywhere.
Lighting portrait_lighting();

// One hard light, nothing else.
Lighting single_light(const Vec3& direction);

// "portrait", "front", "side", or the three numbers x,y,z of a direction. Throws Error.
Lighting lighting_named(const std::string& name);

// At most kMostLights.
std::vector<DistantLight> lights_of(const Lighting& lighting);

}  // namespace lamella::review
