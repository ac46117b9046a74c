// A flat, textured subject that moves in the picture while it is photographed under every light.
#include "fit/motion.h"

#include <gtest/gtest.h>

#include "fit/motion_report.h"
#include "skin_texture.h"
#include "synthetic_rig.h"

namespace lamella::fit {
namespace {

using testing::kHeight;
using testing::kWidth;

constexpr double kStepS = 0.25;
constexpr double kPixelMm = 1000. / 800;  // of the left camera of make_session

using Path = std::function<cv::Vec2d(double)>;  // px in the picture, of s from the burst's middle

// Light on a pixel, per channel; patterns stay where they are in the picture.
Vec3 light(const Frame& frame, int x, int y) {
  const double u = 640 + (x - 80) * 4.;
  const auto even = [](double v) { return Vec3::all(float(v)); };
  switch (frame.role) {
    case Role::kGradientZ:
      return even(0.7 + 0.001 * y);
    case Role::kBlack:
      return even(0.01);
    case Role::kStripes: {
      const double in_period = std::fmod(u - 2 * frame.index + 80, 8);
      return even(in_period < 4 ? 1 : 0.01);
    }
    case Role::kFringe: {
      Vec3 rgb;
      for (int c = 0; c < 3; ++c) {
        const double turns = std::pow(4, frame.index) * u / 1280 + (c - 1) / 3.;
        rgb[c] = float(0.01 + 0.99 * (0.5 + 0.5 * std::cos(2 * CV_PI * turns)));
      }
      return rgb;
    }
    default:
      return even(frame.analyser == Analyser::kParallel ? 1.3 : 1);
  }
}

struct MovingBurst {
  Session session = testing::make_session();
  Photographs photographs;

  explicit MovingBurst(const Path& path) {
    session.left.id = "left";
    for (Role role : {Role::kGradientFull, Role::kGradientZ, Role::kFront}) {
      for (Analyser a : {Analyser::kParallel, Analyser::kCross}) add(role, 0, a);
    }
    for (int k = 0; k < 4; ++k) add(Role::kFringe, k, Analyser::kCross);
    add(Role::kBlack, 0, Analyser::kCross);
    for (int k = 0; k < 4; ++k) add(Role::kStripes, k, Analyser::kCross);
    const double middle_s = kStepS * double(session.frames.size() - 1) / 2;
    for (const Frame& frame : session.frames) {
      photographs[&frame] = photograph(frame, path(frame.trigger_us * 1e-6 - middle_s));
    }
  }

  const Frame* frame(Role role, int index = 0) const {
    return session.find("left", role, index, Analyser::kCross);
  }

 private:
  void add(Role role, int index, Analyser analyser) {
    Frame frame;
    frame.role = role;
    frame.index = index;
    frame.analyser = analyser;
    frame.camera = "left";
    frame.trigger_us = kStepS * 1e6 * double(session.frames.size());
    session.frames.push_back(frame);
  }

  static Photograph photograph(const Frame& frame, const cv::Vec2d& moved_px) {
    const cv::Size size(kWidth, kHeight);
    const Image1 skin = testing::SkinPattern().photograph(size, moved_px);
    Photograph taken{Image3(size), Mask(size, 0)};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) taken.radiance(y, x) = light(frame, x, y) * skin(y, x);
    }
    return taken;
  }
};

cv::Vec2d still(double) { return {0, 0}; }
cv::Vec2d drifting(double t_s) { return {0.16 * t_s, -0.12 * t_s}; }
constexpr double kDriftPx = 0.2 * 14 * kStepS;

const MovingBurst& drifting_burst() {
  static const MovingBurst burst(drifting);
  return burst;
}

const MovingBurst& still_burst() {
  static const MovingBurst burst(still);
  return burst;
}

Motion motion_of(const MovingBurst& burst) {
  return estimate_motion(burst.session, burst.photographs, Labels());
}

// The photographs of a burst, mended.
Photographs mended(const MovingBurst& burst) {
  Photographs photographs = burst.photographs;
  mend_motion(burst.session, motion_of(burst), &photographs);
  return photographs;
}

