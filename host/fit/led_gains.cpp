#include "fit/led_gains.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace lamella::fit {

namespace {

constexpr size_t kFewestWitnesses = 300;
constexpr int kRobustRounds = 6;
constexpr double kWitnessOutlier = 2;  // sigmas at which a witness' weight has fallen to half
constexpr double kLikelySpread = 0.03;
// What shape, shadows and scattering feign where the LEDs are as calibrated, by heads of others.
constexpr double kGradientModelError = 0.003, kOrderModelError = 0.025;
constexpr double kSigmasToMend = 3;

using Orders = cv::Vec<double, LedGains::kOrders>;

Orders orders_of(const Vec3& w) {
  const double x = double(w[0]), y = double(w[1]), z = double(w[2]);
  return {x, y, z, x * y, y * z, z * x, x * x - y * y, 3 * z * z - 1};
}

// One number that a witness gives and what each unknown would make it.
template <int kUnknowns>
struct Equation {
  cv::Vec<double, kUnknowns> slope;
  double value = 0;
  int group = 0;
};

template <int kUnknowns>
struct Solution {
  cv::Vec<double, kUnknowns> value, stddev;
};

template <int kUnknowns>
struct NormalEquations {
  cv::Matx<double, kUnknowns, kUnknowns> square;
  cv::Vec<double, kUnknowns> right;

