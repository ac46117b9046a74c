#include "apps/bench_knee.h"

#include <fmt/format.h>

#include <cmath>

namespace lamella::apps {

namespace {

constexpr double kSame = 0.02;     // of errors: less is not told from none
constexpr double kOneRound = 0.2;  // of seconds: what one round alone may be off

std::string seconds_words(double of_default) {
  if (std::abs(of_default - 1) < 0.01) return "as quick";
  if (of_default < 1) return fmt::format("{:.0f} % quicker", 100 * (1 - of_default));
  if (of_default < 2) return fmt::format("{:.0f} % slower", 100 * (of_default - 1));
  return fmt::format("{:.1f} times the seconds", of_default);
}

std::string error_words(double of_default) {
  const double percent = std::round(100 * std::abs(of_default - 1));
  if (percent == 0) return "the same error";
  if (of_default < 1) return fmt::format("{:.0f} % less error", percent);
  if (of_default < 2) return fmt::format("{:.0f} % more error", percent);
  return fmt::format("{:.1f} times the error", of_default);
}

// The less, the better a bargain.
double price(const Bench& bench, const BenchPoint& point) {
  return std::log(mean_error(bench, point)) +
         kSecondsPower * std::log(bench.relative_seconds(point));
}

// What differences of rounds alone may make of a price.
double doubt(const Bench& bench) {
  const double spread = bench.default_seconds.size() > 1
                            ? median(bench.default_seconds) / bench.default_least_seconds()
                            : 1 + kOneRound;
  return kSame + kSecondsPower * std::log(spread);
}

// The better bargain of the two.
const BenchPoint* better(const Bench& bench, const BenchPoint* one, const BenchPoint* other) {
  return one && price(bench, *one) <= price(bench, *other) ? one : other;
}

std::string words_of(const Bench& bench, const BenchPoint& point) {
  return fmt::format("{}: {}, {}", point.value, seconds_words(bench.relative_seconds(point)),
                     error_words(mean_error(bench, point)));
}

}  // namespace

double mean_error(const Bench& bench, const BenchPoint& point) {
  double sum = 0;
  int count = 0;
  for (const Curve& curve : kCurves) {
    const double error = point.figures[curve.figure] / bench.default_figures[curve.figure];
    if (!std::isfinite(error) || !(error > 0)) continue;
    sum += std::log(error);
    ++count;
  }
  return std::exp(sum / count);
}

Knee knee_of(const Bench& bench, const std::string& knob) {
  Knee knee{"", true, ""};
  const BenchPoint *quicker = nullptr, *slower = nullptr;
  for (const BenchPoint& point : bench.points) {
    if (point.knob != knob) continue;
    if (is_default(point.quality)) {
      knee.value = point.value;
      continue;
    }
    if (!std::isfinite(price(bench, point))) continue;
    if (price(bench, point) < -doubt(bench)) knee.is_there = false;
    const BenchPoint*& side = bench.relative_seconds(point) < 1 ? quicker : slower;
    side = better(bench, side, &point);
  }
  for (const BenchPoint* side : {quicker, slower}) {
    if (side) knee.words += (knee.words.empty() ? "" : "; ") + words_of(bench, *side);
  }
  return knee;
}

}  // namespace lamella::apps
