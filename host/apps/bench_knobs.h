// The knobs of a fit and the values that the bench turns each of them to.
#pragma once

#include <string>
#include <vector>

#include "fit/quality.h"

namespace lamella::apps {

struct BenchSetting {
  std::string value;  // as it stands in a table: "2"
  fit::Quality quality;
};

struct Knob {
  std::string name;  // a field of fit::Quality, or "quality": all of them
  std::string meaning;
  std::vector<BenchSetting> settings;  // one of them is the default's
};

// All other fields are the default's.
std::vector<Knob> bench_knobs();

// Whether a fit of these settings is the default's fit.
bool is_default(const fit::Quality& quality);

}  // namespace lamella::apps
