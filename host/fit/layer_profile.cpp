#include "fit/layer_profile.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <vector>

#include "fit/kernel_rings.h"
#include "fit/layered_kernel.h"
#include "model/multipole.h"

namespace lamella::fit {

namespace {

constexpr double kSlabTolerance = 1e-9;      // of a step's gain, relative
constexpr double kToleranceOfSpread = 1e-5;  // where figures tell a deviation and nothing else
constexpr double kKernelError = 0.05;        // relative, of what the dots say of the kernel
constexpr double kNearestOfKernel_mm = 0.1;
constexpr int kRingCount = 32;
constexpr double kSmallestShare = 0.02;   // a layer with less is within the noise
constexpr double kSmallestAlbedo = 0.01;  // of a slab: nearly nothing, but light
// Of its logarithm: diffusion and texture, and what is above the slab. Dark skin's melanin leaves a
// tenth of its light.
constexpr double kSlabAlbedoError = 1;
// What tissue is like, one sigma of the logarithm each: 1/sigma_t' of the slab against dermis's,
// the deep dipole's in the whole kernel against that in its tail, and the slab's l_d. A slab that
// is thinner than its l_d hardly absorbs, and how hardly no kernel tells.
constexpr double kSlabTransportSpread = 0.3, kDeepTransportSpread = 0.5, kSlabLdSpread = 0.5;
constexpr double kUsualSlabLd_mm = 1;

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

struct SlabTransport {
  double log_usual_mm;

  template <class Real>
  bool operator()(const Real* shallow_s, const Real* log_shallow_ld, Real* residual) const {
    using std::log;
    *residual = (log(*shallow_s) + *log_shallow_ld - log_usual_mm) / kSlabTransportSpread;
    return true;
  }
};

struct DeepTransport {
  double log_s_of_tail;

  template <class Real>
  bool operator()(const Real* deep_s, Real* residual) const {
    using std::log;
    *residual = (log(*deep_s) - log_s_of_tail) / kDeepTransportSpread;
    return true;
  }
};

struct LayeredParameters {
  double deep_s, shallow_s, log_shallow_ld;
};

// Sum of deep and shallow, each scaled to its share, against the kernel. A ring's weight is its
// area over the mean light of a ring, in units of the kernel's error.
struct LayeredEquations {
  std::vector<Ring> rings;
  double ld_mm, shallow_share;
  SlabAlbedo slab;
  SlabTransport slab_transport;
  DeepTransport deep_transport;

  template <class Real>
  LayeredShape<Real> shape(const Real& deep_s, const Real& shallow_s,
                           const Real& log_shallow_ld) const {
    using std::exp;
    return {
        {deep_s, Real(ld_mm)}, {shallow_s, exp(log_shallow_ld)}, shallow_share, slab.thickness_mm};
  }
};

// How far all rings are off, with slopes, reckoned at once: they share the layers' shape.
class LayeredRings final : public ceres::EvaluationCallback {
 public:
  using Dual = ceres::Jet<double, 3>;

  // `at`: where the solver puts what it tries.
  LayeredRings(const LayeredEquations& equations, const LayeredParameters& at)
      : equations_(equations), at_(at), off_(equations.rings.size()) {}

  void PrepareForEvaluation(bool with_slopes, bool is_new) override {
    if (!is_new && (has_slopes_ || !with_slopes)) return;
    has_slopes_ = with_slopes;
    const auto& [deep_s, shallow_s, log_ld] = at_;
    if (with_slopes) {
      measure(equations_.shape(Dual(deep_s, 0), Dual(shallow_s, 1), Dual(log_ld, 2)));
    } else {
      measure(equations_.shape(deep_s, shallow_s, log_ld));
    }
  }

  const Dual& off(size_t ring) const { return off_[ring]; }

 private:
  template <class Shape>
  void measure(const Shape& shape) {
    for (size_t i = 0; i < off_.size(); ++i) {
      const Ring& ring = equations_.rings[i];
      off_[i] = Dual(ring.weight * (shape(ring.r_mm) - ring.value));
    }
  }

  const LayeredEquations& equations_;
  const LayeredParameters& at_;
  std::vector<Dual> off_;
  bool has_slopes_ = false;
};

class RingCost final : public ceres::SizedCostFunction<1, 1, 1, 1> {
 public:
  RingCost(const LayeredRings& rings, size_t ring) : rings_(rings), ring_(ring) {}

  bool Evaluate(const double* const*, double* residual, double** slopes) const override {
    const LayeredRings::Dual& off = rings_.off(ring_);
    *residual = off.a;
    for (int i = 0; slopes && i < 3; ++i) {
      if (slopes[i]) *slopes[i] = off.v[i];
    }
    return true;
  }

 private:
  const LayeredRings& rings_;
  size_t ring_;
};

// Robust, as no sum of two layers follows a skin everywhere: many rings should be right, not all
// equally wrong.
class LayeredProblem {
 public:
  LayeredProblem(const LayeredEquations& equations, LayeredParameters* at)
      : rings_(equations, *at), problem_(sharing(&rings_)) {
    for (size_t i = 0; i < equations.rings.size(); ++i) {
      problem_.AddResidualBlock(new RingCost(rings_, i), new ceres::SoftLOneLoss(1.0), &at->deep_s,
                                &at->shallow_s, &at->log_shallow_ld);
    }
    add_known(equations, at);
    const double least_s = model::s_from_alpha(kHighestAlpha);
    bound(&at->deep_s, least_s, model::s_from_alpha(kLowestAlpha));
    bound(&at->shallow_s, least_s, model::s_from_alpha(kLowestAlpha));
    bound(&at->log_shallow_ld, std::log(kShortestShallowLd_mm), std::log(kLongestShallowLd_mm));
  }

