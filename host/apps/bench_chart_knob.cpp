#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/bench_chart_panels.h"
#include "apps/bench_figures.h"
#include "apps/chart_label.h"

namespace lamella::apps {

namespace {

constexpr double kLowest = 0.5, kHighest = 8;  // errors: beyond is told by an arrow
constexpr double kLeastRange = 1.25;
constexpr double kLetter = 6;      // mean width at the size of values
constexpr double kValueRise = 22;  // of the values above the axes
constexpr double kTickRoom = 13;

using Points = std::vector<const BenchPoint*>;

struct KnobAxes {
  double x, y;                     // the panel's corner
  double most_seconds;             // of the default's
  double least_error, most_error;  // of the default's

  double left() const { return x + kPanelLeft; }
  double right() const { return x + kPanelWidth - kPanelRight; }
  double top() const { return y + kPanelAbove; }
  double bottom() const { return y + kPanelHeight - kPanelBelow; }
  double across(double seconds) const {
    return left() + (right() - left()) * seconds / most_seconds;
  }
  // Not clamped: what is beyond is cut off by the panel.
  double up(double error) const {
    return bottom() -
           (bottom() - top()) * std::log(error / least_error) / std::log(most_error / least_error);
  }
};

double error_of(const Bench& bench, const BenchPoint& point, const Curve& curve) {
  const double error = point.figures[curve.figure] / bench.default_figures[curve.figure];
  return error > 0 ? error : double(kNaN);
}

// From the quickest.
Points points_of(const Bench& bench, const std::string& knob) {
  Points points;
  for (const BenchPoint& point : bench.points) {
    if (point.knob == knob) points.push_back(&point);
  }
  std::stable_sort(points.begin(), points.end(), [&](const BenchPoint* a, const BenchPoint* b) {
    return bench.relative_seconds(*a) < bench.relative_seconds(*b);
  });
  return points;
}

KnobAxes axes_of(const Bench& bench, const Points& points, double x, double y) {
  double seconds = 1, least = 1 / kLeastRange, most = kLeastRange;
  for (const BenchPoint* point : points) {
    seconds = std::max(seconds, bench.relative_seconds(*point));
    for (const Curve& curve : kCurves) {
      const double error = error_of(bench, *point, curve);
      if (!std::isfinite(error)) continue;
      least = std::min(least, 0.97 * error);
      most = std::max(most, 1.03 * error);
    }
  }
  return {x, y, 1.08 * seconds, std::max(kLowest, least), std::min(kHighest, most)};
}

std::string path_of(const std::string& d, const char* colour, double width, double opacity) {
  return fmt::format(
      "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{:g}\" stroke-opacity=\"{:g}\" "
      "stroke-linejoin=\"round\"/>\n",
      d, colour, width, opacity);
}

std::string draw_axes(const KnobAxes& p) {
  std::string text;
  for (const double error : {0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0}) {
    if (error < p.least_error || error > p.most_error) continue;
    const double y = p.up(error);
    if (error != 1 && std::abs(y - p.up(1)) < kTickRoom) continue;
    if (error > 1 && error < 1.4 && p.up(1.25) - p.up(1.5) < kTickRoom) continue;
    text += path_of(fmt::format("M{:.1f} {:.1f}H{:.1f}", p.left(), y, p.right()),
                    error == 1 ? kChartFaint : kChartGrid, 1, 1);
    text += chart_label(p.left() - 8, y + 4, fmt::format("{:g}", error), 11, kChartFaint, "end");
  }
  const double step = p.most_seconds > 3 ? 1 : p.most_seconds > 1.5 ? 0.5 : 0.2;
  for (double seconds = 0; seconds <= p.most_seconds; seconds += step) {
    text += chart_label(p.across(seconds), p.bottom() + 18, fmt::format("{:g}", seconds), 11,
                        kChartFaint, "middle");
  }
  return text + chart_label(p.right(), p.bottom() + 34, "seconds, of the default's", 11,
                            kChartFaint, "end");
}

struct ValueLabel {
  const BenchPoint* point;
  double seconds_x, x, half;  // where it belongs, where it stands, half its width
};

// In their order, none upon another, all together as near as can be to where they belong: labels
// that touch move as one, their mean displacement none.
void spread_out(const KnobAxes& p, std::vector<ValueLabel>* labels) {
  struct Block {
    size_t first, count;
    double start;  // of its first label's middle
  };
  std::vector<double> offset(labels->size(), 0);  // of every middle from the first's
  for (size_t i = 1; i < labels->size(); ++i) {
    offset[i] = offset[i - 1] + (*labels)[i - 1].half + (*labels)[i].half;
  }
  std::vector<Block> blocks;
  for (size_t i = 0; i < labels->size(); ++i) {
    blocks.push_back({i, 1, (*labels)[i].seconds_x - offset[i]});
    while (blocks.size() > 1 && blocks.back().start < blocks[blocks.size() - 2].start) {
      const Block last = blocks.back();
      blocks.pop_back();
      Block& before = blocks.back();
      const double count = double(before.count + last.count);
      before.start =
          (before.start * double(before.count) + last.start * double(last.count)) / count;
      before.count += last.count;
    }
  }
  const double least = p.left() + labels->front().half;
  const double most = p.right() + kPanelRight - labels->back().half - offset.back();
  for (const Block& block : blocks) {
    for (size_t i = block.first; i < block.first + block.count; ++i) {
      (*labels)[i].x = std::max(least, std::min(block.start, most)) + offset[i];
    }
  }
}

// A value above its seconds with a line down to them; beside the others where it would stand on
// them, its line bent.
std::string draw_values(const KnobAxes& p, const Bench& bench, const Points& points) {
  std::vector<ValueLabel> labels;
  for (const BenchPoint* point : points) {
    const double x = p.across(bench.relative_seconds(*point));
    labels.push_back({point, x, x, 0.5 * kLetter * double(point->value.size()) + 7});
  }
  if (!labels.empty()) spread_out(p, &labels);
  std::string text;
  for (const ValueLabel& label : labels) {
    const bool is_ours = is_default(label.point->quality);
    const double y = p.top() - kValueRise;
    text += path_of(fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}V{:.1f}", label.x, y + 3,
                                label.seconds_x, p.top(), p.bottom()),
                    is_ours ? kChartDefault : kChartGrid, 1, is_ours ? 0.5 : 1);
    text += chart_label(label.x, y, label.point->value, 11, is_ours ? kChartDefault : kChartInk,
                        "middle");
  }
  return text;
}

