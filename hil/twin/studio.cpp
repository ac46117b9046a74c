#include "twin/studio.h"

#include <algorithm>

#include "base/parallel.h"
#include "twin/patterns.h"

namespace lamella::twin {

namespace {

constexpr size_t kMostRemembered = 48;  // states of both cameras
constexpr double kNothing = 1e-7;       // share of S below any digit of the sensor

}  // namespace

LightState led_state(const std::vector<float>& levels) {
  LightState light;
  for (float level : levels) {
    light.codes.push_back(uint16_t(std::lround(std::clamp(level, 0.f, 1.f) * 4095.f)));
  }
  return light;
}

Vec3 radiance_scale(const Exposure& exposure) {
  double polarized = 0, depolarized = 0;
  bool leds = false;
  for (const Contribution& c : exposure.contributions) {
    polarized += c.polarized;
    depolarized += c.depolarized;
    leds = leds || c.light.is_leds();
  }
  const bool parallel = polarized > depolarized;
  return Vec3::all(leds ? (parallel ? 0.8f : 0.36f) : (parallel ? 0.6f : 0.4f));
}

Studio::Studio(const Photographer& photographer, uint64_t seed)
    : photographer_(photographer), seed_(seed) {}

const Receivers& Studio::receivers(int camera) const {
  return photographer_.receivers(camera == 0 ? Eye::kLeft : Eye::kRight);
}

Image3 Studio::emitted_by(const LightState& light) const {
  const Session& rig = photographer_.rig();
  switch (light.pattern) {
    case v1::PatternSpan::WHITE:
      return emitted(even_pattern(rig, 1.f));
    case v1::PatternSpan::FRINGE:
      return emitted(fringe_pattern(rig, int(light.index)));
    case v1::PatternSpan::STRIPES:
      return emitted(stripe_pattern(rig, light.index * rig.patterns.stripe_shift_px));
    case v1::PatternSpan::DOTS:
      return emitted(dot_pattern(rig));
    default:
      return emitted(even_pattern(rig, 0.f));
  }
}

// What the LEDs really shine by.
std::vector<float> Studio::levels_of(const LightState& light) const {
  const std::vector<float>& gains = photographer_.led_gains();
  std::vector<float> levels;
  for (size_t i = 0; i < light.codes.size(); ++i) {
    levels.push_back(float(light.codes[i]) / 4095.f * (gains.empty() ? 1.f : gains[i]));
  }
  return levels;
}

PatchLight Studio::light_on_surface(const LightState& light) const {
  if (light.is_leds()) return photographer_.led_light(levels_of(light));
  return photographer_.projector_light(emitted_by(light));
}

Radiance Studio::polarized(int camera, const LightState& light) const {
  const Receivers& r = receivers(camera);
  if (light.is_leds()) return photographer_.polarized_leds(r, levels_of(light));
  return photographer_.polarized_projector(r, emitted_by(light));
}

void Studio::prepare(int camera, const std::vector<LightState>& lights) {
  std::vector<PatchLight> on_surface;
  std::vector<const LightState*> wanted;
  for (const LightState& light : lights) {
    const bool known = std::any_of(memory_.begin(), memory_.end(), [&](const Seen& s) {
      return s.camera == camera && s.light == light;
    });
    if (known) continue;
    on_surface.push_back(light_on_surface(light));
    wanted.push_back(&light);
  }
  std::vector<const PatchLight*> pointers;
  for (const PatchLight& light : on_surface) pointers.push_back(&light);
  std::vector<Radiance> d = photographer_.depolarized(receivers(camera), pointers);
  for (size_t i = 0; i < wanted.size(); ++i) {
    memory_.push_front({camera, *wanted[i], std::move(d[i]), {}});
  }
  while (memory_.size() > kMostRemembered) memory_.pop_back();
}

Studio::Seen& Studio::seen(int camera, const LightState& light) {
  const auto found = std::find_if(memory_.begin(), memory_.end(), [&](const Seen& s) {
    return s.camera == camera && s.light == light;
  });
  if (found == memory_.end()) {
    prepare(camera, {light});
    return memory_.front();
  }
  memory_.splice(memory_.begin(), memory_, found);
  return memory_.front();
}

Image3 Studio::radiance(const Exposure& exposure) {
  const Receivers& r = receivers(exposure.camera);
  const float leak = float(
      (exposure.camera == 0 ? photographer_.rig().left : *photographer_.rig().right).extinction);
  const cv::Matx33f projector_from_led = cv::Matx33f(photographer_.rig().projector_to_led.inv());
  Radiance sum(r.size(), Vec3(0, 0, 0));
  for (const Contribution& c : exposure.contributions) {
    Seen& s = seen(exposure.camera, c.light);
    const float d = float(c.depolarized);
    const float p = float(c.polarized + leak * (2 * c.depolarized - c.polarized));
    if (p > kNothing && s.polarized.empty()) s.polarized = polarized(exposure.camera, c.light);
    parallel_for(
        int(r.size()),
        [&](int n) {
          const size_t i = size_t(n);
          Vec3 radiance = s.depolarized[i] * d;
          if (p > kNothing) radiance += s.polarized[i] * p;
          sum[i] += c.light.is_leds() ? radiance : projector_from_led * radiance;
        },
        8192);
  }
  return r.image(sum, {0, 0, 0});
}

RawPhotograph Studio::take(const Exposure& exposure, uint64_t serial) {
  RawPhotograph photograph;
  photograph.radiance_scale = radiance_scale(exposure);
  Image3 stored = radiance(exposure);
  const float scale = 1.f / photograph.radiance_scale[0];
  for (int y = 0; y < stored.rows; ++y) {
    for (int x = 0; x < stored.cols; ++x) stored(y, x) *= scale;
  }
  const Session& rig = photographer_.rig();
  photograph.raw = expose(stored, exposure.camera == 0 ? rig.left : *rig.right,
                          seed_ * 0x9e3779b97f4a7c15ull + serial);
  return photograph;
}

}  // namespace lamella::twin
