// Does a knob's default sit where more seconds stop to pay?
#pragma once

#include <string>

#include "apps/bench_run.h"

namespace lamella::apps {

// Figures by which the page judges, by their place in bench_figures().
struct Curve {
  size_t figure;
  const char* colour;
};
inline constexpr std::array<Curve, 9> kCurves{{{1, "#2f6db3"},
                                               {2, "#1b9a8f"},
                                               {4, "#e0a23c"},
                                               {6, "#9aa32c"},
                                               {7, "#8a5fb0"},
                                               {8, "#3d8b3d"},
                                               {9, "#d0679d"},
                                               {10, "#7a4a2b"},
                                               {11, "#6f7f92"}}};

// The geometric mean of those figures, each of the default's; NaN where the two have none in
// common.
double mean_error(const Bench& bench, const BenchPoint& point);

// A setting pays where its error is less than the default's by more than what its seconds are more,
// to the power of 1/4: twice the seconds for a sixth less error. What rounds differ by is no gain.
inline constexpr double kSecondsPower = 0.25;

struct Knee {
  std::string value;  // the default's
  bool is_there;      // no other setting pays
  std::string words;  // "2: 22 % quicker, 2.4 times the error; 4: 31 % slower, the same error"
};

// `knob` is one of the bench's.
Knee knee_of(const Bench& bench, const std::string& knob);

}  // namespace lamella::apps
