// A subject: a shape, where its regions lie, and how its skin varies, all as functions of position.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "base/vec.h"
#include "twin/skin.h"

namespace lamella::twin {

using RegionWeights = std::array<float, kRegionCount>;  // sum 1

struct Subject {
  std::string name;
  std::function<float(const Vec3&)> distance_mm;  // signed, negative inside
  std::function<RegionWeights(const Vec3&)> regions;
  std::function<bool(const Vec3&)> labelled;               // is it skin that truth describes?
  std::function<Vec3(const Vec3&)> albedo_modulation;      // of depolarized light, rgb, about 1
  std::function<float(const Vec3&)> intensity_modulation;  // of c, about 1
  std::function<Vec3(const Vec3&, const Vec3&)> shading_normal;  // position, normal -> normal

  // Where rays start that find the surface from outside: the centre, and for a lower, cylindrical
  // part an axis of this length below it; 0 for a subject that is one star about its centre.
  Vec3 centre_mm{0, 0, 0};
  float axis_length_mm = 0;
};

// Throws Error where the twin has no subject of this name: "head" or "sphere".
void require_subject(const std::string& name);

Subject make_subject(const std::string& name, uint64_t seed);

Subject make_head(uint64_t seed);
Subject make_sphere(uint64_t seed);

// Label of the strongest region, 1 to 6.
int strongest_region(const RegionWeights& weights);

}  // namespace lamella::twin
