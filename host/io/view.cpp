#include "io/view.h"

#include "base/error.h"
#include "io/json.h"
#include "io/rig_message.h"

namespace lamella {

namespace {

Vec3 three(const google::protobuf::RepeatedField<double>& values, const std::string& where) {
  if (values.size() != 3)
    throw_bad_input(where, "expected three numbers",
                    "one each for red, green and blue, or x, y and z");
  const Vec3 v{float(values[0]), float(values[1]), float(values[2])};
  if (!is_finite(v)) throw_bad_input(where, "not a finite number", "state a finite one");
  return v;
}

Light light_from_message(const v1::Light& m, const std::string& at, const fs::path& folder,
                         size_t led_count) {
  Light light;
  if (m.radiance_at_origin_size() > 0) {
    light.radiance_at_origin = three(m.radiance_at_origin(), at + ".radiance_at_origin");
    for (int c = 0; c < 3; ++c) {
      if (light.radiance_at_origin[c] < 0) {
        throw_bad_input(at + ".radiance_at_origin", "must not be negative", "0 is no light");
      }
    }
  }
  switch (m.kind()) {
    case v1::Light::POINT:
      light.kind = Light::Kind::kPoint;
      light.position_mm = three(m.position_mm(), at + ".position_mm");
      break;
    case v1::Light::LEDS:
      light.kind = Light::Kind::kLeds;
      light.weights.assign(m.weights().begin(), m.weights().end());
      for (float w : light.weights) {
        if (!(w >= 0) || !is_finite(w))
          throw_bad_input(at + ".weights", "must not be negative", "0 is no light");
      }
      if (light.weights.size() != led_count) {
        throw_bad_input(at + ".weights",
                        std::to_string(light.weights.size()) + " numbers, the session has " +
                            std::to_string(led_count) + " LEDs",
                        "give a weight for every LED");
      }
      break;
    case v1::Light::PROJECTOR:
      light.kind = Light::Kind::kProjector;
      break;
    case v1::Light::ENVIRONMENT:
      light.kind = Light::Kind::kEnvironment;
      light.file = folder / m.file();
      if (m.file().empty() || !fs::is_regular_file(light.file)) {
        throw_bad_input(at + ".file", "no such file: " + light.file.string(),
                        "name an EXR image, relative to the view file");
      }
      break;
    default:
      throw_bad_input(at + ".kind", "missing", "POINT, LEDS, PROJECTOR or ENVIRONMENT");
  }
  return light;
}

}  // namespace

View read_view(const fs::path& file, size_t led_count) {
  v1::View m;
  const std::vector<std::string> unknown = read_json(file, &m);
  const std::string where = file.string() + ": ";
  if (!m.has_camera()) throw_bad_input(where + "camera", "missing", "state it");
  if (m.lights_size() == 0) throw_bad_input(where + "lights", "missing", "state it");
  View view;
  for (const std::string& name : unknown) {
    view.warnings.push_back(where + name + ": unknown field, ignored");
  }
  view.camera = camera_from_message(m.camera(), where + "camera");
  for (int i = 0; i < m.lights_size(); ++i) {
    const std::string at = where + "lights[" + std::to_string(i) + "]";
    view.lights.push_back(light_from_message(m.lights(i), at, file.parent_path(), led_count));
  }
  return view;
}

void write_view(const fs::path& file, const View& view) {
  v1::View m;
  *m.mutable_camera() = message_from_camera(view.camera);
  for (const Light& light : view.lights) {
    v1::Light* l = m.add_lights();
    l->set_kind(v1::Light::Kind(int(light.kind) + 1));
    if (light.kind == Light::Kind::kPoint) {
      for (int i = 0; i < 3; ++i) l->add_position_mm(light.position_mm[i]);
      for (int i = 0; i < 3; ++i) l->add_radiance_at_origin(light.radiance_at_origin[i]);
    }
    for (float w : light.weights) l->add_weights(w);
    if (!light.file.empty()) l->set_file(light.file.filename().string());
  }
  write_json(file, m);
}

}  // namespace lamella
