#include "apps/plan_chart.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "apps/chart_label.h"

namespace lamella::apps {

namespace {

constexpr double kWidth = 1480, kLeft = 120, kRight = 28, kTop = 112, kRow = 30, kBar = 18;
constexpr double kPxPerLetter = 5.5;  // of a bar's label
constexpr const char* kLedColour = "#e0a23c";
constexpr const char* kProjectorColour = "#4f86c6";
constexpr const char* kReadoutColour = "#b8bec6";
constexpr const char* kMoveColour = "#8a5fb0";

class Chart {
 public:
  Chart(const v1::Plan& plan, const std::string& title) : plan_(plan) {
    end_us_ = std::max(1.0, plan.duration_us());
    const double height = kTop + 9 * kRow + 52;
    text_ = chart_head(kWidth, height);
    label(24, 36, title, 20, kChartInk);
    label(24, 58, subtitle(), 13, plan.refusal().empty() ? kChartFaint : "#b3362b");
    axis(kTop + 9 * kRow);
  }

  std::string finish() { return text_ + "</svg>\n"; }

  void exposures() {
    const double y = row("exposure");
    for (const v1::PlannedStep& step : plan_.steps()) {
      bar(step.open_us(), step.close_us(), y, is_lit_by_leds(step) ? kLedColour : kProjectorColour);
      const double x = at(0.5 * (step.open_us() + step.close_us()));
      text_ += fmt::format(
          "<text transform=\"translate({:.1f},{:.1f}) rotate(-38)\" font-size=\"9.5\" "
          "fill=\"{}\">{}</text>\n",
          x - 4, y - 5, kChartInk, short_name(step));
    }
  }

  void readouts() {
    const double y = row("readout");
    for (const v1::PlannedStep& step : plan_.steps()) {
      bar(step.close_us(), step.read_out_us(), y, kReadoutColour);
    }
  }

  void waits() {
    const double y = row("waits for");
    for (const v1::PlannedStep& step : plan_.steps()) {
      bar(step.open_us() - step.wait_us(), step.open_us(), y, "#e9e4da");
      const double room_px = at(step.wait_us()) - at(0);
      if (room_px < kPxPerLetter * double(step.wait().size())) continue;
      label(at(step.open_us() - 0.5 * step.wait_us()), y + 12.5, step.wait(), 9, kChartFaint,
            "middle");
    }
  }

  // Between an edge of `line` with value `from` and the next with another, or the end.
  void levels(const char* line, uint32_t from, const char* name, const char* colour) {
    const double y = row(name);
    double since_us = -1;
    for (const v1::TimedEdge& edge : plan_.edges()) {
      if (edge.line() != line) continue;
      if (edge.value() == from && since_us < 0) since_us = edge.planned_us();
      if (edge.value() == from || since_us < 0) continue;
      bar(since_us, edge.planned_us(), y, colour);
      since_us = -1;
    }
  }

  void analyser() {
    const double y = row("analyser");
    double since_us = 0;
    for (const v1::TimedEdge& edge : plan_.edges()) {
      if (edge.line() == "ANALYSER") since_us = edge.planned_us();
      if (edge.line() == "ARRIVED") bar(since_us, edge.planned_us(), y, kMoveColour);
    }
  }

  void ticks(const char* line, const char* name) {
    const double y = row(name);
    for (const v1::TimedEdge& edge : plan_.edges()) {
      if (edge.line() != line) continue;
      const double x = at(edge.planned_us());
      text_ +=
          fmt::format("<path d=\"M{:.2f} {:.1f}v{:.0f}\" stroke=\"{}\"/>\n", x, y, kBar, kChartInk);
    }
  }

 private:
  double at(double t_us) const { return kLeft + (kWidth - kLeft - kRight) * t_us / end_us_; }

  double row(const char* name) {
    const double y = kTop + kRow * rows_++ + 0.5 * (kRow - kBar);
    label(kLeft - 12, y + 13, name, 12, kChartInk, "end");
    return y;
  }

  void label(double x, double y, const std::string& words, double size, const char* colour,
             const char* anchor = "start") {
    text_ += chart_label(x, y, words, size, colour, anchor);
  }

  void bar(double from_us, double to_us, double y, const char* colour) {
    text_ += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.1f}\" width=\"{:.2f}\" height=\"{:.0f}\" rx=\"2\" "
        "fill=\"{}\"/>\n",
        at(from_us), y, std::max(0.75, at(to_us) - at(from_us)), kBar, colour);
  }

  void axis(double y) {
    const double raw = end_us_ / 12, power = std::pow(10, std::floor(std::log10(raw)));
    const double step = power * (raw / power > 5 ? 10 : raw / power > 2 ? 5 : 2);
    for (double t = 0; t <= end_us_; t += step) {
      text_ += fmt::format("<path d=\"M{:.1f} {:.0f}V{:.0f}\" stroke=\"{}\"/>\n", at(t), kTop,
                           y + 4, kChartGrid);
      label(at(t), y + 20, fmt::format("{:g}", t / 1000), 11, kChartFaint, "middle");
    }
    label(kWidth - kRight, y + 38, "ms", 11, kChartFaint, "end");
  }

  std::string subtitle() const {
    const std::string length =
        fmt::format("{} photographs in {:.0f} ms", plan_.steps_size(), end_us_ / 1000);
    return plan_.refusal().empty() ? length : length + "; refused: " + plan_.refusal();
  }

  const v1::Plan& plan_;
  double end_us_;
  int rows_ = 0;
  std::string text_;
};

}  // namespace

bool is_lit_by_leds(const v1::PlannedStep& step) {
  return step.role() >= v1::Frame::GRADIENT_FULL && step.role() <= v1::Frame::GRADIENT_Z;
}

std::string short_name(const v1::PlannedStep& step) {
  std::string name = v1::Frame::Role_Name(step.role());
  if (name.rfind("GRADIENT_", 0) == 0) name = name.substr(9);
  const bool numbered = step.role() == v1::Frame::FRINGE || step.role() == v1::Frame::STRIPES;
  if (numbered) name += fmt::format(" {}", step.index());
  return name + (step.analyser() == v1::Frame::CROSS ? " ×" : " ∥");
}

std::string plan_chart(const v1::Plan& plan, const std::string& title) {
  Chart chart(plan, title);
  chart.exposures();
  chart.readouts();
  chart.waits();
  chart.analyser();
  chart.levels("BLANK", 0, "LEDs lit", kLedColour);
  chart.levels("LAMP", 1, "lamp", kProjectorColour);
  chart.ticks("VBLANK", "flips");
  chart.levels("TRIGGER", 1, "TRIGGER", kChartInk);
  chart.ticks("LATCH", "LATCH");
  return chart.finish();
}

}  // namespace lamella::apps
