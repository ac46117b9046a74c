#include "twin/exposure.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/vec.h"

namespace lamella::twin {

namespace {

constexpr double kSlackUs = 1e-3;  // times that went through two programs' arithmetic
constexpr int kLargestCode = 4095;
constexpr int kMostSpans = 4096;

[[noreturn]] void refuse(const std::string& field, const std::string& problem) {
  throw_bad_input("ExposureReport." + field, problem);
}

void check_span(double from, double to, const v1::ExposureReport& r, const std::string& field) {
  if (!std::isfinite(from) || !std::isfinite(to)) refuse(field, "a time that is not a number");
  if (to < from) refuse(field, "ends before it begins");
  if (from < r.open_us() - kSlackUs || to > r.close_us() + kSlackUs) {
    refuse(field, "lies outside the exposure");
  }
}

void check_reference(double reference_us, const std::string& field) {
  if (!(reference_us > 0) || !std::isfinite(reference_us)) refuse(field, "must be positive");
}

void check_analyser(const v1::ExposureReport& r) {
  double at = r.open_us();
  for (const v1::AnalyserSpan& span : r.analyser()) {
    if (!std::isfinite(span.from_us()) || !std::isfinite(span.to_us()) ||
        !std::isfinite(span.from_rad()) || !std::isfinite(span.to_rad())) {
      refuse("analyser", "a value that is not a number");
    }
    if (span.to_us() < span.from_us()) refuse("analyser", "ends before it begins");
    if (span.from_us() > at + kSlackUs) refuse("analyser", "has a gap");
    at = std::max(at, span.to_us());
  }
  if (r.analyser_size() > 0 && at < r.close_us() - kSlackUs) {
    refuse("analyser", "ends before the exposure");
  }
}

// Integral over [a, b] of the share of S that the analyser lets through.
double polarized_time(const v1::ExposureReport& r, double a, double b) {
  double sum = 0, at = a;
  for (const v1::AnalyserSpan& span : r.analyser()) {
    const double from = std::max(at, span.from_us()), to = std::min(b, span.to_us());
    if (to <= from) continue;
    const double length = span.to_us() - span.from_us();
    const double rate = length > 0 ? (span.to_rad() - span.from_rad()) / length : 0.0;
    sum += malus_integral(from, to, span.from_rad() + rate * (from - span.from_us()),
                          span.from_rad() + rate * (to - span.from_us()));
    at = to;
  }
  return sum;
}

void add(const v1::ExposureReport& r, LightState light, double on_us, double off_us,
         double reference_us, Exposure* exposure) {
  const double polarized = polarized_time(r, on_us, off_us) / reference_us;
  const double depolarized = 0.5 * (off_us - on_us) / reference_us;
  if (depolarized <= 0) return;
  for (Contribution& c : exposure->contributions) {
    if (c.light == light) {
      c.polarized += polarized;
      c.depolarized += depolarized;
      return;
    }
  }
  exposure->contributions.push_back({std::move(light), polarized, depolarized});
}

LightState light_of(const v1::LedSpan& span, int led_count) {
  const std::string& bytes = span.codes();
  if (bytes.size() != size_t(led_count) * 2) {
    refuse("leds.codes",
           std::to_string(bytes.size()) + " bytes, expected " + std::to_string(led_count * 2));
  }
  LightState light;
  light.codes.resize(size_t(led_count));
  for (size_t i = 0; i < light.codes.size(); ++i) {
    const int code = uint8_t(bytes[2 * i]) | uint8_t(bytes[2 * i + 1]) << 8;
    if (code > kLargestCode) refuse("leds.codes", std::to_string(code) + " is over 12 bits");
    light.codes[i] = uint16_t(code);
  }
  return light;
}

LightState light_of(const v1::PatternSpan& span, int fringe_count) {
  const bool known = span.kind() >= v1::PatternSpan::DARK && span.kind() <= v1::PatternSpan::DOTS;
  if (!known) refuse("patterns.kind", "unknown");
  const int count = span.kind() == v1::PatternSpan::FRINGE    ? fringe_count
                    : span.kind() == v1::PatternSpan::STRIPES ? 4
                                                              : 1;
  if (int64_t(span.index()) >= count) {
    refuse("patterns.index", std::to_string(span.index()) + " of " + std::to_string(count));
  }
  return {.codes = {}, .pattern = span.kind(), .index = span.index()};
}

}  // namespace

double malus_integral(double a, double b, double from_rad, double to_rad) {
  const double turn = to_rad - from_rad;
  // cos^2 = (1 + cos 2 theta) / 2, and the mean of cos 2 theta over the turn is
  // cos(middle) * sinc(turn), which has no 0/0 to lose digits in.
  const double sinc = std::abs(turn) < 1e-6 ? 1.0 - turn * turn / 6 : std::sin(turn) / turn;
  return 0.5 * (b - a) * (1.0 + std::cos(from_rad + to_rad) * sinc);
}

Exposure read_exposure(const v1::ExposureReport& r, int led_count, int fringe_count) {
  if (!std::isfinite(r.open_us()) || !std::isfinite(r.close_us())) {
    refuse("open_us", "a time that is not a number");
  }
  if (r.close_us() < r.open_us()) refuse("close_us", "before open_us");
  if (r.camera() > 1) refuse("camera", std::to_string(r.camera()) + ", the rig has 0 and 1");
  if (r.leds_size() + r.patterns_size() + r.analyser_size() > kMostSpans) {
    refuse("leds", "too many spans");
  }
  check_analyser(r);
  Exposure exposure;
  exposure.camera = int(r.camera());
  for (const v1::LedSpan& span : r.leds()) {
    check_reference(r.led_reference_us(), "led_reference_us");
    check_span(span.on_us(), span.off_us(), r, "leds");
    LightState light = light_of(span, led_count);
    const bool dark = std::all_of(light.codes.begin(), light.codes.end(),
                                  [](uint16_t code) { return code == 0; });
    if (!dark)
      add(r, std::move(light), span.on_us(), span.off_us(), r.led_reference_us(), &exposure);
  }
  for (const v1::PatternSpan& span : r.patterns()) {
    check_reference(r.projector_reference_us(), "projector_reference_us");
    check_span(span.on_us(), span.off_us(), r, "patterns");
    LightState light = light_of(span, fringe_count);
    if (span.kind() == v1::PatternSpan::DARK) continue;
    add(r, std::move(light), span.on_us(), span.off_us(), r.projector_reference_us(), &exposure);
  }
  return exposure;
}

}  // namespace lamella::twin
