#include "fit/layer_profile.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "fit/layered_kernel.h"
#include "model/multipole.h"

namespace lamella::fit {

namespace {

constexpr double kTransportSpread = 0.08;  // one sigma of the logarithm of 1/sigma_t'
constexpr double kTransportDoubt = 1;      // sigmas from which on it rather is not dermis's
constexpr double kTextureSpread = 0.2;     // one sigma of the logarithm of a region's texture
constexpr double kLeastAlpha = 1e-3;
constexpr double kTolerance = 1e-9;          // of a step's gain, relative
constexpr double kToleranceOfSpread = 1e-5;  // where figures tell a deviation and nothing else
// A kernel that shows no tail (a surface that does not scatter) would take it to infinity.
constexpr double kShortestTransport_mm = 0.05, kLongestTransport_mm = 3;
// Relative, of a ring of the tail against a dipole's. A layered skin's tail bends otherwise than a
// dipole's all along, so that rings are wrong together: taken for 24 witnesses of an error of 0.05
// they outvote what is known of transport and reflectance, with lengths that are no skin's.
constexpr double kTailError = 0.15;
// Of it: less makes l_d no surer, as the priors of transport and reflectance stay what they are.
constexpr double kLeastMisfit = 0.7;
constexpr double kKernelError = 0.05;  // relative, of what the dots say of the kernel
constexpr double kFurthestSample_mm = 8, kNearestSample_mm = 0.1;
constexpr double kSmallestShare = 0.02;   // a layer with less is within the noise
constexpr double kSmallestAlbedo = 0.01;  // of a slab: nearly nothing, but light
constexpr double kSlabAlbedoError = 0.5;  // of its logarithm: transmittance, texture, diffusion

// "alpha, 0.02" where a value stands at either of its bounds.
std::string at_bound(const char* name, double value, double low, double high, const char* unit) {
  constexpr double kNearly = 1e-4;
  for (double bound : {low, high}) {
    if (std::abs(value - bound) <= kNearly * bound)
      return fmt::format("{}, {:g}{}", name, bound, unit);
  }
  return "";
}

struct Sample {
  double r_mm, value, weight;
};

// Rings at equal steps of log r, each weighted by the root of the light in it.
std::vector<Sample> sample_kernel(const RadialProfile& kernel, double from_mm, double to_mm,
                                  int count) {
  std::vector<Sample> samples;
  double largest = 0;
  for (int i = 0; i < count; ++i) {
    const double r = from_mm * std::pow(to_mm / from_mm, i / (count - 1.0));
    const double value = std::max(kernel(r), 1e-9);
    samples.push_back({r, value, std::sqrt(r * r * value)});
    largest = std::max(largest, samples.back().weight);
  }
  for (Sample& s : samples) s.weight /= largest;
  return samples;
}

struct TailResidual {
  Sample sample;
  template <class Real>
  bool operator()(const Real* log_ld, const Real* log_transport, const Real* log_amplitude,
                  Real* residual) const {
    using std::exp;
    using std::log;
    const Real ld = exp(*log_ld), z_r = exp(*log_transport);
    const Real z_v = z_r * (1.0 + 4.0 / 3.0 * model::kBoundaryFactor);
    const Real shape =
        model::source_term(z_r, ld, sample.r_mm) + model::source_term(z_v, ld, sample.r_mm);
    *residual = sample.weight * (*log_amplitude + log(shape / sample.value)) / kTailError;
    return true;
  }
};

struct LogPrior {
  double mean, sigma;
  template <class Real>
  bool operator()(const Real* log_value, Real* residual) const {
    *residual = (*log_value - mean) / sigma;
    return true;
  }
};

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
  std::vector<Sample> rings;
  SkinPrior prior;
};

struct Tail {
  TailParameters at{};
  double cost = std::numeric_limits<double>::infinity();
};

void pose(const TailEquations& equations, TailParameters* at, ceres::Problem* problem) {
  double* ld = &at->log_ld;
  double* transport = &at->log_transport;
  for (const Sample& sample : equations.rings) {
    problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<TailResidual, 1, 1, 1, 1>(new TailResidual{sample}),
        nullptr, ld, transport, &at->log_amplitude);
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
  for (const Sample& sample : equations.rings) weight += sample.weight * sample.weight;
  deep.rms = kTailError * std::sqrt(2 * tail.cost / weight);
  // Rings that are further off than they are taken to be say less of l_d, nearer ones more.
  const double misfit = std::max(kLeastMisfit, deep.rms / kTailError);
  deep.ld_mm_stddev = misfit * deep.ld_mm * stddev_of(&problem, &tail.at.log_ld);
  return deep;
}

// Sum of deep and shallow, each scaled to its share, against the kernel.
struct LayeredResidual {
  Sample sample;
  double scale;  // ring's area over the mean light of a ring, in units of the kernel's error
  double ld_mm, shallow_share, thickness_mm;

