#include "calib/check_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/photographs.h"

namespace lamella {

namespace {

// Depth error is pixel error over the sine of the angle at which two views meet: under the first
// one the error is some fifty times that of a pixel, under the second nothing is left of it.
constexpr double kLeastAngle_deg = 1;
constexpr double kNoAngle_deg = 0.05;
constexpr size_t kLeastLeds = 4;  // three axes and a constant
// Least share of the light's directions that lies along any axis; a third where they are even.
constexpr double kLeastSpread = 0.05;
constexpr double kNoSpread = 0.005;

Grade grade_of(double figure, double least, double none) {
  if (!(figure > none)) return Grade::kUnusable;
  return figure >= least ? Grade::kGood : Grade::kPoor;
}

CheckLine baseline(const Session& s) {
  const bool stereo = has_right_geometry(s);
  const Vec3d left_mm = s.left.centre_mm();
  const Vec3d other_mm = stereo ? s.right->centre_mm() : s.projector.centre_mm();
  const double sine = cv::norm(left_mm.cross(other_mm)), cosine = left_mm.dot(other_mm);
  const double angle_deg = std::atan2(sine, cosine) * 180 / M_PI;
  const Grade grade = grade_of(angle_deg, kLeastAngle_deg, kNoAngle_deg);
  std::string text =
      fmt::format("left camera and {} {:.1f} mm apart, {:.2f} degrees at the subject",
                  stereo ? "right camera" : "projector", cv::norm(left_mm - other_mm), angle_deg);
  text += fmt::format(", at least {:g} degree", kLeastAngle_deg);
  return {grade, "baseline", text, angle_deg, "degrees", kLeastAngle_deg};
}

// Of the second moments of the LEDs' directions, the least: 0 where they lie in a plane.
double spread_of(const LightStage& stage) {
  Mat33d moments = Mat33d::zeros();
  for (const Led& led : stage.leds()) {
    const Vec3d w(led.direction);
    moments += (w * w.t()) * (1.0 / double(stage.leds().size()));
  }
  cv::Vec3d eigenvalues;
  cv::eigen(moments, eigenvalues);
  return eigenvalues[2];
}

bool lights_the_front(const LightStage& stage) {
  for (int c = 0; c < 3; ++c) {
    const bool any = std::any_of(stage.leds().begin(), stage.leds().end(), [&](const Led& led) {
      return led.intensity[c] > 0 && led.direction[2] > 0;
    });
    if (!any) return false;
  }
  return true;
}

CheckLine leds(const Session& s) {
  const size_t count = s.stage.leds().size();
  CheckLine line{Grade::kUnusable, "LEDs", "", 0, "", kLeastSpread};
  if (count < kLeastLeds) {
    line.text = fmt::format("{} of them, at least {} for normals", count, kLeastLeds);
  } else if (!lights_the_front(s.stage)) {
    line.text = "none shines on the subject's front (+Z) in some colour";
  } else {
    line.figure = spread_of(s.stage);
    line.grade = grade_of(line.figure, kLeastSpread, kNoSpread);
    line.text = fmt::format("{}, {:.3f} of their light along the least lit axis, at least {:g}",
                            count, line.figure, kLeastSpread);
  }
  return line;
}

}  // namespace

std::vector<CheckLine> check_rig(const Session& session) {
  return {baseline(session), leds(session)};
}

}  // namespace lamella
