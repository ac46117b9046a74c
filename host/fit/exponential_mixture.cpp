#include "fit/exponential_mixture.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "fit/non_negative.h"

namespace lamella::fit {

namespace {

constexpr int kGaussians = GaussianBasis::kSize;
constexpr int kExponentials = ExponentialMixture::kSize;
constexpr double kSumStiffness = 1000;  // against the data
constexpr double kLeastTrace = 1e-6;    // of no data

// Rings at which blurred profiles are compared.
constexpr int kBlurRings = 160;
constexpr double kFirstRing_mm = 0.01, kLastRing_mm = 24;
constexpr double kRingRidge = 1e-9;  // of the trace

// An exponential is a sum of Gaussians of all widths.
constexpr int kWidthCount = 400;
constexpr double kNarrowestWidth_mm = 1e-3, kWidestWidth_mm = 60;

constexpr int kBlurs = 13;           // to choose from,
constexpr double kBlurFactor = 2;    // from so much less than expected to so much more
constexpr double kBlurSpread = 0.3;  // one sigma of its logarithm

double geometric(double first, double last, int i, int count) {
  return first * std::pow(last / first, i / (count - 1.0));
}

double blur_ring_mm(int i) { return geometric(kFirstRing_mm, kLastRing_mm, i, kBlurRings); }

double width_mm(int i) { return geometric(kNarrowestWidth_mm, kWidestWidth_mm, i, kWidthCount); }

double gaussian(double variance_mm2, double r_mm) {
  return std::exp(-r_mm * r_mm / (2 * variance_mm2)) / (2 * M_PI * variance_mm2);
}

// From a profile at the rings to weights of the Gaussian basis: least squares, weighted as a kernel
// of 1 mm has light.
cv::Mat1d ring_projection() {
  cv::Mat1d basis(kBlurRings, kGaussians), weight(kBlurRings, kBlurRings, 0.0), projection;
  for (int i = 0; i < kBlurRings; ++i) {
    const double r = blur_ring_mm(i), light = r * std::exp(-r) / (2 * M_PI);
    weight(i, i) = r / std::sqrt(light + 1e-4);
    for (int j = 0; j < kGaussians; ++j) {
      const double sigma = GaussianBasis::sigma_mm(j);
      basis(i, j) = weight(i, i) * gaussian(sigma * sigma, r);
    }
  }
  cv::Mat1d normal = basis.t() * basis;
  normal += kRingRidge * cv::trace(normal)[0] / kGaussians * cv::Mat1d::eye(kGaussians, kGaussians);
  cv::solve(normal, basis.t() * weight, projection, cv::DECOMP_CHOLESKY);
  return projection;
}

// Share that Gaussians of width s have in exp(-r/l)/(2 pi l^2), per step of log s: the inverse
// Laplace transform of exp(-sqrt(t)/l) in t = r^2.
cv::Mat1d width_shares() {
  cv::Mat1d share(kWidthCount, kExponentials);
  for (int k = 0; k < kExponentials; ++k) {
    const double l = ExponentialMixture::length_mm(k);
    double sum = 0;
    for (int i = 0; i < kWidthCount; ++i) {
      const double x = width_mm(i) / l;
      share(i, k) = x * x * x * std::exp(-x * x / 2);
      sum += share(i, k);
    }
    for (int i = 0; i < kWidthCount; ++i) share(i, k) /= sum;
  }
  return share;
}

// Squared second differences of neighbouring weights.
cv::Mat1d roughness() {
  cv::Mat1d bend(kExponentials - 2, kExponentials, 0.0);
  for (int i = 0; i < bend.rows; ++i) {
    bend(i, i) = bend(i, i + 2) = 1;
    bend(i, i + 1) = -2;
  }
  return bend.t() * bend;
}

struct Reduced {
  cv::Mat1d a, b;  // in the weights of the Gaussian basis
};

Reduced reduced_of(const KernelEquations& equations, double offset_sigma) {
  const WeightEquations weights(equations, offset_sigma);
  const double scale = kCountedSamples / std::max(equations.count, 1.0);
  Reduced reduced{cv::Mat1d(kGaussians, kGaussians), cv::Mat1d(kGaussians, 1)};
  for (int i = 0; i < kGaussians; ++i) {
    reduced.b(i) = scale * weights.b(i);
    for (int j = 0; j < kGaussians; ++j) reduced.a(i, j) = scale * weights.a(i, j);
  }
  return reduced;
}

// Where a parabola through three values at steps of 1 is least, from the middle one; within 1.
double lowest_between(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend > 0 ? std::clamp(0.5 * (before - after) / bend, -1.0, 1.0) : 0;
}

}  // namespace

double ExponentialMixture::length_mm(int k) {
  return geometric(kShortest_mm, kLongest_mm, k, kSize);
}

double ExponentialMixture::operator()(double r_mm) const {
  double sum = 0;
  for (int k = 0; k < kSize; ++k) {
    const double l = length_mm(k);
    sum += weight[size_t(k)] * std::exp(-r_mm / l) / (2 * M_PI * l * l);
  }
  return sum;
}

cv::Mat1d blurred_exponentials(double blur_mm) {
  static const cv::Mat1d projection = ring_projection(), shares = width_shares();
  cv::Mat1d seen(kBlurRings, kWidthCount);
  for (int i = 0; i < kBlurRings; ++i) {
    for (int w = 0; w < kWidthCount; ++w) {
      seen(i, w) = gaussian(width_mm(w) * width_mm(w) + blur_mm * blur_mm, blur_ring_mm(i));
    }
  }
  return projection * (seen * shares);
}

MixtureProgram mixture_program(const KernelEquations& equations, double offset_sigma,
                               const cv::Mat1d& blurred, double smoothness) {
  const Reduced reduced = reduced_of(equations, offset_sigma);
  const double sum_weight =
      kSumStiffness * std::max(cv::trace(reduced.a)[0] / kGaussians, kLeastTrace);
  MixtureProgram program{blurred.t() * reduced.a * blurred + smoothness * roughness(),
                         blurred.t() * reduced.b};
  program.a += sum_weight;
  program.b += sum_weight;
  return program;
}

ExponentialMixture solve_program(const MixtureProgram& program) {
  const cv::Mat1d x = solve_non_negative(program.a, program.b, kExponentials);
  const double sum = cv::sum(x)[0];
  ExponentialMixture mixture;
  for (int k = 0; k < kExponentials; ++k) mixture.weight[size_t(k)] = x(k) / sum;
  return mixture;
}

ExponentialMixture solve_mixture(const KernelEquations& equations, double offset_sigma,
                                 const cv::Mat1d& blurred, double smoothness) {
  ExponentialMixture mixture =
      solve_program(mixture_program(equations, offset_sigma, blurred, smoothness));
  const Reduced reduced = reduced_of(equations, offset_sigma);
  const cv::Mat1d seen = blurred * cv::Mat1d(kExponentials, 1, mixture.weight.data());
  mixture.cost = seen.dot(reduced.a * seen) - 2 * seen.dot(reduced.b);
  return mixture;
}

double shared_blur_mm(const std::vector<KernelEquations>& kernels, double offset_sigma,
                      double expected_mm) {
  const auto blur_mm = [&](double i) {
    return expected_mm * std::pow(kBlurFactor, 2 * i / (kBlurs - 1.0) - 1);
  };
  std::array<double, kBlurs> cost{};
  parallel_for(kBlurs, [&](int i) {
    const cv::Mat1d blurred = blurred_exponentials(blur_mm(i));
    cost[size_t(i)] = std::pow(std::log(blur_mm(i) / expected_mm) / kBlurSpread, 2);
    for (const KernelEquations& kernel : kernels) {
      cost[size_t(i)] += solve_mixture(kernel, offset_sigma, blurred, kTailSmoothness).cost;
    }
  });
  const auto least = std::min_element(cost.begin() + 1, cost.end() - 1);
  return blur_mm(double(least - cost.begin()) + lowest_between(least[-1], *least, least[1]));
}

}  // namespace lamella::fit