  template <class Real>
  bool operator()(const Real* deep_s, const Real* shallow_s, const Real* log_shallow_ld,
                  Real* residual) const {
    using std::exp;
    const LayeredShape<Real> shape({*deep_s, Real(ld_mm)}, {*shallow_s, exp(*log_shallow_ld)},
                                   shallow_share, thickness_mm);
    *residual = scale * (shape(sample.r_mm) - sample.value);
    return true;
  }
};

// The slab reflects what the stripes measured. The shape of the kernel alone hardly tells its
// albedo from its mean free path, and runs off to slabs that are no light's (sec. 4.2: the shallow
// albedo constrains the fit).
struct SlabAlbedo {
  double measured, thickness_mm;

  template <class Real>
  bool operator()(const Real* shallow_s, const Real* log_shallow_ld, Real* residual) const {
    using std::exp;
    using std::log;
    const model::Multipole<Real> slab{model::alpha_from_s(*shallow_s), Real(exp(*log_shallow_ld)),
                                      thickness_mm};
    const Real total = model::multipole_total(slab);
    if (!(total > 0.0)) return false;  // no step goes there
    *residual = log(total / measured) / kSlabAlbedoError;
    return true;
  }
};

struct LayeredParameters {
  double deep_s, shallow_s, log_shallow_ld;
};

struct LayeredEquations {
  std::vector<LayeredResidual> rings;
  SlabAlbedo slab;
};

using LayeredCost = ceres::AutoDiffCostFunction<LayeredResidual, 1, 1, 1, 1>;

// Robust, as no sum of two layers follows a skin everywhere: many rings should be right, not all
// equally wrong.
void pose(const LayeredEquations& equations, LayeredParameters* at, ceres::Problem* problem) {
  for (const LayeredResidual& residual : equations.rings) {
    problem->AddResidualBlock(new LayeredCost(new LayeredResidual(residual)),
                              new ceres::SoftLOneLoss(1.0), &at->deep_s, &at->shallow_s,
                              &at->log_shallow_ld);
  }
  problem->AddResidualBlock(
      new ceres::AutoDiffCostFunction<SlabAlbedo, 1, 1, 1>(new SlabAlbedo(equations.slab)), nullptr,
      &at->shallow_s, &at->log_shallow_ld);
  for (double* s : {&at->deep_s, &at->shallow_s}) {
    problem->SetParameterLowerBound(s, 0, model::s_from_alpha(kHighestAlpha));
    problem->SetParameterUpperBound(s, 0, model::s_from_alpha(kLowestAlpha));
  }
  problem->SetParameterLowerBound(&at->log_shallow_ld, 0, std::log(kShortestShallowLd_mm));
  problem->SetParameterUpperBound(&at->log_shallow_ld, 0, std::log(kLongestShallowLd_mm));
}

double descend(const LayeredEquations& equations, double tolerance, LayeredParameters* at) {
  ceres::Problem problem;
  pose(equations, at, &problem);
  ceres::Solver::Summary summary;
  ceres::Solve(quiet_options(tolerance), &problem, &summary);
  return summary.final_cost;
}

// Where descents ended, the best first.
struct Arm {
  LayeredParameters at;
  double cost;
};

// The valley has side arms (a thin slab that scatters much, a thick one that scatters little): four
// descents.
std::vector<LayeredParameters> usual_starts(double deep_s) {
  return {{deep_s, 0.3, std::log(0.4)},
          {1.2, 0.17, std::log(1.3)},
          {0.65, 0.16, std::log(1.9)},
          {1.2, 1.0, std::log(0.5)}};
}

std::vector<Arm> find_arms(const LayeredEquations& equations,
                           const std::vector<LayeredParameters>& starts) {
  std::vector<Arm> arms;
  for (LayeredParameters at : starts) {
    const double cost = descend(equations, kTolerance, &at);
    arms.push_back({at, cost});
  }
  std::stable_sort(arms.begin(), arms.end(),
                   [](const Arm& a, const Arm& b) { return a.cost < b.cost; });
  return arms;
}

LayeredProfile figures_of(const LayeredParameters& at) {
  LayeredProfile profile;
  profile.alpha_dot = model::alpha_from_s(at.deep_s);
  profile.shallow_alpha = model::alpha_from_s(at.shallow_s);
  profile.shallow_ld_mm = std::exp(at.log_shallow_ld);
  return profile;
}

LayeredProfile profile_at(const LayeredEquations& equations, LayeredParameters at) {
  ceres::Problem problem;
  pose(equations, &at, &problem);
  LayeredProfile profile = figures_of(at);
  profile.deep_at_bound = at_bound("alpha_dot", profile.alpha_dot, kLowestAlpha, kHighestAlpha, "");
  profile.shallow_at_bound =
      at_bound("alpha", profile.shallow_alpha, kLowestAlpha, kHighestAlpha, "");
  if (profile.shallow_at_bound.empty()) {
    profile.shallow_at_bound =
        at_bound("l_d", profile.shallow_ld_mm, kShortestShallowLd_mm, kLongestShallowLd_mm, " mm");
  }
  profile.alpha_dot_stddev = 2 * at.deep_s / 3 * stddev_of(&problem, &at.deep_s);
  profile.shallow_alpha_stddev = 2 * at.shallow_s / 3 * stddev_of(&problem, &at.shallow_s);
  profile.shallow_ld_mm_stddev = profile.shallow_ld_mm * stddev_of(&problem, &at.log_shallow_ld);
  double error = 0;
  for (const LayeredResidual& residual : equations.rings) {
    double value = 0;
    residual(&at.deep_s, &at.shallow_s, &at.log_shallow_ld, &value);
    error += value * value / double(equations.rings.size());
  }
  profile.shallow_rms = kKernelError * std::sqrt(error);
  return profile;
}

// What costs hardly more than the best might as well be it: the cost is minus the logarithm of the
// likelihood. `off`: the furthest from `profile` of all that were looked at, weighted.
void look_at(const LayeredProfile& other, double more_cost, const LayeredProfile& profile,
             LayeredProfile* off) {
  const double weight = std::exp(-more_cost / 2);
  const auto move = [&](double to, double from, double* furthest) {
    *furthest = std::max(*furthest, weight * std::abs(to - from));
  };
  move(other.alpha_dot, profile.alpha_dot, &off->alpha_dot);
  move(other.shallow_alpha, profile.shallow_alpha, &off->shallow_alpha);
  move(other.shallow_ld_mm, profile.shallow_ld_mm, &off->shallow_ld_mm);
}

void widen_by_arms(const std::vector<Arm>& arms, LayeredProfile* profile) {
  LayeredProfile off;
  for (const Arm& arm : arms) {
    look_at(figures_of(arm.at), arm.cost - arms.front().cost, *profile, &off);
  }
  widen(off, profile);
}

double cost_of_slab(const std::array<SlabProfiles, 3>& channels, size_t slab) {
  return channels[0][slab].cost + channels[1][slab].cost + channels[2][slab].cost;
}

void judge_shallow(double share, LayeredProfile* profile) {
  profile->shallow_fitted = share >= kSmallestShare;
  if (!profile->shallow_fitted) {
    profile->shallow_why = "the stripes show no shallow light above the noise";
  }
}

LayeredEquations ring_equations(const RadialProfile& kernel, const DeepProfile& deep,
                                const ShallowLight& shallow, double thickness_mm) {
  const std::vector<Sample> samples =
      sample_kernel(kernel, kNearestSample_mm, kFurthestSample_mm, 32);
  double light = 0;
  for (const Sample& sample : samples) light += sample.r_mm * sample.r_mm * sample.value / 32;
  LayeredEquations equations{{}, {std::max(shallow.albedo, kSmallestAlbedo), thickness_mm}};
  for (const Sample& sample : samples) {
    const double scale = sample.r_mm * sample.r_mm / (light * kKernelError);
    equations.rings.push_back({sample, scale, deep.ld_mm, shallow.share, thickness_mm});
  }
  return equations;
}

}  // namespace