template <class ErrorOf>
std::string draw_curve(const KnobAxes& p, const Bench& bench, const Points& points,
                       const ErrorOf& error_at) {
  std::string line;
  for (const BenchPoint* point : points) {
    const double error = error_at(*point);
    if (!std::isfinite(error)) continue;
    line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L",
                        p.across(bench.relative_seconds(*point)), p.up(error));
  }
  return line;
}

std::string draw_dot(double x, double y, double radius, const char* colour) {
  return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\" fill=\"{}\"/>\n", x, y, radius,
                     colour);
}

// Each figure thin, all of them thick.
std::string draw_curves(const KnobAxes& p, const Bench& bench, const Points& points) {
  std::string lines, dots;
  for (const Curve& curve : kCurves) {
    const auto error_at = [&](const BenchPoint& point) { return error_of(bench, point, curve); };
    lines += path_of(draw_curve(p, bench, points, error_at), curve.colour, 1.3, 0.7);
    for (const BenchPoint* point : points) {
      const double error = error_at(*point);
      if (!(error >= p.least_error && error <= p.most_error)) continue;
      dots += draw_dot(p.across(bench.relative_seconds(*point)), p.up(error), 2.2, curve.colour);
    }
  }
  const auto mean_at = [&](const BenchPoint& point) { return mean_error(bench, point); };
  lines += path_of(draw_curve(p, bench, points, mean_at), kChartInk, 3, 1);
  for (const BenchPoint* point : points) {
    const double error = mean_at(*point);
    if (!(error >= p.least_error && error <= p.most_error)) continue;
    dots += draw_dot(p.across(bench.relative_seconds(*point)), p.up(error), 4, kChartInk);
  }
  const std::string name = fmt::format("knob{:.0f}-{:.0f}", p.x, p.y);
  return fmt::format(
             "<clipPath id=\"{}\"><rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" "
             "height=\"{:.1f}\"/></clipPath>\n<g clip-path=\"url(#{})\">\n",
             name, p.left(), p.top(), p.right() - p.left(), p.bottom() - p.top(), name) +
         lines + "</g>\n" + dots;
}

