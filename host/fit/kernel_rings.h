// A kernel at rings about where light enters, and how its layers' parameters are descended to.
#pragma once

#include <ceres/ceres.h>

#include <string>
#include <vector>

#include "fit/gaussian_basis.h"

namespace lamella::fit {

inline constexpr double kFurthestRing_mm = 8;

struct Ring {
  double r_mm, value, weight;
};

// At equal steps of log r, each weighted by the root of the light in it; the largest weight is 1.
std::vector<Ring> rings_of(const RadialProfile& kernel, double from_mm, int count);

// "alpha, 0.02" where a value stands at either of its bounds.
std::string at_bound(const char* name, double value, double low, double high, const char* unit);

// Of a parameter that is a logarithm.
struct LogPrior {
  double mean, sigma;
  template <class Real>
  bool operator()(const Real* log_value, Real* residual) const {
    *residual = (*log_value - mean) / sigma;
    return true;
  }
};

// `tolerance`: of a step's gain, relative.
ceres::Solver::Options quiet_options(double tolerance);

// One sigma of a parameter of the problem where it stands; 0 where the problem does not tell.
double stddev_of(ceres::Problem* problem, double* parameter);

}  // namespace lamella::fit
