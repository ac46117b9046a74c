// Words in a chart (SVG), and the colours that charts share.
#pragma once

#include <string>

namespace lamella::apps {

inline constexpr const char* kChartInk = "#22262b";
inline constexpr const char* kChartFaint = "#7a828c";
inline constexpr const char* kChartGrid = "#e4dfd6";

// The head of a chart of that size in pixels, and its ground.
std::string chart_head(double width, double height);

// `anchor`: which end of the words is at x: start, middle or end.
std::string chart_label(double x, double y, const std::string& words, double size,
                        const char* colour, const char* anchor = "start");

}  // namespace lamella::apps
