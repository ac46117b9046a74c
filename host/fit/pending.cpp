// Steps whose rooms are still being built: each definition goes when its step lands.
#include "fit/scattering.h"

namespace lamella::fit {

// separate
Separation separate_layers(const Burst&, const Geometry&, const Normals&) { return {}; }

// scattering
Scattering fit_scattering(const Burst& burst, const Geometry&, const Normals&, const Separation&) {
  Scattering s;
  s.regions.resize(burst.region_names.size() - 1);
  return s;
}

// albedo
Albedo fit_albedo(const Burst&, const Geometry&, const Normals&) { return {}; }

}  // namespace lamella::fit
