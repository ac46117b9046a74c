// The definitions by which `truth/` states a known skin in the words of a fit.
#pragma once

#include <array>
#include <vector>

#include "twin/skin.h"

namespace lamella::twin {

// Profile of the dipole (eq. 7) with reduced albedo `alpha` and diffuse mean free path `ld_mm`.
double dipole(double r_mm, double alpha, double ld_mm);

struct DipoleFit {
  double alpha = 0, ld_mm = 0;
};

// The dipole nearest to a Monte Carlo profile between 1 and 8 mm: logarithmic residuals, weighted
// by the light that is there.
DipoleFit nearest_dipole(const Profile& profile);

// Reduced albedo of the dipole whose integral (eq. 8) is `reflectance`; NaN outside (0, 1).
double alpha_of_reflectance(double reflectance);

// m of a exp(-(theta/m)^2) nearest to the table by least squares.
double gaussian_width(const std::vector<double>& theta, const std::vector<double>& p);

}  // namespace lamella::twin
