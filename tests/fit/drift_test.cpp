#include "fit/drift.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace lamella::fit {
namespace {

constexpr double kSigma = 0.02;

// Shifts of ten photographs against one in their midst, measured with noise.
std::vector<ShiftBetween> shifts_of(const std::function<cv::Vec2d(double)>& path, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, kSigma);
  std::vector<ShiftBetween> shifts;
  for (int i = 0; i < 10; ++i) {
    const double from_s = 0.3, to_s = -2.4 + 0.5 * i;
    shifts.push_back({from_s,
                      to_s,
                      path(to_s) - path(from_s) + cv::Vec2d(normal(random), normal(random)),
                      {kSigma, kSigma}});
  }
  return shifts;
}

cv::Vec2d straight(double t_s) { return {0.2 * t_s, -0.1 * t_s}; }
cv::Vec2d bent(double t_s) { return {0.2 * t_s + 0.1 * t_s * t_s, -0.1 * t_s}; }

TEST(DriftPath, OfNoShiftsKnowsNothing) {
  EXPECT_EQ(DriftPath(std::vector<ShiftBetween>()).degree(), 0);
  EXPECT_EQ(DriftPath().at(1), cv::Vec2d(0, 0));
}

TEST(DriftPath, IsStraightForAllThatNoiseSays) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    EXPECT_EQ(DriftPath(shifts_of(straight, seed)).degree(), 1) << seed;
  }
}

TEST(DriftPath, BendsWhereTheSubjectDid) {
  const DriftPath path(shifts_of(bent, 1));
  EXPECT_EQ(path.degree(), 2);
  for (const double t_s : {-2.4, 0., 2.1}) EXPECT_LT(cv::norm(path.at(t_s) - bent(t_s)), 0.06);
}

TEST(DriftPath, IsZeroAtTimeZero) {
  EXPECT_EQ(DriftPath(shifts_of(bent, 1)).at(0), cv::Vec2d(0, 0));
}

TEST(DriftPath, HoldsTheTruthWithinItsSigmaTwoTimesOutOfThree) {
  int within = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    const DriftPath path(shifts_of(straight, seed));
    const cv::Vec2d off = path.at(2) - path.at(-2) - (straight(2) - straight(-2));
    within += std::abs(off[0]) < path.sigma(-2, 2)[0];
  }
  EXPECT_NEAR(within / 400., 0.68, 0.07);
}

TEST(DriftPath, TellsAPhotographThatIsOffIt) {
  std::vector<ShiftBetween> shifts = shifts_of(straight, 3);
  const ShiftBetween jerked{
      0.3, 1, straight(1) - straight(0.3) + cv::Vec2d(0.5, 0), {kSigma, kSigma}};
  const DriftPath path(shifts);
  EXPECT_LT(path.off_sigmas(shifts[4]), 4);
  EXPECT_NEAR(path.off_sigmas(jerked), 25, 3);
}

}  // namespace
}  // namespace lamella::fit