DeepProfile fit_deep_profile(const RadialProfile& kernel, const SkinPrior& prior) {
  const TailEquations equations{sample_kernel(kernel, 1.0, kFurthestSample_mm, 24), prior};
  Tail best;
  // Dermis, or what is left of it under much melanin.
  for (double factor : {1.0, 3.0}) {
    const double log_z = std::log(factor * prior.transport_mm);
    const Tail tail = descend(equations, {log_z + std::log(1.5), log_z, -2});
    if (tail.cost < best.cost) best = tail;
  }
  return profile_of(equations, best);
}

SlabProfiles fit_layered_profiles(const RadialProfile& kernel, const DeepProfile& deep,
                                  const ShallowLight& shallow) {
  const std::vector<LayeredParameters> starts = usual_starts(deep.transport_mm / deep.ld_mm);
  SlabProfiles profiles;
  for (size_t i = 0; i < kSlabs_mm.size(); ++i) {
    const LayeredEquations equations = ring_equations(kernel, deep, shallow, kSlabs_mm[i]);
    const std::vector<Arm> arms = find_arms(equations, starts);
    LayeredProfile& profile = profiles[i];
    profile = profile_at(equations, arms.front().at);
    widen_by_arms(arms, &profile);
    profile.thickness_mm = kSlabs_mm[i];
    profile.cost = arms.front().cost;
    profile.deep_rms = deep.rms;
    if (!deep.at_bound.empty()) profile.deep_at_bound = deep.at_bound;
    judge_shallow(shallow.share, &profile);
  }
  return profiles;
}

