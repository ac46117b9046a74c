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

uint32_t within(const char* field, uint32_t value, uint32_t least, uint32_t most,
                const std::string& where) {
  if (value >= least && value <= most) return value;
  throw_bad_input(where, "quality." + std::string(field) + ": " + std::to_string(value),
                  "from " + std::to_string(least) + " to " + std::to_string(most));
}

}  // namespace

Quality quality_from_name(const std::string& name) {
  std::string known;
  for (const Quality& quality : kQualities) {
    if (quality.name == name) return quality;
    known += (known.empty() ? "" : ", ") + quality.name;
  }
  throw_bad_input("--quality", "no setting \"" + name + "\"", "one of " + known);
}

v1::Quality message_from_quality(const Quality& quality) {
  v1::Quality out;
  out.set_name(quality.name);
  out.set_bin_px(uint32_t(quality.bin_px));
  out.set_occlusion_rounds(uint32_t(quality.occlusion_rounds));
  out.set_relax_rounds(uint32_t(quality.relax_rounds));
  out.set_lobe_samples(uint32_t(quality.lobe_samples));
  out.set_lobe_rounds(uint32_t(quality.lobe_rounds));
  out.set_irradiance_cells(uint32_t(quality.irradiance_cells));
  return out;
}

Quality quality_from_message(const v1::Quality& message, const std::string& where) {
  Quality quality;
  quality.name = message.name();
  quality.bin_px = int(within("bin_px", message.bin_px(), 1, 16, where));
  quality.occlusion_rounds =
      int(within("occlusion_rounds", message.occlusion_rounds(), 1, 16, where));
  quality.relax_rounds = int(within("relax_rounds", message.relax_rounds(), 0, 64, where));
  quality.lobe_samples = int(within("lobe_samples", message.lobe_samples(), 4, 1000000, where));
  quality.lobe_rounds = int(within("lobe_rounds", message.lobe_rounds(), 1, 64, where));
  quality.irradiance_cells =
      int(within("irradiance_cells", message.irradiance_cells(), 2, 1024, where));
  return quality;
}

}  // namespace lamella::fit
