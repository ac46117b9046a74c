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

constexpr double kPanelsTop = 160, kSide = 40, kPageWidth = 2 * kSide + 2 * kPanelWidth;

// How far a fit's error is from what it can be; nothing where that was not asked for.
std::string floor_words(const std::vector<Floor>& floors, size_t figure) {
  for (const Floor& floor : floors) {
    if (floor.figure != figure) continue;
    const std::string least = with_unit(floor.floor(), bench_figures()[figure].unit);
    switch (floor.verdict()) {
      case v1::BenchFloor::REACHED:
        return "floor " + least + ": reached";
      case v1::BenchFloor::NOT_REACHED:
        return fmt::format("floor {}: {:.1f} times", least, floor.ratio());
      case v1::BenchFloor::MODEL_ERROR:
        return "model's " + least;
      default:
        return "floor not known";
    }
  }
  return "";
}

// "2.31 s", and where there were several rounds that it is the least of them.
std::string default_words(const Bench& bench) {
  const std::string seconds = fmt::format("{:.2f} s", bench.default_least_seconds());
  const size_t rounds = bench.default_seconds.size();
  return rounds == 1 ? seconds + ", one round: other work on the machine may be in it"
                     : seconds + fmt::format(", the least of {} rounds", rounds);
}

// The answer of the page in one sentence, of the knobs that were fitted with another setting too.
std::string verdict_words(const Bench& bench, const std::vector<Knob>& knobs) {
  int judged = 0, there = 0;
  std::string others;
  for (const Knob& knob : knobs) {
    const Knee knee = knee_of(bench, knob.name);
    if (knee.words.empty()) continue;
    ++judged;
    if (knee.is_there) {
      ++there;
    } else {
      others += (others.empty() ? "" : ", ") + knob.name;
    }
  }
  if (judged == 0) return "No setting but the defaults was fitted: nothing says where a knee is";
  if (others.empty()) return "Every default sits at the knee of its curve";
  return fmt::format("{} of {} defaults sit at the knee of their curve; not: {}", there, judged,
                     others);
}

std::string draw_legend(const Bench& bench, const std::vector<Floor>& floors) {
  std::string text;
  double x = kSide;
  for (const Curve& curve : kCurves) {
    const BenchFigure& figure = bench_figures()[curve.figure];
    const std::string error = with_unit(bench.default_figures[curve.figure], figure.unit);
    const std::string floor = floor_words(floors, curve.figure);
    text += fmt::format("<path d=\"M{:.1f} 120h18\" stroke=\"{}\" stroke-width=\"3\"/>\n", x,
                        curve.colour);
    text += chart_label(x + 24, 124, figure.label, 11.5, kChartInk);
    text += chart_label(x + 24, 139, error, 11.5, kChartFaint);
    text += chart_label(x + 24, 154, floor, 10, kChartFaint);
    const double letters = std::max<double>(std::strlen(figure.label), double(error.size()));
    x += 36 + std::max(6.2 * letters, 5.3 * double(floor.size()));
  }
  return text;
}

std::string draw_head(const Bench& bench, const std::vector<Knob>& knobs,
                      const std::vector<Floor>& floors, const std::string& title) {
  std::string text = chart_label(kSide, 40, "Error against seconds: " + title, 21, kChartInk);
  if (!knobs.empty()) text += chart_label(kSide, 64, verdict_words(bench, knobs), 14, kChartInk);
  text += chart_label(kSide, 85,
                      "Up: error of a fit, of the default's; thick: the mean of all errors "
                      "(geometric), thin: each. "
                      "Ring: the default, " +
                          default_words(bench),
                      12, kChartFaint);
  std::string rule =
      "At the knee: twice the seconds take less than a sixth off the mean error, half of them add "
      "more than a fifth";
  if (!floors.empty()) {
    rule += "; floor: what noise leaves of an error; model's: what is left without noise";
  }
  return text + chart_label(kSide, 102, rule, 12, kChartFaint) + draw_legend(bench, floors);
}

}  // namespace

std::string bench_chart(const Bench& bench, const std::vector<Knob>& knobs,
                        const std::vector<Floor>& floors, const std::string& title) {
  const int panels = int(knobs.size()) + (bench.peers.empty() ? 0 : 1), rows = (panels + 1) / 2;
  const double confidence_y = kPanelsTop + 44 + rows * kPanelHeight;
  const double height =
      confidence_y - 24 + (bench.confidence.empty() ? 0 : kConfidencePanelHeight + 24);
  std::string text = chart_head(kPageWidth, height) + draw_head(bench, knobs, floors, title);
  for (int i = 0; i < panels; ++i) {
    const double x = kSide + i % 2 * kPanelWidth;
    const double y = kPanelsTop + 24 + i / 2 * kPanelHeight;
    text += size_t(i) < knobs.size() ? knob_panel(bench, knobs[size_t(i)], x, y)
                                     : peer_panel(bench.peers, x, y);
  }
  if (!bench.confidence.empty()) text += confidence_panel(bench.confidence, kSide, confidence_y);
  return text + "</svg>\n";
}

}  // namespace lamella::apps
