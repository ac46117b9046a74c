// A view file: a camera and its lights (`lamella.v1.View` as proto3 JSON).
#pragma once

#include <string>
#include <vector>

#include "base/camera.h"
#include "io/exr.h"

namespace lamella {

struct Light {
  enum class Kind { kPoint, kLeds, kProjector, kEnvironment };
  Kind kind = Kind::kPoint;
  Vec3 position_mm{0, 0, 0};         // kPoint
  Vec3 radiance_at_origin{1, 1, 1};  // of a white surface at the origin that faces the light
  std::vector<float> weights{};      // kLeds
  fs::path file{};                   // kEnvironment; relative to the view file
};

struct View {
  Camera camera;
  std::vector<Light> lights;
  std::vector<std::string> warnings{};  // unknown fields, one line each
};

// Throws Error that names the file and the field. `led_count` is what `weights` must have.
View read_view(const fs::path& file, size_t led_count);

void write_view(const fs::path& file, const View& view);

}  // namespace lamella
