// Steps 6 to 9: stripes to shallow and deep, dots to l_d per region, the multipole from deep and
// shallow together, alpha' and total albedo per pixel (sec. 4.2, eq. 5 to 8).
#pragma once

#include <string>

#include "fit/doubt.h"
#include "fit/layer_choice.h"
#include "fit/normals.h"
#include "fit/one_layer.h"

namespace lamella::fit {

struct Separation {
  Image3 shallow_albedo;               // 2 A / E
  Image3 deep_albedo;                  // 4 M / E
  Image3 shallow_stddev, deep_stddev;  // of the camera's noise, and of skin taken for it
  Image1 confidence;                   // of the shallow albedo, and of the two together
  Image1 deep_confidence;              // of what the shallow share leaves
  double closure_rms = 0;              // of shallow + deep against FRONT - BLACK, relative
  // Both NaN where no stripe was measured. Of the squares of a pixel's four samples about the half
  // of FRONT - BLACK, the share that no swing explains; the median.
  double stripe_misfit = 0;
  // 1 where the stripes lie on the surface as everywhere else, 0 where they do not know of it.
  double stripe_coherence = 0;
};

struct RegionScattering {
  bool deep_fitted = false, shallow_fitted = false;
  std::string deep_why, shallow_why;
  Doubt deep_doubt = Doubt::kNone, shallow_doubt = Doubt::kNone;
  std::array<double, 3> ld_mm{}, ld_mm_stddev{}, alpha_dot{}, alpha_dot_stddev{}, deep_rms{};
  std::array<double, 3> shallow_alpha{}, shallow_alpha_stddev{}, shallow_ld_mm{},
      shallow_ld_mm_stddev{}, shallow_rms{};
  std::array<SingleLayer, 3> single_layer{};  // what one dipole would be for all of it
  double thickness_mm = 0.5;
  int dots = 0;
};

struct Scattering {
  std::vector<RegionScattering> regions;  // by label - 1
  OneLayerVerdict one_layer;              // of all regions, where layers were free to choose
  Image3 deep_ld_mm;                      // blended across region borders
  Image1 ld_confidence;                   // of that, by its regions' deviations
  Image3 deep_alpha;                      // from deep_albedo by eq. 8
};

struct Albedo {
  Image3 total;  // occlusion removed by inverse simulation
  Image1 confidence;
};

Separation separate_layers(const Burst& burst, const Geometry& geometry, const Normals& normals);

// Where one layer is asked for a dipole stands for all diffuse light, and `separation` has it in
// deep_albedo alone.
Scattering fit_scattering(const Burst& burst, const Geometry& geometry, const Normals& normals,
                          LayerUse use, Separation* separation);

Albedo fit_albedo(const Burst& burst, const Geometry& geometry, const Normals& normals);

}  // namespace lamella::fit
