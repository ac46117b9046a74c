#include "apps/bench_knobs.h"

namespace lamella::apps {

namespace {

using Field = int fit::Quality::*;

Knob knob(const std::string& name, const std::string& meaning, Field field,
          const std::vector<int>& values) {
  Knob out{name, meaning, {}};
  for (const int value : values) {
    fit::Quality quality;
    quality.*field = value;
    if (!is_default(quality)) quality.name = name + " " + std::to_string(value);
    out.settings.push_back({std::to_string(value), quality});
  }
  return out;
}

}  // namespace

std::vector<Knob> bench_knobs() {
  using fit::Quality;
  std::vector<Knob> knobs{
      {"quality", "all knobs together", {}},
      knob("bin_px", "pixels averaged into one, each way", &Quality::bin_px, {1, 2, 3, 4}),
      knob("occlusion_rounds", "normals against what hides their light", &Quality::occlusion_rounds,
           {1, 2, 3, 4}),
      knob("relax_rounds", "depths against normals", &Quality::relax_rounds, {0, 1, 3, 6}),
      knob("lobe_samples", "samples a region for the lobe", &Quality::lobe_samples,
           {375, 1500, 6000, 24000}),
      knob("lobe_rounds", "intensity against the lobe's shape", &Quality::lobe_rounds,
           {1, 2, 4, 8}),
      knob("irradiance_cells", "a side of the table of irradiance", &Quality::irradiance_cells,
           {13, 25, 49, 97, 193})};
  for (const char* name : {"draft", "standard", "reference"}) {
    knobs[0].settings.push_back({name, fit::quality_from_name(name)});
  }
  return knobs;
}

bool is_default(const fit::Quality& quality) { return quality == fit::Quality(); }

}  // namespace lamella::apps
