// A small rig and photographs of plain shapes, computed in closed form: what the tests of the fit
// see instead of a face.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>

#include "fit/burst.h"

namespace lamella::fit::testing {

inline constexpr int kWidth = 160, kHeight = 200;

// A camera `distance_mm` from the origin in direction `angle_rad` from +Z towards +X, looking at
// the origin, up +Y.
inline Camera camera_at(double angle_rad, double distance_mm, double fx) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  Camera camera;
  camera.width = kWidth;
  camera.height = kHeight;
  camera.fx = camera.fy = fx;
  camera.cx = (kWidth - 1) / 2.;
  camera.cy = (kHeight - 1) / 2.;
  camera.cam_from_rig = Mat33d(c, 0, -s, 0, -1, 0, -s, 0, -c);
  camera.translation_mm = Vec3d(0, 0, distance_mm);
  return camera;
}

inline std::vector<Led> leds_all_around(int count) {
  std::vector<Led> leds;
  for (int i = 0; i < count; ++i) {
    const float z = 1.f - (2.f * float(i) + 1.f) / float(count), r = std::sqrt(1.f - z * z);
    const float azimuth = 2.39996323f * float(i);
    leds.push_back({Vec3(r * std::cos(azimuth), r * std::sin(azimuth), z), 0, Vec3(1, 1, 1)});
  }
  return leds;
}

inline Session make_session() {
  Session session;
  session.left = camera_at(-0.17, 1000, 800);
  session.right = camera_at(0.17, 1000, 800);
  session.projector = camera_at(0, 1000, 3300);
  session.projector.width = 1280;
  session.projector.height = 800;
  session.projector.cx = 639.5;
  session.projector.cy = 399.5;
  session.stage = LightStage(leds_all_around(150));
  session.region_names = {"background", "skin"};
  return session;
}

// Turns the whole rig: what it sees turns with it, and no photograph changes.
inline void rotate_rig(const Mat33d& rotation, Session* session) {
  for (Camera* camera : {&session->left, &*session->right, &session->projector}) {
    camera->cam_from_rig = camera->cam_from_rig * rotation.t();
  }
  std::vector<Led> leds = session->stage.leds();
  for (Led& led : leds) led.direction = cv::Matx33f(rotation) * led.direction;
  session->stage = LightStage(leds);
}

struct SurfacePoint {
  Vec3d position_mm;
  Vec3 normal;
};
// The first point of a shape on a ray, if there is one.
using Shape = std::function<std::optional<SurfacePoint>(const Vec3d& origin, const Vec3d& ray)>;

inline Shape sphere(double radius_mm) {
  return [=](const Vec3d& o, const Vec3d& d) -> std::optional<SurfacePoint> {
    const double b = o.dot(d), discriminant = b * b - o.dot(o) + radius_mm * radius_mm;
    if (discriminant < 0) return std::nullopt;
    const Vec3d p = o + d * (-b - std::sqrt(discriminant));
    return SurfacePoint{p, unit(Vec3(p))};
  };
}

// z = `near_mm` where |y| is below 30 mm, z = `far_mm` elsewhere; both face +Z.
inline Shape stepped_plane(double near_mm, double far_mm) {
  return [=](const Vec3d& o, const Vec3d& d) -> std::optional<SurfacePoint> {
    const Vec3d front = o + d * ((near_mm - o[2]) / d[2]);
    if (std::abs(front[1]) < 30 && std::abs(front[0]) < 60) return SurfacePoint{front, {0, 0, 1}};
    const Vec3d back = o + d * ((far_mm - o[2]) / d[2]);
    if (std::abs(back[0]) < 60) return SurfacePoint{back, {0, 0, 1}};
    return std::nullopt;
  };
}

struct Contrasts {
  std::array<Vec3, 4> of_level{Vec3(.5f, .5f, .5f), Vec3(.5f, .5f, .5f), Vec3(.47f, .49f, .5f),
                               Vec3(.31f, .41f, .44f)};
};

