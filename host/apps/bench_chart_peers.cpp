#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/bench_chart_panels.h"
#include "apps/bench_figures.h"
#include "apps/chart_label.h"

namespace lamella::apps {

namespace {

constexpr double kRoom = 1.6;  // beyond the outermost mark, a factor

// One error of one peer, both numbers of ours.
struct PeerMark {
  double seconds, error;
  const char* colour;
  std::string words;  // whose error, and how large
};

double peer_ratio(const std::vector<double>& its, const std::vector<double>& ours) {
  return *std::min_element(its.begin(), its.end()) / *std::min_element(ours.begin(), ours.end());
}

// With reading and writing where it reads and writes.
double seconds_ratio(const Peer& peer) {
  return peer.its.all.empty() ? peer_ratio(peer.its.without_files, peer.ours.without_files)
                              : peer_ratio(peer.its.all, peer.ours.all);
}

std::vector<PeerMark> marks_of(const Peer& peer) {
  std::vector<PeerMark> marks;
  if (peer.figures.empty()) return marks;
  for (const Curve& curve : kCurves) {
    const double error = peer.figures[curve.figure] / peer.our_figures[curve.figure];
    if (std::isfinite(error) && error > 0) {
      const BenchFigure& figure = bench_figures()[curve.figure];
      marks.push_back(
          {seconds_ratio(peer), error, curve.colour,
           std::string(figure.label) + " " + with_unit(peer.figures[curve.figure], figure.unit)});
    }
  }
  std::sort(marks.begin(), marks.end(),
            [](const PeerMark& a, const PeerMark& b) { return a.error > b.error; });
  return marks;
}

class LogPanel {
 public:
  LogPanel(double x, double y, const std::vector<Peer>& peers) : x_(x), y_(y) {
    for (const Peer& peer : peers) {
      for (const PeerMark& mark : marks_of(peer)) {
        left_ = std::min(left_, mark.seconds / kRoom);
        right_ = std::max(right_, mark.seconds * kRoom);
        low_ = std::min(low_, mark.error / kRoom);
        high_ = std::max(high_, mark.error * kRoom);
      }
    }
  }

  double across(double seconds) const {
    const double width = kPanelWidth - kPanelLeft - kPanelRight;
    return x_ + kPanelLeft + width * std::log(seconds / left_) / std::log(right_ / left_);
  }
  double up(double error) const {
    const double height = kPanelHeight - kPanelAbove - kPanelBelow;
    return bottom() - height * std::log(error / low_) / std::log(high_ / low_);
  }
  double bottom() const { return y_ + kPanelHeight - kPanelBelow; }
  double middle() const { return x_ + kPanelLeft + (end() - x_ - kPanelLeft) / 2; }
  double end() const { return x_ + kPanelWidth - kPanelRight; }

  std::string axes() const {
    std::string text;
    for (const double tick : {0.1, 0.2, 0.5, 1., 2., 5., 10., 20., 50., 100., 200., 500., 1000.}) {
      if (tick > low_ && tick < high_) {
        text += fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}\" stroke=\"{}\"/>\n", x_ + kPanelLeft,
                            up(tick), end(), tick == 1 ? kChartFaint : kChartGrid);
        text += chart_label(x_ + kPanelLeft - 8, up(tick) + 4, fmt::format("{:g}", tick), 11,
                            kChartFaint, "end");
      }
      if (tick > left_ && tick < right_) {
        text += chart_label(across(tick), bottom() + 18, fmt::format("{:g}", tick), 11, kChartFaint,
                            "middle");
      }
    }
    return text + chart_label(end(), bottom() + 34, "seconds, of ours at the same work", 11,
                              kChartFaint, "end");
  }

 private:
  double x_, y_;
  double left_ = 1 / kRoom, right_ = kRoom, low_ = 1 / kRoom, high_ = kRoom;
};

std::string diamond(double x, double y, const char* colour) {
  return fmt::format("<path d=\"M{:.1f} {:.1f}l5 5l-5 5l-5 -5z\" fill=\"{}\"/>\n", x, y - 5,
                     colour);
}

// Marks from above, each with its words beside it, where these do not stand on those before.
std::string draw_marks(const LogPanel& panel, const std::vector<PeerMark>& marks) {
  constexpr double kLine = 12;
  std::string text;
  double words_y = -1e9;
  for (const PeerMark& mark : marks) {
    const double x = panel.across(mark.seconds), y = panel.up(mark.error);
    const bool is_right = x > panel.middle();
    words_y = std::max(words_y + kLine, y - 2);  // above a line of the grid
    text += diamond(x, y, mark.colour);
    text += chart_label(is_right ? x - 12 : x + 12, words_y, mark.words, 10.5, mark.colour,
                        is_right ? "end" : "start");
  }
  return text;
}

}  // namespace

std::string peer_panel(const std::vector<Peer>& peers, double x, double y) {
  const LogPanel panel(x, y, peers);
  std::string text = chart_label(x + kPanelLeft, y + 8, "peers", 15, kChartInk);
  text += chart_label(panel.end(), y + 8, "up: error, of ours", 11.5, kChartFaint, "end");
  text += panel.axes();
  double note_y = y + 26;
  for (const Peer& peer : peers) {
    const std::vector<PeerMark> marks = marks_of(peer);
    text += draw_marks(panel, marks);
    if (!marks.empty()) {
      text += chart_label(panel.across(marks[0].seconds), y + kPanelAbove - 6, peer.name, 10.5,
                          kChartInk, "middle");
    } else {
      text += chart_label(x + kPanelLeft, note_y, peer.name + " did not run: " + peer.missing, 11,
                          kChartFaint);
      note_y += 14;
    }
  }
  text += chart_label(panel.across(1), panel.up(1) + 20, "ours", 10.5, kChartDefault, "middle");
  return text + default_ring(panel.across(1), panel.up(1));
}

}  // namespace lamella::apps
