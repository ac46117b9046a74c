#include "fit/layered_kernel.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "fit/kernel_waves.h"

namespace lamella::fit {
namespace {

constexpr double kFootprint_mm = 0.2;

LayeredKernel kernel_of_skin() {
  LayeredKernel kernel;
  kernel.deep_s = 0.8;
  kernel.deep_ld_mm = 1.4;
  kernel.shallow_s = 0.5;
  kernel.shallow_ld_mm = 0.6;
  kernel.shallow_share = 0.4;
  kernel.thickness_mm = 0.5;
  return kernel;
}

// What waves of many lengths show of it through a camera and a projector that blur.
WeightEquations waves_through(const LayeredKernel& kernel) {
  KernelEquations equations;
  for (int i = 0; i < 60; ++i) {
    const double f = 0.03 * i, blur = std::exp(-2 * std::pow(M_PI * kFootprint_mm * f, 2));
    KernelEquations::Vector row = KernelEquations::Vector::Zero();
    for (int j = 0; j < GaussianBasis::kSize; ++j) row(j) = GaussianBasis::transfer(j, f);
    row(GaussianBasis::kSize) = 1;
    equations.add(row, testing::wave_share(kernel, f) * blur, 1e4);
  }
  return WeightEquations(equations, 1e-4);
}

// Relative, by area, from 0.1 to 8 mm.
double difference(const LayeredKernel& a, const LayeredKernel& b) {
  double apart = 0, light = 0;
  for (double r = 0.1; r < 8; r *= 1.02) {
    apart += r * r * std::abs(a(r) - b(r));
    light += r * r * b(r);
  }
  return apart / light;
}

// As solvers carry them along, in all four figures.
TEST(LayeredKernel, ItsDerivativesAreItsDifferences) {
  using Dual = ceres::Jet<double, 4>;
  const std::array<double, 4> at{0.8, 1.4, 0.5, 0.6};
  const auto value_at = [](const auto& x, double r_mm) {
    using Real = std::decay_t<decltype(x[0])>;
    return LayeredShape<Real>({x[0], x[1]}, {x[2], x[3]}, 0.4, 0.5)(r_mm);
  };
  for (double r_mm : {0.01, 0.3, 2.0, 9.0}) {
    const Dual exact =
        value_at(std::array{Dual(at[0], 0), Dual(at[1], 1), Dual(at[2], 2), Dual(at[3], 3)}, r_mm);
    EXPECT_NEAR(exact.a / value_at(at, r_mm), 1, 1e-12) << r_mm;
    for (int i = 0; i < 4; ++i) {
      constexpr double kStep = 1e-5;
      std::array<double, 4> less = at, more = at;
      less[size_t(i)] -= kStep;
      more[size_t(i)] += kStep;
      const double difference = (value_at(more, r_mm) - value_at(less, r_mm)) / (2 * kStep);
      EXPECT_NEAR(exact.v[i] / difference, 1, 1e-6) << r_mm << " mm, figure " << i;
    }
  }
}

TEST(LayeredKernel, IntegratesToOne) {
  EXPECT_NEAR(testing::wave_share(kernel_of_skin(), 0), 1, 0.01);
}

TEST(LayeredKernel, IsFoundAgainInWhatItShowsThroughTheBlur) {
  LayeredKernel given = kernel_of_skin();
  given.deep_ld_mm = 1.6;  // as the tail may say
  const LayeredKernel found =
      fit_layered_kernel(waves_through(kernel_of_skin()), given, kFootprint_mm);
  EXPECT_LT(difference(found, kernel_of_skin()), 0.03);
}

TEST(LayeredKernel, ABlurThatIsNotTakenOutIsTakenForSkin) {
  const LayeredKernel found =
      fit_layered_kernel(waves_through(kernel_of_skin()), kernel_of_skin(), 0.05);
  EXPECT_GT(difference(found, kernel_of_skin()), 0.05);
}

TEST(LayeredKernel, TheFootprintGrowsWithThePixelsAsFarAsItCanBeTakenOut) {
  Camera camera;
  camera.fx = camera.fy = 10000;
  camera.translation_mm = {0, 0, 1000};
  Camera coarse = camera, coarser = camera;
  coarse.fx = coarse.fy = 5000;
  coarser.fx = coarser.fy = 1000;
  EXPECT_NEAR(footprint_mm(camera, camera), 0.43 * std::sqrt(2) * 0.1, 1e-9);
  EXPECT_NEAR(footprint_mm(coarse, coarse), 2 * footprint_mm(camera, camera), 1e-9);
  EXPECT_EQ(footprint_mm(coarser, coarser), 0.25);
}

}  // namespace
}  // namespace lamella::fit
