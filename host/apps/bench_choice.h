// Settings of a fit out of what a bench measured.
#pragma once

#include <optional>
#include <string>

#include "apps/report.h"
#include "fit/quality.h"

namespace lamella::apps {

// "position_rms_mm<=0.3", the figure a column of bench.csv. Throws Error where `text` is none.
FigureLimit error_limit_from(const std::string& text);

struct BenchChoice {
  fit::Quality quality;
  double seconds;  // that a fit of so many pixels should take
};

// Of the settings in `table` (the contents of a bench.json, which stands at `where`) that are
// within the budget and the limit: with a budget the one of least error, by the mean of its figures
// over the default's; without, the quickest. Seconds are taken to grow with `pixels`. Throws Error
// where none is within them, with what there is.
BenchChoice choose_setting(const v1::Bench& table, const std::string& where, uint32_t pixels,
                           std::optional<double> budget_s, const std::optional<FigureLimit>& limit);

}  // namespace lamella::apps
