#include "fit/phase_asymmetry.h"

#include <algorithm>
#include <cmath>

#include "model/fresnel.h"
#include "model/single_scattering.h"

namespace lamella::fit {

namespace {

constexpr double kAlbedoUncertainty = 0.1;  // relative: the top layer absorbs as it likes
constexpr double kTypical = 0.65;           // Ghosh et al. 2008: 0.63 to 0.70

// Falls from alpha at g = 0 to 0 at g = 1.
double amplitude_at(double g, double reduced_albedo) {
  const double albedo = 1 / (1 + (1 - g) * (1 / reduced_albedo - 1));
  return model::amplitude_from_alpha(albedo / model::kAlbedoPerAlpha, g);
}

}  // namespace

double reduced_albedo_of(double diffuse_reflectance) {
  const double a = model::boundary_factor();
  // Solved for s = sqrt(3(1 - alpha')), in which eq. 8 is gentle at alpha' = 1.
  double low = 0, high = std::sqrt(3.0);
  for (int i = 0; i < 60; ++i) {
    const double s = (low + high) / 2;
    const double reflectance =
        (1 - s * s / 3) / 2 * (1 + std::exp(-4.0 / 3 * a * s)) * std::exp(-s);
    (reflectance > diffuse_reflectance ? low : high) = s;
  }
  return 1 - low * low / 3;
}

double asymmetry_of(double amplitude, double reduced_albedo) {
  double low = 0, high = 0.99;
  for (int i = 0; i < 60; ++i) {
    const double g = (low + high) / 2;
    (amplitude_at(g, reduced_albedo) > amplitude ? low : high) = g;
  }
  return (low + high) / 2;
}

PhaseAsymmetry estimate_asymmetry(const std::vector<RegionFit>& fits) {
  PhaseAsymmetry out;
  out.assumes =
      "the scattering albedo (alpha times ior^2) of the top layer is that of the whole skin's "
      "diffuse reflectance by eq. 8; measured is only the amplitude alpha (1-g)/(1+g)^2";
  for (size_t c = 0; c < 3; ++c) {
    double sum = 0, squares = 0, upper = 0;
    int count = 0;
    for (const RegionFit& fit : fits) {
      if (!fit.single.fitted || fit.single.amplitude[c] <= 0) continue;
      const double reduced = reduced_albedo_of(std::clamp(fit.diffuse_reflectance[c], 0.01, 0.9));
      const double g = asymmetry_of(fit.single.amplitude[c], reduced);
      sum += g;
      squares += g * g;
      upper += asymmetry_of(fit.single.amplitude[c] * (1 + kAlbedoUncertainty), reduced);
      ++count;
    }
    if (count == 0) {
      out.g[c] = kTypical;
      continue;
    }
    out.g[c] = sum / count;
    const double scatter = std::max(0.0, squares / count - out.g[c] * out.g[c]);
    const double assumed = out.g[c] - upper / count;
    out.g_stddev[c] = std::sqrt(scatter + assumed * assumed);
  }
  return out;
}

}  // namespace lamella::fit
