#include "twin/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "base/error.h"
#include "twin/skin.h"

namespace lamella::twin {

namespace {

constexpr double kDistance = 1000.0;  // mm, cameras and projector from the origin
constexpr double kCameraAngle = 10.0 * CV_PI / 180.0;

// Coordinates in units of 1e-4, by which points are told apart and ordered.
std::array<int, 3> key_of(const Vec3d& p) {
  return {int(std::lround(p[0] * 1e4)), int(std::lround(p[1] * 1e4)), int(std::lround(p[2] * 1e4))};
}

std::vector<Vec3d> icosahedron() {
  std::vector<Vec3d> corners{{0, 1, 0}};
  for (int k = 0; k < 5; ++k) {
    const double a = 72.0 * k * CV_PI / 180.0, r = 2.0 / std::sqrt(5.0);
    corners.push_back({r * std::sin(a), 1.0 / std::sqrt(5.0), r * std::cos(a)});
  }
  for (int k = 0; k < 6; ++k) corners.push_back(-corners[size_t(k)]);
  return corners;
}

std::map<std::array<int, 3>, Vec3d> geodesic_points() {
  const std::vector<Vec3d> corners = icosahedron();
  const double edge = 4.0 / std::sqrt(10.0 + 2.0 * std::sqrt(5.0));
  const auto joined = [&](size_t i, size_t j) {
    return cv::norm(corners[i] - corners[j]) < 1.01 * edge;
  };
  std::map<std::array<int, 3>, Vec3d> points;
  for (size_t a = 0; a < 12; ++a) {
    for (size_t b = a + 1; b < 12; ++b) {
      for (size_t c = b + 1; c < 12; ++c) {
        if (!joined(a, b) || !joined(b, c) || !joined(a, c)) continue;
        for (int i = 0; i <= 4; ++i) {
          for (int j = 0; i + j <= 4; ++j) {
            const Vec3d p = corners[a] * i + corners[b] * j + corners[c] * (4 - i - j);
            const Vec3d on_sphere = p * (1.0 / cv::norm(p));
            points.emplace(key_of(on_sphere), on_sphere);
          }
        }
      }
    }
  }
  return points;
}

Camera make_camera(const std::string& id, double angle, double scale, double noise) {
  Camera c;
  c.id = id;
  c.width = int(std::lround(600 * scale));
  c.height = int(std::lround(750 * scale));
  c.fx = c.fy = 4000.0 * 600.0 / 900.0 * scale;
  c.cx = 0.5 * (c.width - 1);
  c.cy = 0.5 * (c.height - 1);
  const double cosine = std::cos(angle), sine = std::sin(angle);
  c.cam_from_rig = Mat33d(cosine, 0, -sine, 0, -1, 0, -sine, 0, -cosine);
  c.translation_mm = {0, 0, kDistance};
  c.saturation = 1.0;
  c.read_noise = 0.0004 * noise;
  c.full_well_electrons = noise > 0 ? 30000 / (noise * noise) : 0;
  return c;
}

Camera make_projector() {
  Camera p;
  p.width = 1280;
  p.height = 800;
  p.fx = p.fy = kDistance / 0.3;  // 0.3 mm a pixel at the origin
  p.cx = 0.5 * (p.width - 1);
  p.cy = 0.5 * (p.height - 1);
  p.cam_from_rig = Mat33d(1, 0, 0, 0, -1, 0, 0, 0, -1);
  p.translation_mm = {0, 0, kDistance};
  return p;
}

}  // namespace

std::vector<Vec3> led_directions() {
  using Point = std::pair<std::array<int, 3>, Vec3d>;
  const auto all = geodesic_points();
  std::vector<Point> points(all.begin(), all.end());
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return std::tuple(-a.first[2], a.first[0], a.first[1]) <
           std::tuple(-b.first[2], b.first[0], b.first[1]);
  });
  points.erase(points.begin(), points.begin() + 6);  // where cameras and projector look through
  const auto azimuth = [](const Point& p) {
    return std::atan2(double(p.first[0]), double(p.first[2]));
  };
  std::sort(points.begin(), points.end(), [&](const Point& a, const Point& b) {
    return std::tuple(-a.first[1], azimuth(a)) < std::tuple(-b.first[1], azimuth(b));
  });
  points.resize(kLedCount);  // the lowest are the stand
  std::vector<Vec3> directions;
  for (const Point& p : points) directions.push_back(Vec3(p.second));
  return directions;
}

void require_scale(double scale) {
  if (scale >= kLeastScale && scale <= kLargestScale) return;
  throw_bad_input("--scale", fmt::format("{:g}", scale),
                  fmt::format("give a number from {:g} to {:g}", kLeastScale, kLargestScale));
}

Session make_rig(const std::string& subject, double scale, double noise) {
  require_scale(scale);
  Session rig;
  rig.subject = subject;
  std::vector<Led> leds;
  for (const Vec3& w : led_directions()) leds.push_back({.direction = w});
  rig.stage = LightStage(std::move(leds));
  rig.left = make_camera("left", -kCameraAngle, scale, noise);
  rig.right = make_camera("right", kCameraAngle, scale, noise);
  rig.projector = make_projector();
  rig.projector_to_led = Mat33d(1.08, -0.05, 0.01, 0.02, 0.94, 0.03, -0.01, 0.06, 1.16);
  rig.regions_file = "regions.png";
  rig.region_names = {"background"};
  rig.region_names.insert(rig.region_names.end(), kRegionNames.begin(), kRegionNames.end());
  return rig;
}

}  // namespace lamella::twin
