#include "apps/bench_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/bench_figures.h"
#include "base/error.h"

namespace lamella::apps {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Infinite where the point does not have it.
double figure_of(const v1::BenchPoint& point, const std::string& name) {
  const auto at = point.figures().find(name);
  return at == point.figures().end() ? kInfinity : at->second;
}

double seconds_of(const v1::BenchPoint& point, double pixel_ratio) {
  return *std::min_element(point.seconds_s().begin(), point.seconds_s().end()) * pixel_ratio;
}

// Mean over the figures that the default has, each over the default's.
double error_of(const v1::BenchPoint& point, const v1::BenchPoint& standard) {
  double sum = 0;
  for (const auto& [name, value] : standard.figures()) {
    sum += figure_of(point, name) / std::max(value, 1e-12);
  }
  return sum / std::max<double>(1, double(standard.figures().size()));
}

const v1::BenchPoint& default_of(const v1::Bench& table, const std::string& where) {
  for (const v1::BenchPoint& point : table.points()) {
    if (point.seconds_s().empty()) {
      throw_bad_input(where, "a point without seconds", "give the bench.json of `lamella bench`");
    }
  }
  for (const v1::BenchPoint& point : table.points()) {
    if (point.is_default()) return point;
  }
  throw_bad_input(where, "no point of the defaults", "give the bench.json of `lamella bench`");
}

// What the best of the table would be, for whom asks for more.
[[noreturn]] void throw_none(const v1::Bench& table, const std::string& where, double pixel_ratio,
                             const std::optional<double>& budget_s,
                             const std::optional<FigureLimit>& limit) {
  double seconds = kInfinity, figure = kInfinity;
  for (const v1::BenchPoint& point : table.points()) {
    seconds = std::min(seconds, seconds_of(point, pixel_ratio));
    if (limit) figure = std::min(figure, figure_of(point, limit->figure));
  }
  std::string asked, there_is;
  if (budget_s) {
    asked = fmt::format("{:g} s", *budget_s);
    there_is = fmt::format("the quickest takes about {:.2g} s", seconds);
  }
  if (limit) {
    asked += fmt::format("{}{} <= {:g}", asked.empty() ? "" : " and ", limit->figure, limit->value);
    there_is += fmt::format("{}the least {} is {:.3g}", there_is.empty() ? "" : ", ", limit->figure,
                            figure);
  }
  throw_bad_input(where, "no setting is within " + asked, there_is);
}

void require_known(const FigureLimit& limit) {
  std::string known;
  for (const BenchFigure& figure : bench_figures()) {
    if (limit.figure == figure.name) return;
    known += (known.empty() ? "" : ", ") + std::string(figure.name);
  }
  throw_bad_input("--max-error", "no figure \"" + limit.figure + "\"", "one of " + known);
}

}  // namespace

FigureLimit error_limit_from(const std::string& text) {
  const FigureLimit limit = figure_limit_from(text, "--max-error", "position_rms_mm<=0.3");
  require_known(limit);
  return limit;
}

BenchChoice choose_setting(const v1::Bench& table, const std::string& where, uint32_t pixels,
                           std::optional<double> budget_s,
                           const std::optional<FigureLimit>& limit) {
  if (table.format() != "lamella.bench.v1" || table.pixels() == 0) {
    throw_bad_input(where, "is no bench", "give the bench.json of `lamella bench`");
  }
  const v1::BenchPoint& standard = default_of(table, where);
  const double pixel_ratio = double(pixels) / double(table.pixels());
  const v1::BenchPoint* best = nullptr;
  double least = kInfinity;
  for (const v1::BenchPoint& point : table.points()) {
    const double seconds = seconds_of(point, pixel_ratio);
    if (budget_s && seconds > *budget_s) continue;
    if (limit && !(figure_of(point, limit->figure) <= limit->value)) continue;
    const double cost = budget_s ? error_of(point, standard) : seconds;
    if (!(cost < least)) continue;
    least = cost;
    best = &point;
  }
  if (!best) throw_none(table, where, pixel_ratio, budget_s, limit);
  return {fit::quality_from_message(best->quality(), where), seconds_of(*best, pixel_ratio)};
}

}  // namespace lamella::apps
