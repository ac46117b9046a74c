#include "fit/layered_kernel.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/core/eigen.hpp>
#include <vector>

namespace lamella::fit {

namespace {

constexpr int kBasis = GaussianBasis::kSize;
constexpr int kRings = 64;
constexpr double kNearest_mm = 0.01, kFurthest_mm = 16;
constexpr double kProjectionRidge = 1e-7;   // of the trace
constexpr double kLeastEigenvalue = 1e-12;  // of the largest: below it nothing was measured
constexpr double kBlur_px = 0.43;  // one sigma of a box, 0.29, and of what lenses blur, 0.32
// Where pixels are coarser, what they hide of the shallow layer is not to be had back: noise would
// be taken for it.
constexpr double kMostBlur_mm = 0.25;
constexpr double kLdFactor = 2;  // either way from the tail's

// OpenCV's, not Eigen's: these cost the compiler most of a minute there.
using Matrix64 = cv::Mat_<double>;

double ring_mm(int i) {
  return kNearest_mm * std::pow(kFurthest_mm / kNearest_mm, i / (kRings - 1.0));
}

// From a profile at the rings to the weights of the blurred basis: least squares, weighted as a
// kernel of this length has light.
Matrix64 projection_of(double ld_mm, double footprint_mm) {
  Matrix64 basis(kRings, kBasis, 0.0), weight(kRings, kRings, 0.0);
  for (int i = 0; i < kRings; ++i) {
    const double r = ring_mm(i), light = r * std::exp(-r / ld_mm) / (2 * M_PI * ld_mm);
    weight(i, i) = r / std::sqrt(light + 1e-4);
    for (int j = 0; j < kBasis; ++j) {
      const double sigma = GaussianBasis::sigma_mm(j);
      if (sigma < 1.02 * footprint_mm) continue;  // no kernel is blurred as little
      const double s2 = sigma * sigma - footprint_mm * footprint_mm;
      basis(i, j) = weight(i, i) * std::exp(-r * r / (2 * s2)) / (2 * M_PI * s2);
    }
  }
  Matrix64 normal = basis.t() * basis, projection;
  normal += kProjectionRidge * cv::trace(normal)[0] / kBasis * Matrix64::eye(kBasis, kBasis);
  cv::solve(normal, basis.t() * weight, projection, cv::DECOMP_CHOLESKY);
  return projection;
}

// |root (w - best)|, squared, is the equations' cost but for a constant.
struct RingEquations {
  Matrix64 projection;  // kBasis x kRings
  Matrix64 root;
  Matrix64 target;

  // Of a kernel that has `value_at(r)` per mm^2, whatever it integrates to.
  template <class Real, class Value>
  void residuals(const Value& value_at, Real* residual) const {
    std::array<Real, kBasis> w;
    w.fill(Real(0));
    for (int i = 0; i < kRings; ++i) {
      const Real value = value_at(ring_mm(i));
      for (int j = 0; j < kBasis; ++j) w[size_t(j)] += projection(j, i) * value;
    }
    Real sum(0);
    for (const Real& weight : w) sum += weight;
    for (int k = 0; k < kBasis; ++k) {
      residual[k] = Real(-target(k));
      for (int j = 0; j < kBasis; ++j) residual[k] += root(k, j) * w[size_t(j)] / sum;
    }
  }
};

RingEquations equations_of(const WeightEquations& equations, double ld_mm, double footprint_mm) {
  Matrix64 a, b, values, vectors;
  cv::eigen2cv(equations.a, a);
  cv::eigen2cv(equations.b, b);
  cv::eigen(a, values, vectors);  // the largest first, a row of `vectors` each
  RingEquations rings{projection_of(ld_mm, footprint_mm), Matrix64(kBasis, kBasis),
                      Matrix64(vectors * b)};
  for (int k = 0; k < kBasis; ++k) {
    const double root = std::sqrt(std::max(values(k), kLeastEigenvalue * values(0)));
    rings.target(k) /= root;
    rings.root.row(k) = root * vectors.row(k);
  }
  return rings;
}

struct KernelResidual {
  RingEquations equations;
  double share, thickness_mm;

  template <class Real>
  bool operator()(const Real* deep_s, const Real* log_ld, const Real* shallow_s,
                  const Real* log_shallow_ld, Real* residual) const {
    using std::exp;
    equations.residuals(LayeredShape<Real>({*deep_s, exp(*log_ld)},
                                           {*shallow_s, exp(*log_shallow_ld)}, share, thickness_mm),
                        residual);
    return true;
  }
};

struct SingleResidual {
  RingEquations equations;

