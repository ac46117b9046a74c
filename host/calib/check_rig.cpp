#include "calib/check_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/pattern_scale.h"
#include "calib/photographs.h"

namespace lamella {

namespace {

// Depth error is pixel error over the sine of the angle at which two views meet: under the first
// one the error is some fifty times that of a pixel, under the second nothing is left of it.
constexpr double kLeastAngle_deg = 1;
constexpr double kNoAngle_deg = 0.05;
// No camera that photographs a face is nearer or further, or sees wider or narrower (fx over
// width).
constexpr double kNearest_mm = 50, kFurthest_mm = 20000;
constexpr double kWidest = 0.2, kNarrowest = 100;
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
    line.text = fmt::format("{} of them, at least {} for normals; state all in rig.leds", count,
                            kLeastLeds);
  } else if (!lights_the_front(s.stage)) {
    line.text = "none shines on the subject's front (+Z) in some colour; correct rig.leds";
  } else {
    line.figure = spread_of(s.stage);
    line.grade = grade_of(line.figure, kLeastSpread, kNoSpread);
    line.text = fmt::format("{}, {:.3f} of their light along the least lit axis, at least {:g}",
                            count, line.figure, kLeastSpread);
  }
  return line;
}

// What keeps a camera from seeing the subject, which sits at the origin; empty where nothing does.
std::string blindness(const Camera& c) {
  const double distance_mm = cv::norm(c.centre_mm());
  if (!(distance_mm > kNearest_mm && distance_mm < kFurthest_mm)) {
    return fmt::format("is {:g} mm from the subject, {:g} to {:g}; state translation_mm in mm",
                       distance_mm, kNearest_mm, kFurthest_mm);
  }
  if (!(c.fx > kWidest * c.width && c.fx < kNarrowest * c.width)) {
    return fmt::format("has fx {:g} pixels for {} of width; state fx in pixels", c.fx, c.width);
  }
  const cv::Vec2d origin = c.project({0, 0, 0});
  const bool inside = origin[0] > -c.width && origin[0] < 2 * c.width && origin[1] > -c.height &&
                      origin[1] < 2 * c.height;
  if (!inside) return "looks away from the subject; state rotation so that camera = R rig + t";
  const Vec3d corner_mm = c.centre_mm() + c.ray(0, 0) * distance_mm;
  if (!(cv::norm(c.project(corner_mm)) < 1))
    return "has a distortion that cannot be undone; correct it";
  return "";
}

CheckLine views(const Session& s) {
  std::vector<std::pair<std::string, const Camera*>> all{{"left camera", &s.left},
                                                         {"projector", &s.projector}};
  if (has_right_geometry(s)) all.emplace_back("right camera", &*s.right);
  for (const auto& [name, camera] : all) {
    const std::string why = blindness(*camera);
    if (!why.empty()) return {Grade::kUnusable, "views", "the " + name + " " + why, 0, "", 0};
  }
  return {Grade::kGood, "views", "cameras and projector see the subject's place", 0, "", 0};
}

CheckLine pattern_size(const std::string& name, double pixels, double least,
                       const std::string& lost) {
  const bool is_seen = pixels >= least;
  std::string text =
      fmt::format("{:.2f} pixels of the left camera, at least {:g}{}", pixels, least,
                  is_seen ? "" : ": " + lost + "; photograph from nearer or with more pixels");
  return {is_seen ? Grade::kGood : Grade::kPoor, name, text, pixels, "pixels", least};
}

}  // namespace

std::vector<CheckLine> check_rig(const Session& session, ShapeFrom shape) {
  const PatternScale scale = pattern_scale(session);
  std::vector<CheckLine> lines{views(session)};
  if (shape == ShapeFrom::kFringes) lines.push_back(baseline(session));
  lines.push_back(leds(session));
  lines.push_back(pattern_size("period of the stripes", scale.stripe_px,
                               kLeastPatternScale.stripe_px,
                               "shallow and deep cannot be told apart"));
  lines.push_back(pattern_size("diameter of the dots", scale.dot_px, kLeastPatternScale.dot_px,
                               "l_d cannot be told"));
  return lines;
}

}  // namespace lamella
