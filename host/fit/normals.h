// Step 3, normals: from the gradients (Ma et al. 2007), by inverting the sum over the LEDs that are
// really there, merged with the stereo surface.
#pragma once

#include "fit/geometry.h"
#include "fit/led_gains.h"
#include "fit/surroundings.h"

namespace lamella::fit {

struct Normals {
  Image3 specular;                // unit, rig frame
  std::array<Image3, 3> diffuse;  // per channel: a Lambertian surface's with the same D
  Image1 specular_confidence;     // 0 to 1
  Image1 diffuse_confidence;
  Image1 ambient_visibility;  // share of the LED light (cosine-weighted) that reaches the pixel
  LedGains led_gains;
  Surroundings around;  // without a node: nothing hides anything
};

// Also improves `geometry` where the normals know better than stereo (Nehab et al. 2005).
// Whoever gives away the only `burst` that has its gradients has their memory back before the rest
// is done.
Normals estimate_normals(Burst burst, Geometry* geometry);

// That improvement alone, by any diffuse normals, believed as far as their confidence says: gaps
// are filled again along them, and depths and normals are reconciled.
void merge_with_normals(const Burst& burst, const Normals& normals, Geometry* geometry);

}  // namespace lamella::fit
