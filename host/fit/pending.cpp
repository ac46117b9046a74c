// Steps whose rooms are still being built: each definition goes when its step lands.
#include "fit/scattering.h"
#include "fit/specular.h"

namespace lamella::fit {

// specular
SpecularFit fit_specular(const Burst& burst, const Geometry&, const Normals&) {
  SpecularFit s;
  s.lobes.resize(burst.region_names.size() - 1);
  s.single.resize(burst.region_names.size() - 1);
  return s;
}

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
