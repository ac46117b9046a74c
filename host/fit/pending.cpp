// Steps whose rooms are still being built: each definition goes when its step lands.
#include "fit/scattering.h"

namespace lamella::fit {

// scattering
Scattering fit_scattering(const Burst& burst, const Geometry&, const Normals&, const Separation&) {
  Scattering s;
  s.regions.resize(burst.region_names.size() - 1);
  return s;
}

}  // namespace lamella::fit
