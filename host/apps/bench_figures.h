// The figures by which the bench judges a fit: each a number out of comparison's report.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "apps/compare_statistics.h"

namespace lamella::apps {

struct BenchFigure {
  const char* name;  // as a column: "position_rms_mm"
  const char* label;
  const char* unit;                  // "" for a ratio
  std::array<const char*, 3> paths;  // JSON pointers, of which the mean is taken; nullptr: no more
};

const std::vector<BenchFigure>& bench_figures();

// By figure; NaN where `comparison` does not have it.
std::vector<double> figures_of(const Json& comparison);

// As it stands in a table for programs; nothing where it is not known.
std::string csv_number(double value);

// For people: "3.54 %" where `unit` is "", a ratio; "-" where it is not known.
std::string with_unit(double value, const std::string& unit);

}  // namespace lamella::apps
