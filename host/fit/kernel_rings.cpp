#include "fit/kernel_rings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lamella::fit {

std::vector<Ring> rings_of(const RadialProfile& kernel, double from_mm, int count) {
  std::vector<Ring> rings;
  double largest = 0;
  for (int i = 0; i < count; ++i) {
    const double r = from_mm * std::pow(kFurthestRing_mm / from_mm, i / (count - 1.0));
    const double value = std::max(kernel(r), 1e-9);
    rings.push_back({r, value, std::sqrt(r * r * value)});
    largest = std::max(largest, rings.back().weight);
  }
  for (Ring& ring : rings) ring.weight /= largest;
  return rings;
}

std::string at_bound(const char* name, double value, double low, double high, const char* unit) {
  constexpr double kNearly = 1e-4;
  for (double bound : {low, high}) {
    if (std::abs(value - bound) <= kNearly * bound)
      return fmt::format("{}, {:g}{}", name, bound, unit);
  }
  return "";
}

ceres::Solver::Options quiet_options(double tolerance) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 60;
  options.function_tolerance = tolerance;
  options.max_num_line_search_step_size_iterations = 0;
  options.num_threads = 1;
  return options;
}

double stddev_of(ceres::Problem* problem, double* parameter) {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.null_space_rank = -1;
  ceres::Covariance covariance(options);
  double variance = 0;
  const std::vector<std::pair<const double*, const double*>> itself{{parameter, parameter}};
  if (!covariance.Compute(itself, problem)) return 0;
  covariance.GetCovarianceBlock(parameter, parameter, &variance);
  return std::sqrt(variance);
}

}  // namespace lamella::fit
