#include "apps/bench_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "apps/bench_chart_panels.h"
#include "apps/bench_figures.h"
#include "apps/chart_label.h"

namespace lamella::apps {

namespace {

constexpr double kPanelsTop = 132, kSide = 40;
constexpr double kLowest = 0.5, kHighest = 4;  // errors, of the default's: beyond is at the edge
constexpr double kLeastRange = 1.25;

struct Panel {
  double x, y;                     // its corner
  double most_seconds;             // of the default's
  double least_error, most_error;  // of the default's

  double across(double seconds) const {
    return x + kPanelLeft + (kPanelWidth - kPanelLeft - kPanelRight) * seconds / most_seconds;
  }
  double up(double error) const {
    const double share = std::log(std::clamp(error, least_error, most_error) / least_error) /
                         std::log(most_error / least_error);
    return y + kPanelHeight - kPanelBelow - (kPanelHeight - kPanelAbove - kPanelBelow) * share;
  }
};

std::vector<const BenchPoint*> points_of(const Bench& bench, const std::string& knob) {
  std::vector<const BenchPoint*> points;
  for (const BenchPoint& point : bench.points) {
    if (point.knob == knob) points.push_back(&point);
  }
  return points;
}

Panel panel_of(const Bench& bench, const std::vector<const BenchPoint*>& points, double x,
               double y) {
  double seconds = 1, least = 1 / kLeastRange, most = kLeastRange;
  for (const BenchPoint* point : points) {
    seconds = std::max(seconds, bench.relative_seconds(*point));
    for (const Curve& curve : kCurves) {
      const double error = point->figures[curve.figure] / bench.default_figures[curve.figure];
      if (!std::isfinite(error)) continue;
      least = std::min(least, error);
      most = std::max(most, error);
    }
  }
  return {x, y, 1.08 * seconds, std::max(kLowest, least), std::min(kHighest, most)};
}

std::string axes(const Panel& p) {
  std::string text;
  for (const double error : {0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 4.0}) {
    if (error < p.least_error || error > p.most_error) continue;
    const double y = p.up(error);
    text += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"{}\"/>\n", p.x + kPanelLeft, y,
                        p.x + kPanelWidth - kPanelRight, error == 1 ? kChartFaint : kChartGrid);
    text += chart_label(p.x + kPanelLeft - 8, y + 4, fmt::format("{:g}", error), 11, kChartFaint,
                        "end");
  }
  const double step = p.most_seconds > 3 ? 1 : p.most_seconds > 1.5 ? 0.5 : 0.2;
  const double bottom = p.y + kPanelHeight - kPanelBelow;
  for (double seconds = 0; seconds <= p.most_seconds; seconds += step) {
    text += chart_label(p.across(seconds), bottom + 18, fmt::format("{:g}", seconds), 11,
                        kChartFaint, "middle");
  }
  return text + chart_label(p.x + kPanelWidth - kPanelRight, bottom + 34,
                            "seconds, of the default's", 11, kChartFaint, "end");
}

std::string curve_of(const Panel& p, const Bench& bench, const Curve& curve,
                     const std::vector<const BenchPoint*>& points) {
  std::string line, dots;
  for (const BenchPoint* point : points) {
    const double error = point->figures[curve.figure] / bench.default_figures[curve.figure];
    if (!std::isfinite(error)) continue;
    const double x = p.across(bench.relative_seconds(*point)), y = p.up(error);
    line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", x, y);
    dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.6\" fill=\"{}\"/>\n", x, y,
                        curve.colour);
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"/>\n", line,
                     curve.colour) +
         dots;
}

// A value where its seconds are, on a line of its own where it would stand on its neighbour.
std::string values_of(const Panel& p, const Bench& bench,
                      const std::vector<const BenchPoint*>& points) {
  std::string text;
  double taken[3] = {-1e9, -1e9, -1e9};
  std::vector<const BenchPoint*> sorted = points;
  std::sort(sorted.begin(), sorted.end(), [&](const BenchPoint* a, const BenchPoint* b) {
    return bench.relative_seconds(*a) < bench.relative_seconds(*b);
  });
  for (const BenchPoint* point : sorted) {
    const double x = p.across(bench.relative_seconds(*point)),
                 half = 3.2 * double(point->value.size()) + 3;
    const int row = x - half > taken[0] ? 0 : x - half > taken[1] ? 1 : 2;
    taken[row] = x + half;
    const double y = p.y + kPanelAbove - 6 - 11 * row;
    text += chart_label(x, y, point->value, 10.5,
                        is_default(point->quality) ? kChartDefault : kChartInk, "middle");
  }
  return text;
}

