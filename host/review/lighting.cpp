#include "review/lighting.h"

#include <cstdio>

#include "base/error.h"

namespace lamella::review {

namespace {

const Vec3 kNoLight(0, 0, 0);

// Evenly over a disc of directions (sunflower arrangement).
void add_softbox(const Softbox& box, std::vector<DistantLight>* lights) {
  if (box.lights == 0 || length(box.colour) <= 0.f) return;
  const Vec3 axis = unit(box.direction);
  const Vec3 side = unit(cross(std::abs(axis[1]) > 0.9f ? Vec3(1, 0, 0) : Vec3(0, 1, 0), axis));
  const Vec3 up = cross(axis, side);
  constexpr float kGoldenAngle = 2.39996323f;
  for (int i = 0; i < box.lights; ++i) {
    const float r = box.radius_rad * std::sqrt((float(i) + 0.5f) / float(box.lights));
    const float turn = kGoldenAngle * float(i);
    const Vec3 d = axis * std::cos(r) + (side * std::cos(turn) + up * std::sin(turn)) * std::sin(r);
    lights->push_back({unit(d), box.colour * (1.f / float(box.lights))});
  }
}

}  // namespace

Lighting portrait_lighting() {
  Lighting l;
  l.key = {{0.62f, 0.50f, 0.72f}, {1.06f, 0.99f, 0.90f}, 0.20f, 7};
  l.fill = {{-0.80f, 0.02f, 0.65f}, {0.075f, 0.080f, 0.090f}, 0.40f, 5};
  l.left_rim = {{-0.80f, 0.42f, -0.62f}, {0.95f, 1.02f, 1.15f}, 0.14f, 3};
  l.right_rim = {{0.95f, 0.20f, -0.50f}, {0.25f, 0.28f, 0.33f}, 0.12f, 2};
  l.dome = {{0.0f, 0.6f, 0.8f}, {0.075f, 0.078f, 0.086f}, 1.05f, 7};
  return l;
}

Lighting single_light(const Vec3& direction) {
  const Softbox none{{0, 0, 1}, kNoLight, 0.f, 0};
  return {{unit(direction), {1, 1, 1}, 0.f, 1}, none, none, none, none};
}

Lighting lighting_named(const std::string& name) {
  if (name == "portrait") return portrait_lighting();
  if (name == "front") return single_light({0, 0, 1});
  if (name == "side") return single_light({-1, 0.2f, 0.25f});
  Vec3 d;
  char rest = 0;
  if (std::sscanf(name.c_str(), "%f,%f,%f%c", &d[0], &d[1], &d[2], &rest) != 3 || !is_finite(d) ||
      length(d) < 1e-6f) {
    throw_bad_input("--light", "\"" + name + "\" is no light",
                    "give portrait, front, side or a direction x,y,z");
  }
  return single_light(d);
}

std::vector<DistantLight> lights_of(const Lighting& l) {
  std::vector<DistantLight> lights;
  for (const Softbox& box : {l.key, l.fill, l.left_rim, l.right_rim, l.dome}) {
    add_softbox(box, &lights);
  }
  return lights;
}

}  // namespace lamella::review