// The curves that leave the panel at a setting: an arrow each, and how far the furthest goes.
std::string draw_beyond(const KnobAxes& p, const Bench& bench, const BenchPoint& point, int row) {
  std::vector<std::pair<double, const Curve*>> beyond;
  for (const Curve& curve : kCurves) {
    const double error = error_of(bench, point, curve);
    if (error > p.most_error) beyond.push_back({error, &curve});
  }
  if (beyond.empty()) return "";
  std::sort(beyond.rbegin(), beyond.rend());
  const double x = p.across(bench.relative_seconds(point));
  const double half = 4.5 * double(beyond.size() - 1);
  std::string text;
  for (size_t i = 0; i < beyond.size(); ++i) {
    text += fmt::format("<path d=\"M{:.1f} {:.1f}l4 8h-8z\" fill=\"{}\"/>\n",
                        x - half + 9 * double(i), p.top() + 2, beyond[i].second->colour);
  }
  const bool is_right = x > 0.5 * (p.left() + p.right());
  std::string words =
      fmt::format("{} {:.1f}", bench_figures()[beyond[0].second->figure].label, beyond[0].first);
  if (beyond.size() > 1)
    words += fmt::format(", {} more above {:.3g}", beyond.size() - 1, p.most_error);
  // Upon a ground of its own: curves run under it.
  return text + "<g stroke=\"#fbfaf8\" stroke-width=\"4\" paint-order=\"stroke\">" +
         chart_label(is_right ? x - half - 8 : x + half + 8, p.top() + 24 + 13 * row, words, 11,
                     beyond[0].second->colour, is_right ? "end" : "start") +
         "</g>\n";
}

std::string draw_verdict(const KnobAxes& p, const Knee& knee) {
  const char* colour = knee.is_there ? kChartGood : kChartDefault;
  const std::string verdict =
      knee.value + (knee.is_there ? " is at the knee" : " is not at the knee");
  if (knee.words.empty()) {
    return chart_label(p.left(), p.y + 28, "no other setting was fitted", 12, kChartFaint);
  }
  return draw_dot(p.left() + 5, p.y + 24, 5, colour) +
         chart_label(p.left() + 16, p.y + 28, verdict, 12, colour) +
         chart_label(p.left() + 16, p.y + 44, knee.words, 11.5, kChartInk);
}

}  // namespace

std::string default_ring(double x, double y) {
  return fmt::format(
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"8\" fill=\"none\" stroke=\"{}\" "
      "stroke-width=\"2.4\"/>\n",
      x, y, kChartDefault);
}

std::string knob_panel(const Bench& bench, const Knob& knob, double x, double y) {
  const Points points = points_of(bench, knob.name);
  const KnobAxes p = axes_of(bench, points, x, y);
  std::string text = chart_label(p.left(), y + 8, knob.name, 15, kChartInk) +
                     chart_label(p.right(), y + 8, knob.meaning, 11.5, kChartFaint, "end") +
                     draw_verdict(p, knee_of(bench, knob.name)) + draw_axes(p) +
                     draw_values(p, bench, points) + draw_curves(p, bench, points);
  int row = 0;
  for (const BenchPoint* point : points) {
    const std::string beyond = draw_beyond(p, bench, *point, row);
    row += beyond.empty() ? 0 : 1;
    text += beyond;
  }
  return text + default_ring(p.across(1), p.up(1));
}

}  // namespace lamella::apps
