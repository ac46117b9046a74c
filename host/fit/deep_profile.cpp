#include "fit/deep_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "fit/kernel_rings.h"
#include "fit/layered_kernel.h"
#include "model/diffuse_reflectance.h"
#include "model/dipole.h"

namespace lamella::fit {

namespace {

constexpr double kTransportSpread = 0.08;  // one sigma of the logarithm of 1/sigma_t'
constexpr double kTransportDoubt = 1;      // sigmas from which on it rather is not dermis's
constexpr double kTextureSpread = 0.2;     // one sigma of the logarithm of a region's texture
constexpr double kLeastAlpha = 1e-3;
constexpr double kTolerance = 1e-9;  // of a step's gain, relative
// A kernel that shows no tail (a surface that does not scatter) would take it to infinity.
constexpr double kShortestTransport_mm = 0.05, kLongestTransport_mm = 3;
// Relative, of a ring of the tail against a dipole's. A layered skin's tail bends otherwise than a
// dipole's all along, so that rings are wrong together: taken for 24 witnesses of an error of 0.05
// they outvote what is known of transport and reflectance, with lengths that are no skin's.
constexpr double kTailError = 0.15;
// Of it: less makes l_d no surer, as the priors of transport and reflectance stay what they are.
constexpr double kLeastMisfit = 0.7;

// A nearer one has shallow light.
constexpr double kNearestRing_mm = 1;
constexpr int kRings = 24;

struct TailResidual {
  Ring ring;
  template <class Real>
  bool operator()(const Real* log_ld, const Real* log_transport, const Real* log_amplitude,
                  Real* residual) const {
    using std::exp;
    using std::log;
    const Real ld = exp(*log_ld), z_r = exp(*log_transport);
    const Real z_v = z_r * (1.0 + 4.0 / 3.0 * model::kBoundaryFactor);
    const Real shape =
        model::source_term(z_r, ld, ring.r_mm) + model::source_term(z_v, ld, ring.r_mm);
    *residual = ring.weight * (*log_amplitude + log(shape / ring.value)) / kTailError;
    return true;
  }
};

// The kernel's tail has the share of all diffuse light that a dipole reflects.
struct TailAmplitude {
  double log_reflectance;
  template <class Real>
  bool operator()(const Real* log_ld, const Real* log_transport, const Real* log_amplitude,
                  Real* residual) const {
    using std::exp;
    using std::log;
    const Real s = exp(*log_transport - *log_ld);
    Real alpha = model::alpha_from_s(s);
    if (alpha < kLeastAlpha) alpha = Real(kLeastAlpha);
    *residual = (log(alpha / (4 * M_PI)) - *log_amplitude - log_reflectance) / kTextureSpread;
    return true;
  }
};

struct TailParameters {
  double log_ld, log_transport, log_amplitude;
};

struct TailEquations {
  std::vector<Ring> rings;
  SkinPrior prior;
};

struct Tail {
  TailParameters at{};
  double cost = std::numeric_limits<double>::infinity();
};

void pose(const TailEquations& equations, TailParameters* at, ceres::Problem* problem) {
  double* ld = &at->log_ld;
  double* transport = &at->log_transport;
  for (const Ring& ring : equations.rings) {
    problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<TailResidual, 1, 1, 1, 1>(new TailResidual{ring}), nullptr,
        ld, transport, &at->log_amplitude);
  }
  const LogPrior dermis{std::log(equations.prior.transport_mm), kTransportSpread};
  problem->AddResidualBlock(new ceres::AutoDiffCostFunction<LogPrior, 1, 1>(new LogPrior(dermis)),
                            new ceres::CauchyLoss(kTransportDoubt), transport);
  if (equations.prior.reflectance > 0) {
    const TailAmplitude amplitude{std::log(equations.prior.reflectance)};
    problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<TailAmplitude, 1, 1, 1, 1>(new TailAmplitude(amplitude)),
        nullptr, ld, transport, &at->log_amplitude);
  }
  problem->SetParameterLowerBound(ld, 0, std::log(kShortestDeepLd_mm));
  problem->SetParameterUpperBound(ld, 0, std::log(kLongestDeepLd_mm));
  problem->SetParameterLowerBound(transport, 0, std::log(kShortestTransport_mm));
  problem->SetParameterUpperBound(transport, 0, std::log(kLongestTransport_mm));
}

Tail descend(const TailEquations& equations, const TailParameters& from) {
  Tail tail{from, 0};
  ceres::Problem problem;
  pose(equations, &tail.at, &problem);
  ceres::Solver::Summary summary;
  ceres::Solve(quiet_options(kTolerance), &problem, &summary);
  tail.cost = summary.final_cost;
  return tail;
}

DeepProfile profile_of(const TailEquations& equations, Tail tail) {
  ceres::Problem problem;
  pose(equations, &tail.at, &problem);
  DeepProfile deep;
  deep.ld_mm = std::exp(tail.at.log_ld);
  deep.at_bound = at_bound("l_d", deep.ld_mm, kShortestDeepLd_mm, kLongestDeepLd_mm, " mm");
  deep.transport_mm = std::min(std::exp(tail.at.log_transport), 1.7 * deep.ld_mm);
  double weight = 0;
  for (const Ring& ring : equations.rings) weight += ring.weight * ring.weight;
  deep.rms = kTailError * std::sqrt(2 * tail.cost / weight);
  // Rings that are further off than they are taken to be say less of l_d, nearer ones more.
  const double misfit = std::max(kLeastMisfit, deep.rms / kTailError);
  deep.ld_mm_stddev = misfit * deep.ld_mm * stddev_of(&problem, &tail.at.log_ld);
  return deep;
}

}  // namespace

DeepProfile fit_deep_profile(const RadialProfile& kernel, const SkinPrior& prior) {
  const TailEquations equations{rings_of(kernel, kNearestRing_mm, kRings), prior};
  Tail best;
  // Dermis, or what is left of it under much melanin.
  for (double factor : {1.0, 3.0}) {
    const double log_z = std::log(factor * prior.transport_mm);
    const Tail tail = descend(equations, {log_z + std::log(1.5), log_z, -2});
    if (tail.cost < best.cost) best = tail;
  }
  return profile_of(equations, best);
}

}  // namespace lamella::fit