std::string panel(const Bench& bench, const Knob& knob, double x, double y) {
  const std::vector<const BenchPoint*> points = points_of(bench, knob.name);
  const Panel p = panel_of(bench, points, x, y);
  std::string text = chart_label(x + kPanelLeft, y + 8, knob.name, 15, kChartInk);
  text += chart_label(x + kPanelWidth - kPanelRight, y + 8, knob.meaning, 11.5, kChartFaint, "end");
  text += axes(p);
  for (const Curve& curve : kCurves) text += curve_of(p, bench, curve, points);
  text += default_ring(p.across(1), p.up(1));
  return text + values_of(p, bench, points);
}

// "floor 3.3 %", "model 3.3 %" where it is the model's; nothing where it was not asked for.
std::string floor_words(const std::vector<Floor>& floors, size_t figure) {
  for (const Floor& floor : floors) {
    if (floor.figure != figure) continue;
    const bool is_model = floor.verdict() == v1::BenchFloor::MODEL_ERROR;
    return (is_model ? "model " : "floor ") +
           with_unit(floor.floor(), bench_figures()[figure].unit);
  }
  return "";
}

// "2.31 s", and where there were several rounds that it is the least of them.
std::string default_words(const Bench& bench) {
  const std::string seconds = fmt::format("{:.2f} s", bench.default_least_seconds());
  const size_t rounds = bench.default_seconds.size();
  return rounds == 1 ? seconds : seconds + fmt::format(", the least of {} rounds", rounds);
}

std::string head(const Bench& bench, const std::vector<Floor>& floors, const std::string& title) {
  std::string text = chart_label(kSide, 40, "Error against seconds: " + title, 21, kChartInk);
  std::string caption =
      "up: error of a fit, of the default's; ring and red: the default, " + default_words(bench);
  if (!floors.empty()) {
    caption += "; below an error its floor, called model where noise makes less than half of it";
  }
  text += chart_label(kSide, 63, caption, 12.5, kChartFaint);
  double x = kSide;
  for (const Curve& curve : kCurves) {
    const BenchFigure& figure = bench_figures()[curve.figure];
    const std::string error = with_unit(bench.default_figures[curve.figure], figure.unit);
    const std::string floor = floor_words(floors, curve.figure);
    text += fmt::format("<path d=\"M{:.1f} 88h18\" stroke=\"{}\" stroke-width=\"3\"/>\n", x,
                        curve.colour);
    text += chart_label(x + 24, 92, figure.label, 11.5, kChartInk);
    text += chart_label(x + 24, 107, error, 11.5, kChartFaint);
    text += chart_label(x + 24, 122, floor, 11.5, kChartFaint);
    x += 36 + 6 * double(std::max({std::strlen(figure.label), error.size(), floor.size()}));
  }
  return text;
}

}  // namespace

std::string bench_chart(const Bench& bench, const std::vector<Knob>& knobs,
                        const std::vector<Floor>& floors, const std::string& title) {
  const int panels = int(knobs.size()) + (bench.peers.empty() ? 0 : 1);
  const int columns = panels > 1 ? 2 : 1, rows = (panels + columns - 1) / columns;
  const double confidence_y = kPanelsTop + 44 + rows * kPanelHeight;
  const double width = 2 * kSide + 2 * kPanelWidth,
               height =
                   confidence_y - 24 + (bench.confidence.empty() ? 0 : kConfidencePanelHeight + 24);
  std::string text = chart_head(width, height);
  text += head(bench, floors, title);
  for (int i = 0; i < panels; ++i) {
    const double x = kSide + i % columns * kPanelWidth;
    const double y = kPanelsTop + 24 + i / columns * kPanelHeight;
    text += size_t(i) < knobs.size() ? panel(bench, knobs[size_t(i)], x, y)
                                     : peer_panel(bench.peers, x, y);
  }
  if (!bench.confidence.empty()) text += confidence_panel(bench.confidence, kSide, confidence_y);
  return text + "</svg>\n";
}

}  // namespace lamella::apps