TEST(Motion, OfADriftIsToldInPixelsAndMillimetresAtEveryPhotograph) {
  const MovingBurst& burst = drifting_burst();
  const Motion motion = motion_of(burst);
  EXPECT_TRUE(motion.is_mended) << motion.why;
  EXPECT_NEAR(motion.moved_px, kDriftPx, 0.03);
  EXPECT_NEAR(motion.moved_mm, kDriftPx * kPixelMm, 0.04);
  EXPECT_GT(motion.moved_mm_stddev, 0.09 * motion.moved_mm) << "the skin's depth is not known";
  ASSERT_EQ(motion.frames.size(), burst.session.frames.size());
  EXPECT_LT(cv::norm(motion.frames.back().image_px - drifting(7 * kStepS)), 0.02);
  EXPECT_TRUE(motion.jerks.empty());
  // Down in the picture is down in the rig; nothing is said along the camera's axis.
  const Vec3d moved_mm = motion.frames.back().moved_mm;
  EXPECT_GT(moved_mm[1], 0.2);
  EXPECT_NEAR((burst.session.left.cam_from_rig * moved_mm)[2], 0, 1e-9);
}

TEST(Motion, OfASubjectAtRestIsWithinItsSigmaAndChangesNoPhotograph) {
  const Motion motion = motion_of(still_burst());
  EXPECT_FALSE(motion.is_mended);
  EXPECT_LT(motion.moved_mm, 3 * motion.moved_mm_stddev);
  EXPECT_LT(motion.moved_mm_stddev, 0.05);
  for (const auto& [frame, photograph] : mended(still_burst())) {
    EXPECT_EQ(photograph.radiance.data, still_burst().photographs.at(frame).radiance.data);
  }
  EXPECT_EQ(motion.mended_mm(0), Vec3d(0, 0, 0));
}

const cv::Rect kInside(8, 8, kWidth - 16, kHeight - 16);

double relative(const Image3& found, const Image3& expected) {
  return cv::norm((found - expected)(kInside)) / cv::norm(expected(kInside));
}

TEST(Motion, MendedShowsEveryPhotographWhereTheSubjectIsOnAverage) {
  const Frame* full = drifting_burst().frame(Role::kGradientFull);
  const Image3 rest = still_burst().photographs.at(still_burst().frame(Role::kFront)).radiance;
  const double before = relative(drifting_burst().photographs.at(full).radiance, rest);
  EXPECT_GT(before, 0.02);
  const Photographs after = mended(drifting_burst());
  EXPECT_LT(relative(after.at(full).radiance, rest), 0.1 * before);
  const Frame* front = drifting_burst().frame(Role::kFront);
  EXPECT_LT(relative(after.at(front).radiance, rest), 0.1 * before);
}

TEST(Motion, MendedLeavesStripesThatClose) {
  const Photographs after = mended(drifting_burst());
  Image3 sum(kHeight, kWidth, Vec3(0, 0, 0));
  for (int k = 0; k < 4; ++k) {
    sum += after.at(drifting_burst().frame(Role::kStripes, k)).radiance;
  }
  const Image3 twice = after.at(drifting_burst().frame(Role::kFront)).radiance * 2.02;
  EXPECT_LT(relative(sum, twice), 3e-3);
}

TEST(Motion, NamesThePhotographThatIsOffTheSmoothPath) {
  const double at_s = (5 - 7) * kStepS;  // FRONT CROSS is the sixth of fifteen
  const MovingBurst burst([&](double t_s) {
    return drifting(t_s) + (std::abs(t_s - at_s) < 0.01 ? cv::Vec2d(0.7, 0) : cv::Vec2d(0, 0));
  });
  const Motion motion = motion_of(burst);
  ASSERT_FALSE(motion.jerks.empty());
  const std::vector<CheckLine> lines = judge_motion(motion);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].grade, Grade::kPoor);
  EXPECT_NE(lines[0].text.find("did not move smoothly"), std::string::npos) << lines[0].text;
}

TEST(Motion, BeyondWhatCanBeMendedIsBelowTheQualityAsked) {
  Motion motion;
  motion.is_mended = true;
  motion.moved_mm = 0.6;
  EXPECT_TRUE(judge_motion(motion).empty());
  motion.moved_mm = 4;
  ASSERT_EQ(judge_motion(motion).size(), 1u);
  EXPECT_NE(judge_motion(motion)[0].text.find("4.00 mm"), std::string::npos);
}

TEST(Motion, IsNotToldWithoutTimes) {
  MovingBurst burst(drifting);
  for (Frame& frame : burst.session.frames) frame.trigger_us = 0;
  const Motion motion = motion_of(burst);
  EXPECT_TRUE(motion.frames.empty());
  EXPECT_NE(motion.why.find("no times"), std::string::npos);
}

TEST(Motion, IsNotToldOfASubjectTooSmallToShowAny) {
  const MovingBurst& burst = drifting_burst();
  Labels labels(kHeight, kWidth, uchar(0));
  labels(50, 50) = 1;
  EXPECT_TRUE(estimate_motion(burst.session, burst.photographs, labels).frames.empty());
}

}  // namespace
}  // namespace lamella::fit
