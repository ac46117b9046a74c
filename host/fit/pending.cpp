// Steps whose rooms are still being built: each definition goes when its step lands.
#include "fit/scattering.h"
#include "fit/specular.h"

namespace lamella::fit {

// geometry
Geometry reconstruct_geometry(const Burst& burst) {
  Geometry g;
  const cv::Size size = burst.regions.size();
  g.position_mm = Image3(size, Vec3(kNaN, kNaN, kNaN));
  g.sigma_mm = Image1(size, kNaN);
  return g;
}

// normals
Normals estimate_normals(const Burst& burst, Geometry*) {
  Normals n;
  const cv::Size size = burst.regions.size();
  n.specular = Image3(size, Vec3(kNaN, kNaN, kNaN));
  for (Image3& d : n.diffuse) d = n.specular.clone();
  return n;
}

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
