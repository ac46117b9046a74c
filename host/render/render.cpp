#include "render/render.h"

#include <algorithm>

#include "base/parallel.h"
#include "render/diffuse.h"

namespace lamella::render {

namespace {

// Bilinear, over the neighbours that are known.
Vec3 sample(const Image3& map, const cv::Vec2f& pixel) {
  const int x0 = std::clamp(int(pixel[0]), 0, map.cols - 2);
  const int y0 = std::clamp(int(pixel[1]), 0, map.rows - 2);
  const float fx = pixel[0] - float(x0), fy = pixel[1] - float(y0);
  Vec3 sum(0, 0, 0);
  float total = 0;
  for (int k = 0; k < 4; ++k) {
    const float w = (k & 1 ? fx : 1 - fx) * (k & 2 ? fy : 1 - fy);
    const Vec3& value = map(y0 + (k >> 1), x0 + (k & 1));
    if (w <= 0 || !is_finite(value)) continue;
    sum += value * w;
    total += w;
  }
  return total > 0 ? sum * (1 / total) : Vec3(0, 0, 0);
}

}  // namespace

Image3 render_view(const Subject& subject, const View& view, const RenderOptions& options) {
  const Lights lights(view, subject.stage, subject.projector, options.environment_cells);
  const Surface surface = build_surface(subject.maps, lights.size() > 8 ? 2 : 1);
  const Visibility visibility(surface, lights);
  const SpreadLight light = spread(subject, surface, irradiance(surface, lights, visibility));
  const int mode = getenv("MODE") ? atoi(getenv("MODE")) : 0;
  Image3 image(view.camera.height, view.camera.width, Vec3(0, 0, 0));
  const Vec3 origin = Vec3(view.camera.centre_mm());
  parallel_for(image.rows, [&](int row) {
    for (int col = 0; col < image.cols; ++col) {
      const SurfacePoint point = trace(surface, origin, Vec3(view.camera.ray(col, row)));
      if (!point.on_surface()) continue;
      Vec3 sh = sample(subject.maps.shallow_albedo, point.pixel);
      Vec3 de = sample(subject.maps.deep_albedo, point.pixel);
      if (mode & 1) {
        const Vec3 t = sample(subject.maps.total_albedo, point.pixel);
        for (int c = 0; c < 3; ++c) { float s = t[c] / std::max(sh[c] + de[c], 1e-3f); sh[c] *= s, de[c] *= s; }
      }
      if (mode & 2) de += sh, sh = Vec3(0, 0, 0);
      if (mode & 4) sh += de, de = Vec3(0, 0, 0);
      image(row, col) = sh.mul(interpolate(light.shallow, point)) + de.mul(interpolate(light.deep, point));
    }
  });
  return image;
}

}  // namespace lamella::render
