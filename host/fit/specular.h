// Steps 4 and 5, specular and single: lobe tables per region, specular intensity per pixel and
// single scattering per region and channel, told apart together (eq. 1, 3, 4).
#pragma once

#include <string>

#include "fit/doubt.h"
#include "fit/normals.h"

namespace lamella::fit {

struct RegionLobe {
  bool fitted = false;
  std::string why;  // where not fitted, or in doubt
  Doubt doubt = Doubt::kNone;
  std::vector<double> theta_rad;    // 0 to pi/4
  std::vector<double> p, p_stddev;  // per steradian, integral of p cos over the hemisphere is 1
  double gaussian_m = 0, gaussian_m_stddev = 0;
};

struct RegionSingle {
  bool fitted = false;
  std::string why;
  Doubt doubt = Doubt::kNone;
  std::array<double, 3> amplitude{}, amplitude_stddev{};  // alpha (1-g)/(1+g)^2
};

struct SpecularFit {
  std::vector<RegionLobe> lobes;     // by label - 1
  std::vector<RegionSingle> single;  // by label - 1
  std::array<double, 3> g{}, g_stddev{};
  std::string g_assumes;
  Image1 intensity;  // c of eq. 1
  Image1 intensity_confidence;
  Image1 intensity_stddev;                 // of the camera's noise alone
  Image3 single_albedo;                    // alpha of eq. 3 as printed
  Image3 single_stddev;                    // of its region's amplitude
  Image3 polarized_front, polarized_full;  // S under FRONT and GRADIENT_FULL as the fit predicts it
};

SpecularFit fit_specular(const Burst& burst, const Geometry& geometry, const Normals& normals);

}  // namespace lamella::fit