  template <class Real>
  bool operator()(const Real* s, const Real* log_ld, Real* residual) const {
    using std::exp;
    const model::Dipole<Real> skin{model::alpha_from_s(*s), Real(exp(*log_ld))};
    equations.residuals([&](double r_mm) { return model::dipole_reflectance(skin, r_mm); },
                        residual);
    return true;
  }
};

void bound_alpha(double* s, ceres::Problem* problem) {
  problem->SetParameterLowerBound(s, 0, model::s_from_alpha(kHighestAlpha));
  problem->SetParameterUpperBound(s, 0, model::s_from_alpha(kLowestAlpha));
}

void bound_length(double* log_mm, double low_mm, double high_mm, ceres::Problem* problem) {
  problem->SetParameterLowerBound(log_mm, 0, std::log(low_mm));
  problem->SetParameterUpperBound(log_mm, 0, std::log(high_mm));
}

double solve(ceres::Problem* problem) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 40;
  options.max_num_line_search_step_size_iterations = 0;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  return summary.final_cost;
}

double descend(const KernelResidual& residual, double ld_mm, LayeredKernel* at) {
  double log_ld = std::log(at->deep_ld_mm), log_shallow_ld = std::log(at->shallow_ld_mm);
  ceres::Problem problem;
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<KernelResidual, kBasis, 1, 1, 1, 1>(
                               new KernelResidual(residual)),
                           nullptr, &at->deep_s, &log_ld, &at->shallow_s, &log_shallow_ld);
  bound_alpha(&at->deep_s, &problem);
  bound_alpha(&at->shallow_s, &problem);
  bound_length(&log_ld, ld_mm / kLdFactor, ld_mm * kLdFactor, &problem);
  bound_length(&log_shallow_ld, kShortestShallowLd_mm, kLongestShallowLd_mm, &problem);
  const double cost = solve(&problem);
  at->deep_ld_mm = std::exp(log_ld);
  at->shallow_ld_mm = std::exp(log_shallow_ld);
  return cost;
}

double descend(const SingleResidual& residual, SingleKernel* at) {
  double log_ld = std::log(at->ld_mm);
  ceres::Problem problem;
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<SingleResidual, kBasis, 1, 1>(new SingleResidual(residual)),
      nullptr, &at->s, &log_ld);
  bound_alpha(&at->s, &problem);
  bound_length(&log_ld, kShortestDeepLd_mm, kLongestDeepLd_mm, &problem);
  const double cost = solve(&problem);
  at->ld_mm = std::exp(log_ld);
  return cost;
}

// Where the descent from one of `starts` costs least.
template <class Kernel, class Descent>
Kernel best_of(const std::vector<Kernel>& starts, const Descent& descent) {
  Kernel best = starts.front();
  double least = std::numeric_limits<double>::infinity();
  for (Kernel at : starts) {
    const double cost = descent(&at);
    if (cost >= least) continue;
    least = cost;
    best = at;
  }
  return best;
}

}  // namespace

double LayeredKernel::operator()(double r_mm) const {
  return LayeredShape<double>({deep_s, deep_ld_mm}, {shallow_s, shallow_ld_mm}, shallow_share,
                              thickness_mm)(r_mm);
}

double footprint_mm(const Camera& camera, const Camera& projector) {
  return std::min(kMostBlur_mm, kBlur_px * std::hypot(camera.pixel_mm(), projector.pixel_mm()));
}

LayeredKernel fit_layered_kernel(const WeightEquations& equations, const LayeredKernel& given,
                                 double footprint_mm) {
  const KernelResidual residual{equations_of(equations, given.deep_ld_mm, footprint_mm),
                                given.shallow_share, given.thickness_mm};
  std::vector<LayeredKernel> starts;
  // The valley has side arms, as that of fit_layered_profile().
  for (const auto& [deep_s, shallow_s, shallow_ld_mm] :
       {std::array{0.4, 0.3, 0.4}, {1.2, 0.17, 1.3}, {1.2, 1.0, 0.5}}) {
    starts.push_back(given);
    starts.back().deep_s = deep_s;
    starts.back().shallow_s = shallow_s;
    starts.back().shallow_ld_mm = shallow_ld_mm;
  }
  return best_of(starts,
                 [&](LayeredKernel* at) { return descend(residual, given.deep_ld_mm, at); });
}

LayeredKernel refine_layered_kernel(const WeightEquations& equations, const LayeredKernel& near,
                                    double footprint_mm) {
  LayeredKernel at = near;
  descend({equations_of(equations, near.deep_ld_mm, footprint_mm), near.shallow_share,
           near.thickness_mm},
          near.deep_ld_mm, &at);
  return at;
}

double SingleKernel::operator()(double r_mm) const {
  const model::Dipole<double> skin{model::alpha_from_s(s), ld_mm};
  return model::dipole_reflectance(skin, r_mm) / model::diffuse_reflectance_at_s(s);
}

SingleKernel fit_single_kernel(const WeightEquations& equations, double ld_mm,
                               double footprint_mm) {
  const SingleResidual residual{equations_of(equations, ld_mm, footprint_mm)};
  // A short dipole of dull skin and a long one of bright skin are alike nearby.
  const std::vector<SingleKernel> starts{{0.4, ld_mm}, {0.4, 0.4 * ld_mm}, {1.2, ld_mm}};
  return best_of(starts, [&](SingleKernel* at) { return descend(residual, at); });
}

SingleKernel refine_single_kernel(const WeightEquations& equations, const SingleKernel& near,
                                  double footprint_mm) {
  SingleKernel at = near;
  descend(SingleResidual{equations_of(equations, near.ld_mm, footprint_mm)}, &at);
  return at;
}

double prediction_cost(const WeightEquations& equations, const RadialProfile& kernel, double ld_mm,
                       double footprint_mm) {
  std::array<double, kBasis> residual;
  equations_of(equations, ld_mm, footprint_mm).residuals(kernel, residual.data());
  double cost = 0;
  for (double r : residual) cost += r * r;
  return cost;
}

}  // namespace lamella::fit
