#include "fit/quality.h"

#include <array>

#include "base/error.h"

namespace lamella::fit {

namespace {

const std::array<Quality, 3> kQualities{{{.name = "draft",
                                          .bin_px = 2,
                                          .occlusion_rounds = 1,
                                          .relax_rounds = 1,
                                          .lobe_samples = 1500,
                                          .irradiance_cells = 25},
                                         {},
                                         {.name = "reference",
                                          .occlusion_rounds = 4,
                                          .relax_rounds = 6,
                                          .lobe_samples = 48000,
                                          .lobe_rounds = 8,
                                          .irradiance_cells = 193}}};

}  // namespace

Quality quality_from_name(const std::string& name) {
  std::string known;
  for (const Quality& quality : kQualities) {
    if (quality.name == name) return quality;
    known += (known.empty() ? "" : ", ") + quality.name;
  }
  throw_bad_input("--quality", "no setting \"" + name + "\"", "one of " + known);
}

}  // namespace lamella::fit