  ceres::Problem* get() { return &problem_; }

 private:
  static ceres::Problem::Options sharing(LayeredRings* rings) {
    ceres::Problem::Options options;
    options.evaluation_callback = rings;
    return options;
  }

  // What is known but for the kernel.
  void add_known(const LayeredEquations& equations, LayeredParameters* at) {
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<SlabAlbedo, 1, 1, 1>(new SlabAlbedo(equations.slab)),
        nullptr, &at->shallow_s, &at->log_shallow_ld);
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<SlabTransport, 1, 1, 1>(
                                  new SlabTransport(equations.slab_transport)),
                              nullptr, &at->shallow_s, &at->log_shallow_ld);
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<DeepTransport, 1, 1>(
                                  new DeepTransport(equations.deep_transport)),
                              nullptr, &at->deep_s);
    const LogPrior ld{std::log(kUsualSlabLd_mm), kSlabLdSpread};
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<LogPrior, 1, 1>(new LogPrior(ld)),
                              nullptr, &at->log_shallow_ld);
  }

  void bound(double* value, double low, double high) {
    problem_.SetParameterLowerBound(value, 0, low);
    problem_.SetParameterUpperBound(value, 0, high);
  }

  LayeredRings rings_;
  ceres::Problem problem_;
};

double descend(const LayeredEquations& equations, double tolerance, LayeredParameters* at) {
  LayeredProblem problem(equations, at);
  ceres::Solver::Summary summary;
  ceres::Solve(quiet_options(tolerance), problem.get(), &summary);
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
    const double cost = descend(equations, kSlabTolerance, &at);
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
  LayeredProblem problem(equations, &at);
  LayeredProfile profile = figures_of(at);
  profile.deep_at_bound = at_bound("alpha_dot", profile.alpha_dot, kLowestAlpha, kHighestAlpha, "");
  profile.shallow_at_bound =
      at_bound("alpha", profile.shallow_alpha, kLowestAlpha, kHighestAlpha, "");
  if (profile.shallow_at_bound.empty()) {
    profile.shallow_at_bound =
        at_bound("l_d", profile.shallow_ld_mm, kShortestShallowLd_mm, kLongestShallowLd_mm, " mm");
  }
  profile.alpha_dot_stddev = 2 * at.deep_s / 3 * stddev_of(problem.get(), &at.deep_s);
  profile.shallow_alpha_stddev = 2 * at.shallow_s / 3 * stddev_of(problem.get(), &at.shallow_s);
  profile.shallow_ld_mm_stddev =
      profile.shallow_ld_mm * stddev_of(problem.get(), &at.log_shallow_ld);
  const auto shape = equations.shape(at.deep_s, at.shallow_s, at.log_shallow_ld);
  double error = 0;
  for (const Ring& ring : equations.rings) {
    const double off = ring.weight * (shape(ring.r_mm) - ring.value);
    error += off * off / double(equations.rings.size());
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
                                const KnownSkin& known, double thickness_mm) {
  LayeredEquations equations{rings_of(kernel, kNearestOfKernel_mm, kRingCount),
                             deep.ld_mm,
                             known.shallow.share,
                             {std::max(known.shallow.albedo, kSmallestAlbedo), thickness_mm},
                             {std::log(known.prior.transport_mm)},
                             {std::log(deep.transport_mm / deep.ld_mm)}};
  double light = 0;
  for (const Ring& ring : equations.rings) light += ring.r_mm * ring.r_mm * ring.value / kRingCount;
  for (Ring& ring : equations.rings) ring.weight = ring.r_mm * ring.r_mm / (light * kKernelError);
  return equations;
}

}  // namespace

SlabProfiles fit_layered_profiles(const RadialProfile& kernel, const DeepProfile& deep,
                                  const KnownSkin& known) {
  const std::vector<LayeredParameters> starts = usual_starts(deep.transport_mm / deep.ld_mm);
  SlabProfiles profiles;
  for (size_t i = 0; i < kSlabs_mm.size(); ++i) {
    const LayeredEquations equations = ring_equations(kernel, deep, known, kSlabs_mm[i]);
    const std::vector<Arm> arms = find_arms(equations, starts);
    LayeredProfile& profile = profiles[i];
    profile = profile_at(equations, arms.front().at);
    widen_by_arms(arms, &profile);
    profile.thickness_mm = kSlabs_mm[i];
    profile.cost = arms.front().cost;
    profile.deep_rms = deep.rms;
    if (!deep.at_bound.empty()) profile.deep_at_bound = deep.at_bound;
    judge_shallow(known.shallow.share, &profile);
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
                                      const KnownSkin& known, const LayeredProfile& near) {
  LayeredParameters at{model::s_from_alpha(near.alpha_dot), model::s_from_alpha(near.shallow_alpha),
                       std::log(near.shallow_ld_mm)};
  descend(ring_equations(kernel, deep, known, near.thickness_mm), kToleranceOfSpread, &at);
  return figures_of(at);
}

}  // namespace lamella::fit