inline Vec3 fringe_value(const Session& session, size_t level, double u_px) {
  const double turns = session.patterns.fringe_periods[level] * u_px / session.projector.width;
  Vec3 v;
  for (int c = 0; c < 3; ++c) {
    v[c] =
        0.5f + Contrasts().of_level[level][c] * float(std::cos(2 * CV_PI * (turns + (c - 1) / 3.)));
  }
  return v;
}

inline void photograph_fringes(const Session& session, const Camera& camera, const Shape& shape,
                               std::vector<Image3>* fringe, Image3* front_lit) {
  fringe->assign(4, Image3(kHeight, kWidth, Vec3(0, 0, 0)));
  for (Image3& image : *fringe) image = image.clone();
  *front_lit = Image3(kHeight, kWidth, Vec3(0, 0, 0));
  const Vec3d projector = session.projector.centre_mm();
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto p = shape(camera.centre_mm(), camera.ray(x, y));
      if (!p) continue;
      const Vec3d away = p->position_mm - projector;
      const auto first = shape(projector, away * (1 / cv::norm(away)));
      if (first && cv::norm(first->position_mm - p->position_mm) > 1) continue;
      const float cosine = std::max(0.f, dot(p->normal, unit(Vec3(-away))));
      const Vec3 white = Vec3(.4f, .3f, .2f) * cosine;
      (*front_lit)(y, x) = white;
      const double u = session.projector.project(p->position_mm)[0];
      for (size_t k = 0; k < 4; ++k) (*fringe)[k](y, x) = white.mul(fringe_value(session, k, u));
    }
  }
}

// Lambertian light of the LEDs, nothing in its way, all of it depolarized.
inline void photograph_gradients(const Session& session, const Shape& shape, Burst* burst) {
  const Image3 dark(kHeight, kWidth, Vec3(0, 0, 0));
  burst->full = {dark.clone(), dark.clone()};
  for (AnalyserPair& pair : burst->gradient) pair = {dark.clone(), dark.clone()};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto p = shape(session.left.centre_mm(), session.left.ray(x, y));
      if (!p) continue;
      const Vec3 at(p->position_mm);
      for (size_t i = 0; i < session.stage.leds().size(); ++i) {
        const float cosine = std::max(0.f, dot(p->normal, session.stage.direction_from(i, at)));
        const Vec3 d = Vec3(.4f, .3f, .2f).mul(session.stage.irradiance(i, at)) * (cosine / 2);
        burst->full.cross(y, x) += d;
        for (int a = 0; a < 3; ++a) {
          burst->gradient[size_t(a)].cross(y, x) +=
              d * gradient_level(session.stage.leds()[i].direction, a);
        }
      }
    }
  }
  burst->full.parallel = burst->full.cross.clone();
  for (AnalyserPair& pair : burst->gradient) pair.parallel = pair.cross.clone();
}

// Noise-free photographs of `shape`, every pixel that shows it labelled 1.
inline Burst photograph(const Session& session, const Shape& shape) {
  Burst burst;
  burst.session = &session;
  burst.region_names = session.region_names;
  burst.led_noise = burst.projector_noise = burst.right_noise = {1e-8, 1e-6};
  burst.led_parallel_noise = burst.front_parallel_noise = burst.led_noise;
  burst.regions = Labels(kHeight, kWidth, uchar(0));
  burst.clipped_led = burst.clipped_projector = Mask(kHeight, kWidth, uchar(0));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      burst.regions(y, x) = shape(session.left.centre_mm(), session.left.ray(x, y)) ? 1 : 0;
    }
  }
  photograph_fringes(session, session.left, shape, &burst.fringe, &burst.front_lit);
  if (session.right) {
    photograph_fringes(session, *session.right, shape, &burst.right_fringe, &burst.right_front_lit);
  }
  photograph_gradients(session, shape, &burst);
  return burst;
}

inline float angle_deg(const Vec3& a, const Vec3& b) {
  return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / kPi;
}

inline float quantile(std::vector<float> values, double share) {
  if (values.empty()) return kNaN;
  const auto at = values.begin() + ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace lamella::fit::testing
