// What the panels of the bench's page share.
#pragma once

#include <string>
#include <vector>

#include "apps/bench_knee.h"

namespace lamella::apps {

inline constexpr double kPanelWidth = 560, kPanelHeight = 380;
// Around the axes of a panel.
inline constexpr double kPanelLeft = 62, kPanelRight = 24, kPanelAbove = 96, kPanelBelow = 54;
inline constexpr const char *kChartDefault = "#b3362b", *kChartGood = "#2e7d4f";

// A ring where both seconds and errors are the default's.
std::string default_ring(double x, double y);

// Seconds against error of every setting of a knob, both of the default's, the errors logarithmic;
// its corner at (x, y).
std::string knob_panel(const Bench& bench, const Knob& knob, double x, double y);

// Peers as marked points, seconds and errors of ours at the same work, both axes logarithmic; its
// corner at (x, y).
std::string peer_panel(const std::vector<Peer>& peers, double x, double y);

// Error against confidence over the width of two panels, a curve a map; its corner at (x, y).
inline constexpr double kConfidencePanelHeight = 430;
std::string confidence_panel(const std::vector<ConfidenceCurve>& curves, double x, double y);

}  // namespace lamella::apps