size_t best_slab(const std::array<SlabProfiles, 3>& channels) {
  size_t best = 0;
  for (size_t slab = 1; slab < kSlabs_mm.size(); ++slab) {
    if (cost_of_slab(channels, slab) < cost_of_slab(channels, best)) best = slab;
  }
  return best;
}

std::array<LayeredProfile, 3> on_best_slab(const std::array<SlabProfiles, 3>& channels) {
  const size_t best = best_slab(channels);
  std::array<LayeredProfile, 3> profiles;
  for (size_t c = 0; c < 3; ++c) {
    profiles[c] = channels[c][best];
    LayeredProfile off;
    for (size_t slab = 0; slab < kSlabs_mm.size(); ++slab) {
      const double more_cost = cost_of_slab(channels, slab) - cost_of_slab(channels, best);
      look_at(channels[c][slab], more_cost, channels[c][best], &off);
    }
    widen(off, &profiles[c]);
  }
  return profiles;
}

void widen(const LayeredProfile& by, LayeredProfile* profile) {
  const auto add = [](double more, double* stddev) { *stddev = std::hypot(*stddev, more); };
  add(by.alpha_dot, &profile->alpha_dot_stddev);
  add(by.shallow_alpha, &profile->shallow_alpha_stddev);
  add(by.shallow_ld_mm, &profile->shallow_ld_mm_stddev);
}

LayeredProfile refine_layered_profile(const RadialProfile& kernel, const DeepProfile& deep,
                                      const ShallowLight& shallow, const LayeredProfile& near) {
  LayeredParameters at{model::s_from_alpha(near.alpha_dot), model::s_from_alpha(near.shallow_alpha),
                       std::log(near.shallow_ld_mm)};
  descend(ring_equations(kernel, deep, shallow, near.thickness_mm), kToleranceOfSpread, &at);
  return figures_of(at);
}

}  // namespace lamella::fit
