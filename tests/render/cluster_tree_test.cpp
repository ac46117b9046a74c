#include "render/cluster_tree.h"

#include <gtest/gtest.h>

#include "model/dipole.h"

namespace lamella::render {
namespace {

const RadialKernel& dipole_kernel() {
  static const RadialKernel kernel(
      [](double r) {
        return model::dipole_reflectance(model::Dipole<double>{0.9, 1}, r);
      },
      8);
  return kernel;
}

ExitKernels dipole_exit(const Vec3& ld_mm) {
  return {{&dipole_kernel(), &dipole_kernel(), &dipole_kernel()},
          {1 / ld_mm[0], 1 / ld_mm[1], 1 / ld_mm[2]}};
}

// A square of samples `step` apart, lit by light(x, y).
template <class Light>
std::vector<SurfaceSample> sheet(int half, float step, const Light& light) {
  std::vector<SurfaceSample> samples;
  for (int i = -half; i <= half; ++i) {
    for (int j = -half; j <= half; ++j) {
      const Vec3 x(j * step, i * step, 0);
      samples.push_back({x, step * step, Vec3::all(light(x[0], x[1]))});
    }
  }
  return samples;
}

TEST(RadialKernel, IntegratesToOneAndKeepsItsShape) {
  double sum = 0;
  for (double r = 0.005; r < 16; r += 0.01)
    sum += dipole_kernel()(float(r), 0.5f) * 2 * M_PI * r * 0.01;
  EXPECT_NEAR(sum, 1, 1e-3);
  const model::Dipole<double> dipole{0.9, 2};
  EXPECT_NEAR(dipole_kernel()(1, 0.5f) / dipole_kernel()(4, 0.5f),
              model::dipole_reflectance(dipole, 1) / model::dipole_reflectance(dipole, 4), 0.02);
}

TEST(RadialKernel, TakesNoLightAway) {
  // As a multipole is outside diffusion: negative near the middle.
  const RadialKernel kernel([](double r) { return r < 1 ? -1. : std::exp(-r); }, 8);
  EXPECT_EQ(kernel(0.5f, 1), 0);
  EXPECT_GT(kernel(1.5f, 1), 0);
}

TEST(RadialKernel, WithoutLightIsNotValid) {
  EXPECT_FALSE(RadialKernel([](double) { return -1; }, 8).valid());
}

TEST(ClusterTree, GathersWhatASumOverAllPointsGathers) {
  const auto samples =
      sheet(60, 0.3f, [](float x, float y) { return 1 + std::sin(x) * std::cos(2 * y); });
  const ExitKernels exit = dipole_exit({0.7f, 1, 2.5f});
  const ClusterTree tree(samples, 0.3f), exact(samples, 0);
  for (const Vec3& x : {Vec3(0, 0, 0), Vec3(3.3f, 1, 0), Vec3(-17, 17, 0)}) {
    const Gathered fast = tree.gather(x, exit), slow = exact.gather(x, exit);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(fast.light[c] / fast.weight[c], slow.light[c] / slow.weight[c], 0.02);
    }
  }
}

TEST(ClusterTree, WeighsAFlatWideSheetAsOne) {
  const ClusterTree tree(sheet(100, 0.3f, [](float, float) { return 1; }), 0.3f);
  const Gathered sum = tree.gather({0, 0, 0}, dipole_exit({1, 2, 3}));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum.weight[c], 1, 0.03);
}

TEST(ClusterTree, IsReciprocalBetweenTwoPoints) {
  const auto spot_at = [](float x, float y) {
    return [=](float px, float py) { return px == x && py == y ? 1.f : 0.f; };
  };
  const ClusterTree from_a(sheet(20, 0.5f, spot_at(0, 0)), 0);
  const ClusterTree from_b(sheet(20, 0.5f, spot_at(2, 1)), 0);
  const ExitKernels exit = dipole_exit({1, 2, 3});
  for (int c = 0; c < 3; ++c) {
    const float there = from_a.gather({2, 1, 0}, exit).light[c];
    EXPECT_NEAR(from_b.gather({0, 0, 0}, exit).light[c], there, 1e-5f * there);
  }
}

TEST(ClusterTree, BlursAnEdgeOfLightAsTheDipoleDoes) {
  const ClusterTree tree(sheet(150, 0.2f, [](float x, float) { return x < 0 ? 1 : 0; }), 0.3f);
  const ExitKernels exit = dipole_exit({1, 1, 2});
  for (float x : {0.9f, 2.1f, 4.1f}) {
    for (int c = 1; c < 3; ++c) {
      const model::Dipole<double> dipole{0.9, 1 / exit.per_mm[c]};
      double lit = 0, all = 0;  // over rings around the point: the share of each that is lit
      for (double r = 0.005; r < 24; r += 0.01) {
        const double ring = model::dipole_reflectance(dipole, r) * r;
        all += ring * M_PI;
        // The edge lies between the last lit and the first dark sample.
        if (r > x + 0.1) lit += ring * std::acos((x + 0.1) / r);
      }
      const Gathered sum = tree.gather({x, 0, 0}, exit);
      EXPECT_NEAR(sum.light[c] / sum.weight[c], lit / all, 0.004) << "x " << x << " channel " << c;
    }
  }
}

}  // namespace
}  // namespace lamella::render
