#include "export/normal_bake.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "base/fill.h"
#include "base/parallel.h"

namespace lamella::exporting {

namespace {

struct Corner {
  Vec2 texel;
  Vec3 normal, tangent;
};

// The inverse of the frame that a renderer interpolates, applied to the measured normal.
Vec3 in_frame(const Vec3& n, const Vec3& normal, const Vec3& tangent) {
  const Vec3 z = unit(normal), t = unit(tangent), b = cross(z, t);
  const cv::Matx33f frame(t[0], b[0], z[0], t[1], b[1], z[1], t[2], b[2], z[2]);
  Vec3 local = unit(frame.inv() * n);
  local[2] = std::max(local[2], 0.05f);  // a normal map cannot face away from its surface
  return unit(local);
}

float edge(const Vec2& a, const Vec2& b, const Vec2& p) {
  return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

// Rows of texels that one thread bakes.
constexpr int kBandRows = 32;

using Triangle = std::array<Corner, 3>;

std::pair<float, float> rows_of(const Triangle& c) {
  return std::minmax({c[0].texel[1], c[1].texel[1], c[2].texel[1]});
}

// The texels of `c` in the rows of `band`.
void bake_triangle(const Triangle& c, const cv::Range& band, const Image3& normal, Image3* local) {
  const float area = edge(c[0].texel, c[1].texel, c[2].texel);
  if (std::abs(area) < 1e-6f) return;
  const auto [x0, x1] = std::minmax({c[0].texel[0], c[1].texel[0], c[2].texel[0]});
  const auto [y0, y1] = rows_of(c);
  const int top = std::max(band.start, int(std::ceil(y0))), left = std::max(0, int(std::ceil(x0)));
  for (int y = top; y <= std::min(band.end - 1, int(y1)); ++y) {
    for (int x = left; x <= std::min(normal.cols - 1, int(x1)); ++x) {
      const Vec2 p{float(x), float(y)};
      const float w0 = edge(c[1].texel, c[2].texel, p) / area;
      const float w1 = edge(c[2].texel, c[0].texel, p) / area, w2 = 1.f - w0 - w1;
      if (w0 < 0 || w1 < 0 || w2 < 0) continue;
      (*local)(y, x) =
          in_frame(normal(y, x), c[0].normal * w0 + c[1].normal * w1 + c[2].normal * w2,
                   c[0].tangent * w0 + c[1].tangent * w1 + c[2].tangent * w2);
    }
  }
}

}  // namespace

Image3 tangent_space_normals(const Image3& normal, const EngineMesh& mesh) {
  Image3 local(normal.size(), Vec3(kNaN, kNaN, kNaN));
  const auto corner = [&](uint32_t i) {
    const EngineVertex& v = mesh.vertices[i];
    const Vec2 texel(v.uv[0] * float(normal.cols) - 0.5f, v.uv[1] * float(normal.rows) - 0.5f);
    return Corner{texel, v.normal, {v.tangent[0], v.tangent[1], v.tangent[2]}};
  };
  std::vector<Triangle> triangles(mesh.indices.size() / 3);
  std::vector<std::vector<size_t>> in_band(size_t((normal.rows - 1) / kBandRows + 1));
  for (size_t i = 0; i < triangles.size(); ++i) {
    const uint32_t* t = &mesh.indices[i * 3];
    triangles[i] = {corner(t[0]), corner(t[1]), corner(t[2])};
    const auto [top, bottom] = rows_of(triangles[i]);
    const int last = std::min(int(in_band.size()) - 1, int(bottom) / kBandRows);
    for (int b = std::max(0, int(top) / kBandRows); b <= last; ++b) in_band[size_t(b)].push_back(i);
  }
  // Neighbours both write the texels of their common edge, nearly the same: band by band it is
  // always the same one that writes last.
  parallel_for(int(in_band.size()), [&](int b) {
    const cv::Range band(b * kBandRows, std::min(normal.rows, (b + 1) * kBandRows));
    for (size_t i : in_band[size_t(b)]) bake_triangle(triangles[i], band, normal, &local);
  });
  return fill_unknown(local);
}

}  // namespace lamella::exporting
