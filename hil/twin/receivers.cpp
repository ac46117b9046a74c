#include "twin/receivers.h"

#include <algorithm>

#include "base/parallel.h"

namespace lamella::twin {

namespace {

constexpr int kBlockSide = 8;         // pixels
constexpr float kBlockRadius = 4.5f;  // mm; a block that spans a step in depth is split

// Place of a hit on the grid: rows and columns with their fractions. Triangles are (a, c, d) and
// (a, d, b) of a quad with corners a b above c d.
void place_on_grid(const Surface& s, const Hit& hit, float* row, float* column) {
  const int quad = hit.triangle / 2;
  const bool lower = hit.triangle % 2 == 0;
  *row = float(quad / s.columns) + (lower ? hit.u + hit.v : hit.u);
  *column = float(quad % s.columns) + (lower ? hit.v : hit.u + hit.v);
}

template <class Value>
Value interpolate(const Surface& s, const std::vector<Value>& values, const Hit& hit) {
  const cv::Vec3i& t = s.triangles[size_t(hit.triangle)];
  return values[size_t(t[0])] * (1.f - hit.u - hit.v) + values[size_t(t[1])] * hit.u +
         values[size_t(t[2])] * hit.v;
}

std::vector<Hit> cast_rays(const Camera& camera, const Surface& surface) {
  std::vector<Hit> hits(size_t(camera.width) * size_t(camera.height));
  const Vec3 centre = camera.centre_mm();
  parallel_for(
      camera.height,
      [&](int y) {
        for (int x = 0; x < camera.width; ++x) {
          hits[size_t(y * camera.width + x)] =
              surface.scene->intersect(centre, Vec3(camera.ray(x, y)), 1.f, 5000.f);
        }
      },
      8);
  return hits;
}

void resize(Receivers* r, size_t n) {
  r->to_camera.resize(n);
  r->normal.resize(n);
  r->shading_normal.resize(n);
  r->grid_row.resize(n);
  r->grid_column.resize(n);
  r->modulation.resize(n);
  r->intensity.resize(n);
  r->label.resize(n);
  r->targets.position_mm.resize(n);
  r->targets.regions.resize(n);
}

// Splits until every block lies close together.
void add_block(Receivers* r, std::vector<int> block) {
  if (block.empty()) return;
  Vec3 low = r->targets.position_mm[size_t(block[0])], high = low;
  for (int i : block) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], r->targets.position_mm[size_t(i)][a]);
      high[a] = std::max(high[a], r->targets.position_mm[size_t(i)][a]);
    }
  }
  const Vec3 size = high - low;
  if (length(size) > 2.f * kBlockRadius && block.size() > 1) {
    const int axis = size[2] >= std::max(size[0], size[1]) ? 2 : size[1] > size[0] ? 1 : 0;
    const float middle = 0.5f * (low[axis] + high[axis]);
    const auto split = std::partition(block.begin(), block.end(), [&](int i) {
      return r->targets.position_mm[size_t(i)][axis] < middle;
    });
    add_block(r, std::vector<int>(block.begin(), split));
    add_block(r, std::vector<int>(split, block.end()));
    return;
  }
  r->targets.blocks.push_back(std::move(block));
}

void add_blocks(Receivers* r, const std::vector<int>& entry_of_pixel) {
  for (int y = 0; y < r->height; y += kBlockSide) {
    for (int x = 0; x < r->width; x += kBlockSide) {
      std::vector<int> block;
      for (int j = y; j < std::min(y + kBlockSide, r->height); ++j) {
        for (int i = x; i < std::min(x + kBlockSide, r->width); ++i) {
          const int entry = entry_of_pixel[size_t(j * r->width + i)];
          if (entry >= 0) block.push_back(entry);
        }
      }
      add_block(r, std::move(block));
    }
  }
}

float mean_intensity(const RegionWeights& weights, const std::array<Skin, kRegionCount>& skins) {
  float c = 0;
  for (size_t k = 0; k < weights.size(); ++k) c += weights[k] * skins[k].intensity;
  return c;
}

}  // namespace

Image3 Receivers::image(const std::vector<Vec3>& values, const Vec3& background) const {
  Image3 image(height, width, background);
  for (size_t i = 0; i < size(); ++i) image(pixel[i] / width, pixel[i] % width) = values[i];
  return image;
}

Receivers see_subject(const Camera& camera, const Surface& surface, const Subject& subject,
                      const std::array<Skin, kRegionCount>& skins) {
  Receivers r;
  r.width = camera.width;
  r.height = camera.height;
  const std::vector<Hit> hits = cast_rays(camera, surface);
  std::vector<int> entry_of_pixel(hits.size(), -1);
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].triangle < 0) continue;
    entry_of_pixel[i] = int(r.pixel.size());
    r.pixel.push_back(int(i));
  }
  resize(&r, r.pixel.size());
  const Vec3 centre = camera.centre_mm();
  parallel_for(
      int(r.size()),
      [&](int n) {
        const size_t i = size_t(n);
        const Hit& hit = hits[size_t(r.pixel[i])];
        const Vec3 p = interpolate(surface, surface.position_mm, hit);
        r.targets.position_mm[i] = p;
        r.to_camera[i] = unit(centre - p);
        r.normal[i] = unit(interpolate(surface, surface.normal, hit));
        r.shading_normal[i] = unit(interpolate(surface, surface.shading_normal, hit));
        place_on_grid(surface, hit, &r.grid_row[i], &r.grid_column[i]);
        r.targets.regions[i] = subject.regions(p);
        r.modulation[i] = subject.albedo_modulation(p);
        r.intensity[i] =
            mean_intensity(r.targets.regions[i], skins) * subject.intensity_modulation(p);
        const bool known = subject.labelled(p) && dot(r.normal[i], r.to_camera[i]) > 0.1f;
        r.label[i] = known ? uint8_t(strongest_region(r.targets.regions[i])) : uint8_t(0);
      },
      512);
  add_blocks(&r, entry_of_pixel);
  return r;
}

}  // namespace lamella::twin