  cv::Vec<double, kUnknowns> solved() const { return square.inv(cv::DECOMP_CHOLESKY) * right; }
};

template <int kUnknowns>
double median_residual(const std::vector<Equation<kUnknowns>>& equations,
                       const cv::Vec<double, kUnknowns>& x) {
  std::vector<double> off;
  for (const auto& e : equations) off.push_back(std::abs(e.value - e.slope.dot(x)));
  const auto middle = off.begin() + std::ptrdiff_t(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return std::max(*middle, 1e-9);
}

template <int kUnknowns>
std::array<NormalEquations<kUnknowns>, kWitnessGroups> gather_groups(
    const std::vector<Equation<kUnknowns>>& equations, const cv::Vec<double, kUnknowns>& x,
    const cv::Vec<double, kUnknowns>& prior_sigma) {
  const double sigma = 1.4826 * median_residual(equations, x);
  std::array<NormalEquations<kUnknowns>, kWitnessGroups> groups;
  for (const auto& e : equations) {
    const double off = (e.value - e.slope.dot(x)) / (kWitnessOutlier * sigma);
    const double weight = 1 / (sigma * sigma * (1 + off * off));
    groups[size_t(e.group)].square += e.slope * e.slope.t() * weight;
    groups[size_t(e.group)].right += e.slope * (e.value * weight);
  }
  for (auto& group : groups) {
    for (int i = 0; i < kUnknowns; ++i) {
      group.square(i, i) += 1 / (prior_sigma[i] * prior_sigma[i] * kWitnessGroups);
    }
  }
  return groups;
}

template <int kUnknowns>
NormalEquations<kUnknowns> sum_of(
    const std::array<NormalEquations<kUnknowns>, kWitnessGroups>& groups) {
  NormalEquations<kUnknowns> sum;
  for (const auto& group : groups) {
    sum.square += group.square;
    sum.right += group.right;
  }
  return sum;
}

// Robust least squares; deviations by leaving out one group after the other.
template <int kUnknowns>
Solution<kUnknowns> solve(const std::vector<Equation<kUnknowns>>& equations,
                          const cv::Vec<double, kUnknowns>& prior_sigma) {
  Solution<kUnknowns> s;
  for (int round = 0; round + 1 < kRobustRounds; ++round) {
    s.value = sum_of(gather_groups(equations, s.value, prior_sigma)).solved();
  }
  const auto groups = gather_groups(equations, s.value, prior_sigma);
  const NormalEquations<kUnknowns> all = sum_of(groups);
  s.value = all.solved();
  std::array<double, kUnknowns> variance{};
  for (const NormalEquations<kUnknowns>& group : groups) {
    const NormalEquations<kUnknowns> rest{all.square - group.square, all.right - group.right};
    const cv::Vec<double, kUnknowns> without = rest.solved();
    for (int i = 0; i < kUnknowns; ++i) {
      const double off = without[i] - s.value[i];
      variance[size_t(i)] += off * off * (double(kWitnessGroups - 1) / kWitnessGroups);
    }
  }
  for (int i = 0; i < kUnknowns; ++i) s.stddev[i] = std::sqrt(variance[size_t(i)]);
  return s;
}

// An LED from the rig's origin.
struct FarLed {
  Vec3 towards;  // unit
  Vec3d axis;
  double irradiance;
  Orders orders;
};

std::vector<FarLed> far_leds(const LightStage& stage) {
  std::vector<FarLed> leds;
  for (size_t i = 0; i < stage.leds().size(); ++i) {
    const Vec3& w = stage.leds()[i].direction;
    leds.push_back({stage.direction_from(i, {0, 0, 0}), Vec3d(w),
                    double(stage.irradiance(i, {0, 0, 0})[1]), orders_of(w)});
  }
  return leds;
}

// m of an open Lambertian surface, and its slope by every low-order error.
struct OpenMean {
  Vec3d m{0, 0, 0};
  std::array<Orders, 3> slope{};
};

OpenMean open_mean(const std::vector<FarLed>& leds, const Vec3& n) {
  double full = 0;
  Orders full_slope;
  OpenMean mean;
  for (const FarLed& led : leds) {
    const double gives = double(std::max(0.f, dot(n, led.towards))) * led.irradiance;
    if (gives == 0) continue;
    full += gives;
    full_slope += led.orders * gives;
    mean.m += led.axis * gives;
    for (int a = 0; a < 3; ++a) mean.slope[size_t(a)] += led.orders * (gives * led.axis[a]);
  }
  if (!(full > 0)) return {};
  mean.m *= 1 / full;
  for (int a = 0; a < 3; ++a) {
    mean.slope[size_t(a)] = (mean.slope[size_t(a)] - full_slope * mean.m[a]) * (1 / full);
  }
  return mean;
}

}  // namespace

LedGains estimate_led_gains(const LightStage& stage, const std::vector<LedWitness>& witnesses) {
  LedGains gains;
  if (witnesses.size() < kFewestWitnesses) {
    gains.why = fmt::format(
        "{} places of skin tell, and {} are needed; nor is GRADIENT_FULL held against "
        "the gradients",
        witnesses.size(), kFewestWitnesses);
    return gains;
  }
  const std::vector<FarLed> leds = far_leds(stage);
  std::vector<Equation<LedGains::kOrders>> by_order(3 * witnesses.size());
  std::vector<Equation<3>> by_gradient(3 * witnesses.size());
  parallel_for(
      int(witnesses.size()),
      [&](int i) {
        const LedWitness& w = witnesses[size_t(i)];
        const OpenMean open = open_mean(leds, w.normal);
        for (int a = 0; a < 3; ++a) {
          by_order[size_t(3 * i + a)] = {open.slope[size_t(a)], double(w.off[a]), w.group};
          // A gradient frame brighter by g: 2 (1 + g) G / C - 1 is more by g (1 + m).
          cv::Vec3d slope(0, 0, 0);
          slope[a] = 1 + open.m[a];
          by_gradient[size_t(3 * i + a)] = {slope, double(w.off[a]), w.group};
        }
      },
      64);
  const auto orders = solve<LedGains::kOrders>(by_order, Orders::all(kLikelySpread));
  const auto gradients = solve<3>(by_gradient, cv::Vec3d::all(kLikelySpread));
  gains.is_known = true;
  for (size_t i = 0; i < 3; ++i) {
    gains.gradient[i] = gradients.value[int(i)];
    gains.gradient_stddev[i] = std::hypot(gradients.stddev[int(i)], kGradientModelError);
    gains.is_mended = gains.is_mended || gains.beyond(i);
  }
  for (size_t i = 0; i < LedGains::kOrders; ++i) {
    gains.low_order[i] = orders.value[int(i)];
    gains.low_order_stddev[i] = std::hypot(orders.stddev[int(i)], kOrderModelError);
  }
  return gains;
}

bool LedGains::beyond(size_t axis) const {
  return std::abs(gradient[axis]) > kSigmasToMend * gradient_stddev[axis];
}

float LedGains::mended_gain(size_t axis) const {
  return beyond(axis) ? float(1 + gradient[axis]) : 1.f;
}

}  // namespace lamella::fit
