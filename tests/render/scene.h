// Small subjects with known answers, made of maps in memory.
#pragma once

#include <cmath>
#include <functional>

#include "io/view.h"
#include "render/subject.h"

namespace lamella::render {

// What a made-up surface is like at one point; position NaN: no surface.
struct Skin {
  Vec3 position_mm = Vec3::all(kNaN);
  Vec3 normal{0, 0, 1};
  Vec3 shallow{0, 0, 0}, deep{0, 0, 0};
  Vec3 ld_mm{1, 1, 1};
  float intensity = 0;
};

// A camera on +Z at 1000 mm that sees the origin in its centre, `mm_per_pixel` there.
inline Camera front_camera(int size, double mm_per_pixel) {
  Camera camera;
  camera.id = "left";
  camera.width = camera.height = size;
  camera.fx = camera.fy = 1000 / mm_per_pixel;
  camera.cx = camera.cy = (size - 1) / 2.0;
  camera.cam_from_rig = Mat33d(1, 0, 0, 0, -1, 0, 0, 0, -1);
  camera.translation_mm = {0, 0, 1000};
  return camera;
}

// Maps of the surface that `skin` describes for each ray of the camera (origin, direction).
inline Subject subject_of(const Camera& camera,
                          const std::function<Skin(const Vec3&, const Vec3&)>& skin) {
  Subject s;
  s.left = s.projector = camera;
  s.region_names = {"background", "all"};
  s.layers.add_regions()->set_name("all");
  const cv::Size size(camera.width, camera.height);
  LayerMaps& m = s.maps;
  for (Image3* map :
       {&m.position_mm, &m.normal_specular, &m.shallow_albedo, &m.deep_albedo, &m.deep_ld_mm}) {
    map->create(size);
  }
  m.specular_intensity.create(size);
  m.regions = Labels(size, 0);
  for (int i = 0; i < size.height; ++i) {
    for (int j = 0; j < size.width; ++j) {
      const Skin at = skin(Vec3(camera.centre_mm()), Vec3(camera.ray(j, i)));
      m.position_mm(i, j) = at.position_mm;
      m.normal_specular(i, j) = at.normal;
      m.shallow_albedo(i, j) = at.shallow;
      m.deep_albedo(i, j) = at.deep;
      m.deep_ld_mm(i, j) = at.ld_mm;
      m.specular_intensity(i, j) = at.intensity;
      m.regions(i, j) = is_finite(at.position_mm) ? 1 : 0;
    }
  }
  return s;
}

// The plane z = 0, all of one skin.
inline Subject plane(const Camera& camera, const Skin& skin) {
  return subject_of(camera, [skin](const Vec3& eye, const Vec3& ray) {
    Skin at = skin;
    at.position_mm = eye - ray * (eye[2] / ray[2]);
    return at;
  });
}

// A sphere around the origin, all of one skin.
inline Subject sphere(const Camera& camera, float radius_mm, const Skin& skin) {
  return subject_of(camera, [skin, radius_mm](const Vec3& eye, const Vec3& ray) {
    Skin at = skin;
    const float b = dot(eye, ray), c = dot(eye, eye) - radius_mm * radius_mm;
    if (b * b < c) return at;
    at.position_mm = eye + ray * (-b - std::sqrt(b * b - c));
    at.normal = unit(at.position_mm);
    return at;
  });
}

inline View lit_by(const Camera& camera, const Light& light) {
  View view;
  view.camera = camera;
  view.lights.push_back(light);
  return view;
}

inline Light point_light(const Vec3& position_mm, float radiance = 1) {
  Light light;
  light.kind = Light::Kind::kPoint;
  light.position_mm = position_mm;
  light.radiance_at_origin = Vec3::all(radiance);
  return light;
}

}  // namespace lamella::render
