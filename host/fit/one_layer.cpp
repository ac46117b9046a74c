#include "fit/one_layer.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "fit/jackknife.h"
#include "model/half_space.h"

namespace lamella::fit {

namespace {

using Weights = WeightEquations::Vector;
constexpr int kBasis = GaussianBasis::kSize;

constexpr int kParts = 4;
constexpr size_t kFewestKernels = 3;
constexpr std::array<double, 3> kUsualScattering_per_mm{2.0, 2.7, 3.3};
constexpr double kKernelError = 0.002;  // of DOTS/(FRONT - BLACK): planes, phase function, table
constexpr double kBlurSpread = 0.15;    // one sigma of its logarithm
constexpr double kLooseExcess = 0.5;    // keeps a channel in bounds that tells nothing of it
// Of an excess, what the dots tell of it at least; the rest is kLooseExcess about none.
constexpr double kLeastTold = 0.7;
// One sigma of the logarithm of a reflectance: calibration, texture, model.
constexpr double kReflectanceError = 0.03;
// What an epidermis makes of it at least: skin with hardly any melanin and little blood has 0.13.
constexpr double kLeastExcess = 0.13;
constexpr double kSurely = 3;         // sigmas from there
constexpr double kLikelyChi2 = 6;     // of two figures: 95 % of one layer's
constexpr double kLargestStep = 0.3;  // of a logarithm
constexpr double kDone = 1e-4;
constexpr int kMostSteps = 12;

// Frequencies at which a kernel is taken for a sum of Gaussians.
constexpr int kWaves = 64;
constexpr double kLongestWave = 0.02, kShortestWave = 3;  // cycles per mm
constexpr double kKnee = 0.06;                            // beyond it dots hold ever less light
constexpr double kProjectRidge = 1e-8;                    // of the trace

double wave(int i) {
  return kLongestWave * std::pow(kShortestWave / kLongestWave, i / (kWaves - 1.0));
}

using Projection = Eigen::Matrix<double, kBasis, kWaves>;

// From shares of waves to the Gaussians' weights.
const Projection& projection() {
  static const Projection matrix = [] {
    Eigen::Matrix<double, kWaves, kBasis> basis;
    Eigen::Matrix<double, kWaves, 1> light;
    for (int i = 0; i < kWaves; ++i) {
      light(i) = 1 / (1 + wave(i) / kKnee);
      for (int j = 0; j < kBasis; ++j) basis(i, j) = light(i) * GaussianBasis::transfer(j, wave(i));
    }
    WeightEquations::Matrix normal = basis.transpose() * basis;
    normal.diagonal().array() += kProjectRidge * normal.trace() / kBasis;
    Projection weighted = basis.transpose();
    for (int i = 0; i < kWaves; ++i) weighted.col(i) *= light(i);
    return Projection(normal.ldlt().solve(weighted));
  }();
  return matrix;
}

// Logarithms: of the blur over what is expected, then per channel of what one layer would reflect
// over what is measured.
using Shared = Eigen::Vector4d;
using SharedMatrix = Eigen::Matrix4d;

struct SeenKernel {
  WeightEquations equations;
  size_t channel;
  double reflectance;
};

struct State {
  std::vector<double> log_scattering;  // of each kernel
  Shared shared = Shared::Zero();
};

Weights weights_at(const SeenKernel& kernel, double log_scattering, const Shared& shared,
                   double footprint_mm) {
  const double reflectance = kernel.reflectance * std::exp(shared(1 + int(kernel.channel)));
  return half_space_weights(model::log_absorption_of(reflectance), std::exp(log_scattering),
                            footprint_mm * std::exp(shared(0)));
}

// One kernel's part of the normal equations, its own scattering eliminated: that is `own` plus
// `by_shared` times the step of what is shared.
struct Part {
  SharedMatrix left = SharedMatrix::Zero();
  Shared right = Shared::Zero(), by_shared = Shared::Zero();
  double own = 0;
};

Part part_of(const SeenKernel& kernel, double log_scattering, const Shared& shared,
             double footprint_mm) {
  constexpr double kDelta = 1e-3;
  const Weights at = weights_at(kernel, log_scattering, shared, footprint_mm);
  const auto slope = [&](double more_scattering, int of_shared) {
    Shared moved = shared;
    if (of_shared >= 0) moved(of_shared) += kDelta;
    return Weights(
        (weights_at(kernel, log_scattering + more_scattering, moved, footprint_mm) - at) / kDelta);
  };
  const Weights rest = kernel.equations.a * at - kernel.equations.b;
  const Weights own = slope(kDelta, -1);
  Eigen::Matrix<double, kBasis, 4> slopes = Eigen::Matrix<double, kBasis, 4>::Zero();
  const int column = 1 + int(kernel.channel);
  slopes.col(0) = slope(0, 0);
  slopes.col(column) = slope(0, column);
  const Weights bent = kernel.equations.a * own;
  const double stiffness = std::max(own.dot(bent), 1e-12);
  const Shared coupling = slopes.transpose() * bent;
  Part part;
  part.left = slopes.transpose() * (kernel.equations.a * slopes) -
              coupling * coupling.transpose() / stiffness;
  part.right = slopes.transpose() * rest - coupling * (own.dot(rest) / stiffness);
  part.own = -own.dot(rest) / stiffness;
  part.by_shared = -coupling / stiffness;
  return part;
}

double bounded(double step) { return std::clamp(step, -kLargestStep, kLargestStep); }

// One step of Gauss and Newton. `scale`: of the kernels' equations, to units of kKernelError.
// Returns the largest step of what is shared; its covariance to `covariance`.
double step(const std::vector<SeenKernel>& kernels, double scale, double footprint_mm, State* state,
            SharedMatrix* covariance) {
  std::vector<Part> parts(kernels.size());
  parallel_for(int(kernels.size()), [&](int i) {
    const auto k = size_t(i);
    parts[k] = part_of(kernels[k], state->log_scattering[k], state->shared, footprint_mm);
  });
  const Shared stiffness(1 / (kBlurSpread * kBlurSpread), 1 / (kLooseExcess * kLooseExcess),
                         1 / (kLooseExcess * kLooseExcess), 1 / (kLooseExcess * kLooseExcess));
  SharedMatrix left = stiffness.asDiagonal();
  Shared right = stiffness.cwiseProduct(state->shared);
  for (const Part& part : parts) {
    left += scale * part.left;
    right += scale * part.right;
  }
  *covariance = left.ldlt().solve(SharedMatrix::Identity());
  Shared move = -(*covariance * right);
  for (double& m : move) m = bounded(m);
  state->shared += move;
  for (size_t k = 0; k < kernels.size(); ++k) {
    state->log_scattering[k] += bounded(parts[k].own + parts[k].by_shared.dot(move));
  }
  return move.cwiseAbs().maxCoeff();
}

SharedMatrix descend(const std::vector<SeenKernel>& kernels, double footprint_mm, State* state) {
  double weight = 0;
  for (const SeenKernel& kernel : kernels) weight += kernel.equations.weight();
  const double scale = double(kernels.size()) / (weight * kKernelError * kKernelError);
  SharedMatrix covariance;
  for (int i = 0; i < kMostSteps; ++i) {
    if (step(kernels, scale, footprint_mm, state, &covariance) < kDone) break;
  }
  return covariance;
}

// All dots but every kParts-th from `left_out` on; -1: all.
std::vector<SeenKernel> kernels_of(const std::vector<OneLayerRegion>& regions, int left_out) {
  std::vector<SeenKernel> kernels;
  for (const OneLayerRegion& region : regions) {
    for (size_t c = 0; c < 3; ++c) {
      if (region.dots[c].size() < size_t(kParts) || !(region.reflectance[c] > 0)) continue;
      KernelEquations sum;
      for (size_t i = 0; i < region.dots[c].size(); ++i) {
        if (int(i % size_t(kParts)) != left_out) sum += *region.dots[c][i];
      }
      if (!(sum.count > 0)) continue;
      kernels.push_back({WeightEquations(sum, kOffsetSigma), c, region.reflectance[c]});
    }
  }
  return kernels;
}

// The channels' excess counts as far as the dots tell it.
Eigen::Vector3d channel_weights(const SharedMatrix& covariance) {
  const Eigen::Vector3d variance =
      covariance.diagonal().tail<3>().array() + kReflectanceError * kReflectanceError;
  return variance.cwiseInverse() / variance.cwiseInverse().sum();
}

std::string describe(const OneLayerVerdict& verdict, bool is_likely) {
  const double percent = 100 * std::expm1(verdict.excess);
  const std::string told = fmt::format(
      "one homogeneous layer with these kernels would reflect {:.0f} +- {:.0f} % {} than is "
      "measured",
      std::abs(percent), 100 * std::exp(verdict.excess) * verdict.excess_stddev,
      percent < 0 ? "less" : "more");
  if (!is_likely) return "more than one, as " + told;
  const std::string of_two = fmt::format(", and for skin of two it would be at least {:.0f} % more",
                                         100 * std::expm1(kLeastExcess));
  if (!verdict.is_one) return "one or two, which is not told apart: " + told + of_two;
  return "one is enough: " + told + of_two +
         fmt::format(", {:.1f} sigma away",
                     (kLeastExcess - verdict.excess) / verdict.excess_stddev);
}

}  // namespace

WeightEquations::Vector half_space_weights(double log_absorption, double scattering_per_mm,
                                           double blur_mm) {
  static const auto waves = [] {
    std::array<double, kWaves> all;
    for (int i = 0; i < kWaves; ++i) all[size_t(i)] = wave(i);
    return all;
  }();
  const model::HalfSpaceTransfer transfer(log_absorption);
  Eigen::Matrix<double, kWaves, 1> left;
  for (int i = 0; i < kWaves; ++i) {
    const double x = M_PI * blur_mm * waves[size_t(i)];
    left(i) = transfer(std::log(waves[size_t(i)] / scattering_per_mm)) * std::exp(-2 * x * x);
  }
  const Weights weights = projection() * left;
  return weights / weights.sum();
}

OneLayerVerdict judge_one_layer(const std::vector<OneLayerRegion>& regions, double footprint_mm) {
  OneLayerVerdict verdict;
  const std::vector<SeenKernel> all = kernels_of(regions, -1);
  if (all.size() < kFewestKernels) return verdict;
  State state;
  for (const SeenKernel& kernel : all) {
    state.log_scattering.push_back(std::log(kUsualScattering_per_mm[kernel.channel]));
  }
  const SharedMatrix covariance = descend(all, footprint_mm, &state);
  const Eigen::Vector3d weights = channel_weights(covariance);
  const double told =
      1 - weights.dot(covariance.diagonal().tail<3>()) / (kLooseExcess * kLooseExcess);
  if (!(told >= kLeastTold)) {
    verdict.why = "not known, as the dots hardly tell what one homogeneous layer would reflect";
    return verdict;
  }
  std::vector<double> excess;
  for (int part = 0; part < kParts; ++part) {
    State rest = state;
    descend(kernels_of(regions, part), footprint_mm, &rest);
    excess.push_back(weights.dot(rest.shared.tail<3>()) / told);
  }
  verdict.is_told = true;
  verdict.excess = weights.dot(state.shared.tail<3>()) / told;
  verdict.excess_stddev = std::hypot(jackknife_stddev(excess), kReflectanceError);
  verdict.log_blur = state.shared(0);
  const double chi2 = std::pow(verdict.excess / verdict.excess_stddev, 2) +
                      std::pow(verdict.log_blur / kBlurSpread, 2);
  const bool is_likely = chi2 < kLikelyChi2;
  verdict.is_one = is_likely && verdict.excess + kSurely * verdict.excess_stddev < kLeastExcess;
  verdict.why = describe(verdict, is_likely);
  return verdict;
}

}  // namespace lamella::fit
