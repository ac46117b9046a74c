#include "render/render.h"

#include <algorithm>

#include "base/parallel.h"
#include "render/completion.h"
#include "render/diffuse.h"
#include "render/map_lookup.h"
#include "render/reflection.h"

namespace lamella::render {

namespace {

// With more lights than this the mesh has every second pixel, and pixels take the shadows of its
// vertices instead of tracing their own.
constexpr size_t kManyLights = 8;
// Rays of the camera that measured the surface would meet its vertices exactly, where rounding can
// leave them to no triangle.
constexpr double kBesidePixel = 1e-3;

Vec3 known_or_zero(const Vec3& v) { return is_finite(v) ? v : Vec3(0, 0, 0); }

// All that does not depend on the pixel.
struct Scene {
  Scene(const Subject& subject, const View& view, int environment_cells)
      : lights(view, subject.stage, subject.projector, environment_cells),
        complete(complete_maps(subject.maps)),
        maps(complete.maps),
        surface(build_surface(complete, lights.size() > kManyLights ? 2 : 1)),
        visibility(surface, lights),
        spread_light(
            spread(RegionKernels(subject), surface, irradiance(surface, lights, visibility))),
        reflection(subject) {}

  Lights lights;
  CompleteMaps complete;
  const LayerMaps& maps;
  Surface surface;
  Visibility visibility;
  SpreadLight spread_light;
  Reflection reflection;
};

int nearest_corner(const SurfacePoint& point) {
  int k = point.weight[1] > point.weight[0] ? 1 : 0;
  if (point.weight[2] > point.weight[k]) k = 2;
  return point.corner[k];
}

SkinPoint skin_at(const Scene& scene, const SurfacePoint& point, const Vec3& to_camera) {
  SkinPoint skin;
  skin.region = scene.surface.region[nearest_corner(point)];
  skin.normal = unit(look_up(scene.maps.normal_specular, point.pixel));
  skin.to_camera = to_camera;
  if (!scene.maps.specular_intensity.empty()) {
    const float c = look_up(scene.maps.specular_intensity, point.pixel);
    skin.intensity = is_finite(c) ? c : 0.f;
  }
  if (!scene.maps.single_albedo.empty()) {
    skin.single_alpha = known_or_zero(look_up(scene.maps.single_albedo, point.pixel));
  }
  return skin;
}

// Share of light `i` that reaches a point.
float visible_share(const Scene& scene, size_t i, const Incident& light, const SurfacePoint& point,
                    const Vec3& x_mm, const Vec3& normal) {
  if (scene.lights.size() <= kManyLights) {
    return shaded(scene.surface, x_mm, normal, light.direction, light.distance_mm) ? 0.f : 1.f;
  }
  float share = 0;
  for (int k = 0; k < 3; ++k) share += point.weight[k] * scene.visibility(i, point.corner[k]);
  return share;
}

Vec3 reflected(const Scene& scene, const SurfacePoint& point, const Vec3& x_mm,
               const SkinPoint& skin) {
  Vec3 sum(0, 0, 0);
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    const Incident light = scene.lights.at(i, x_mm);
    if (dot(light.direction, skin.normal) <= 0) continue;
    const float share = visible_share(scene, i, light, point, x_mm, skin.normal);
    if (share > 0) sum += scene.reflection.radiance(skin, light) * share;
  }
  return sum;
}

Vec3 scattered(const Scene& scene, const SurfacePoint& point) {
  const Vec3 shallow = known_or_zero(look_up(scene.maps.shallow_albedo, point.pixel));
  const Vec3 deep = known_or_zero(look_up(scene.maps.deep_albedo, point.pixel));
  return shallow.mul(interpolate(scene.spread_light.shallow, point)) +
         deep.mul(interpolate(scene.spread_light.deep, point));
}

}  // namespace

Image3 render_view(const Subject& subject, const View& view, const RenderOptions& options) {
  const Scene scene(subject, view, options.environment_cells);
  Image3 image(view.camera.height, view.camera.width, Vec3(0, 0, 0));
  const Vec3 eye = Vec3(view.camera.centre_mm());
  parallel_for(image.rows, [&](int row) {
    for (int col = 0; col < image.cols; ++col) {
      const Vec3 ray = Vec3(view.camera.ray(col + kBesidePixel, row + kBesidePixel));
      const SurfacePoint point = trace(scene.surface, eye, ray);
      if (!point.on_surface()) continue;
      const Vec3 x_mm = interpolate(scene.surface.mesh.vertices_mm, point);
      const SkinPoint skin = skin_at(scene, point, -ray);
      image(row, col) = reflected(scene, point, x_mm, skin) + scattered(scene, point);
    }
  });
  return image;
}

}  // namespace lamella::render
