// What the panels of the bench's page share.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "apps/bench_peers.h"

namespace lamella::apps {

inline constexpr double kPanelWidth = 560, kPanelHeight = 330;
// Around the axes of a panel.
inline constexpr double kPanelLeft = 62, kPanelRight = 24, kPanelAbove = 54, kPanelBelow = 46;
inline constexpr const char* kChartDefault = "#b3362b";

// Figures of the page, by their place in bench_figures().
struct Curve {
  size_t figure;
  const char* colour;
};
inline constexpr std::array<Curve, 9> kCurves{{{1, "#2f6db3"},
                                               {2, "#1b9a8f"},
                                               {4, "#e0a23c"},
                                               {6, "#22262b"},
                                               {7, "#8a5fb0"},
                                               {8, "#3d8b3d"},
                                               {9, "#d0679d"},
                                               {10, "#7a4a2b"},
                                               {11, "#555f6b"}}};

// A ring where both seconds and errors are the default's.
std::string default_ring(double x, double y);

// Peers as marked points, seconds and errors of ours at the same work, both axes logarithmic; its
// corner at (x, y).
std::string peer_panel(const std::vector<Peer>& peers, double x, double y);

// Error against confidence over the width of two panels, a curve a map; its corner at (x, y).
inline constexpr double kConfidencePanelHeight = 430;
std::string confidence_panel(const std::vector<ConfidenceCurve>& curves, double x, double y);

}  // namespace lamella::apps
