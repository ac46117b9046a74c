#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/bench_chart_panels.h"
#include "apps/chart_label.h"

namespace lamella::apps {

namespace {

constexpr double kLegendWidth = 250, kLegendLine = 15;
constexpr double kConfidenceStep = 0.1, kErrorRoom = 1.15;

// As the figures of the page where those are of the same map.
const char* colour_of(const std::string& map) {
  static constexpr std::pair<const char*, const char*> colours[] = {
      {"position", "#2f6db3"},       {"normal_specular", "#1b9a8f"},
      {"normal_diffuse", "#7cc242"}, {"specular_intensity", "#e0a23c"},
      {"single_albedo", "#8a5fb0"},  {"total_albedo", "#22262b"},
      {"shallow_albedo", "#d0679d"}, {"deep_albedo", "#7a4a2b"},
      {"deep_alpha", "#c58a5e"},     {"deep_ld", "#3d8b3d"}};
  for (const auto& [name, colour] : colours) {
    if (map == name) return colour;
  }
  return kChartFaint;
}

class ConfidencePanel {
 public:
  ConfidencePanel(double x, double y, const std::vector<ConfidenceCurve>& curves) : x_(x), y_(y) {
    for (const ConfidenceCurve& curve : curves) {
      for (const ConfidenceBin& bin : curve.bins) {
        least_ = std::min(least_, bin.mean_confidence);
        if (!(bin.median_error > 0)) continue;
        low_ = std::min(low_, bin.median_error / kErrorRoom);
        high_ = std::max(high_, bin.median_error * kErrorRoom);
      }
    }
    least_ = kConfidenceStep * std::floor(least_ / kConfidenceStep);
    if (low_ >= high_) low_ = 0.1, high_ = 10;  // no error above 0
  }

  double left() const { return x_ + kPanelLeft; }
  double right() const { return x_ + 2 * kPanelWidth - kLegendWidth; }
  double top() const { return y_ + 36; }
  double bottom() const { return y_ + kConfidencePanelHeight - kPanelBelow; }
  double across(double confidence) const {
    return left() + (right() - left()) * (confidence - least_) / (1 - least_);
  }
  double up(double error) const {
    const double share = std::log(std::max(error, low_) / low_) / std::log(high_ / low_);
    return bottom() - (bottom() - top()) * share;
  }

  std::string axes() const {
    std::string text;
    for (double decade = 1e-6; decade < 1e6; decade *= 10) {
      for (const double tick : {decade, 2 * decade, 5 * decade}) text += error_tick(tick);
    }
    for (double c = least_; c < 1 + kConfidenceStep / 2; c += kConfidenceStep) {
      text += chart_label(across(c), bottom() + 18, fmt::format("{:.1f}", c), 11, kChartFaint,
                          "middle");
    }
    return text + chart_label(right(), bottom() + 34,
                              "confidence, 0 to 1: the mean of a tenth of the map's pixels", 11,
                              kChartFaint, "end");
  }

 private:
  std::string error_tick(double tick) const {
    if (tick < low_ || tick > high_) return "";
    return fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"{}\"/>\n", left(), up(tick),
                       right(), kChartGrid) +
           chart_label(left() - 8, up(tick) + 4, fmt::format("{:g}", tick), 11, kChartFaint, "end");
  }

  double x_, y_;
  double least_ = 1, low_ = 1e9, high_ = 0;
};

// Dashed where confidence does not order the errors.
std::string drawn(const ConfidencePanel& panel, const ConfidenceCurve& curve) {
  const char* colour = colour_of(curve.map);
  std::string line, dots;
  for (const ConfidenceBin& bin : curve.bins) {
    const double x = panel.across(bin.mean_confidence), y = panel.up(bin.median_error);
    line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", x, y);
    dots +=
        fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.6\" fill=\"{}\"/>\n", x, y, colour);
  }
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\"{}/>\n", line,
                     colour, curve.falls ? "" : " stroke-dasharray=\"5 4\"") +
         dots;
}

// Where the surest pixels' error is, or below what is above it.
std::string legend(const ConfidencePanel& panel, std::vector<ConfidenceCurve> curves) {
  const auto end = [&](const ConfidenceCurve& c) { return panel.up(c.bins.back().median_error); };
  std::stable_sort(
      curves.begin(), curves.end(),
      [&](const ConfidenceCurve& a, const ConfidenceCurve& b) { return end(a) < end(b); });
  std::string text;
  double y = -1e9;
  for (size_t i = 0; i < curves.size(); ++i) {
    const double room = kLegendLine * double(curves.size() - 1 - i);
    y = std::max(y + kLegendLine, std::min(end(curves[i]), panel.bottom() - room));
    const double x = panel.right() + 16;
    text +=
        fmt::format("<path d=\"M{:.1f} {:.1f}h22\" stroke=\"{}\" stroke-width=\"2.4\"{}/>\n", x, y,
                    colour_of(curves[i].map), curves[i].falls ? "" : " stroke-dasharray=\"5 4\"");
    text += chart_label(x + 30, y + 4,
                        curves[i].label + ", " + unit_words(curves[i].unit) +
                            (curves[i].falls ? "" : ": not ordered"),
                        11.5, kChartInk);
  }
  return text;
}

}  // namespace

std::string confidence_panel(const std::vector<ConfidenceCurve>& curves, double x, double y) {
  const ConfidencePanel panel(x, y, curves);
  std::string text =
      chart_label(panel.left(), y + 8, "error against confidence", 15, kChartInk) +
      chart_label(panel.right(), y + 8,
                  "up: the default's median error, in the unit of the map; dashed: confidence does "
                  "not order the errors",
                  11.5, kChartFaint, "end") +
      panel.axes();
  for (const ConfidenceCurve& curve : curves) text += drawn(panel, curve);
  return text + legend(panel, curves);
}

}  // namespace lamella::apps
