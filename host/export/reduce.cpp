#include "export/reduce.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace lamella::exporting {

namespace {

constexpr double kPixelsPerTriangle = 8;  // of which a mesh chooses its vertices
constexpr int kStep_px = 4;               // between pixels that tell how large the face is

template <class Value>
Value unknown() {
  return Value::all(kNaN);
}
template <>
float unknown<float>() {
  return kNaN;
}
template <>
uchar unknown<uchar>() {
  return 0;
}

bool is_known(uchar label) { return label > 0; }
bool is_known(float value) { return is_finite(value); }
bool is_known(const Vec3& value) { return is_finite(value); }

// merge(first pixel's row and column) for every whole block.
template <class Value, class Merge>
cv::Mat_<Value> by_blocks(const cv::Mat_<Value>& map, int block_px, const Merge& merge) {
  cv::Mat_<Value> out(map.rows / block_px, map.cols / block_px);
  parallel_for(out.rows, [&](int y) {
    for (int x = 0; x < out.cols; ++x) out(y, x) = merge(y * block_px, x * block_px);
  });
  return out;
}

template <class Value>
cv::Mat_<Value> averaged(const cv::Mat_<Value>& map, int block_px) {
  return by_blocks(map, block_px, [&](int top, int left) {
    Value sum{};
    float count = 0;
    for (int y = top; y < top + block_px; ++y) {
      for (int x = left; x < left + block_px; ++x) {
        if (!is_known(map(y, x))) continue;
        sum += map(y, x);
        ++count;
      }
    }
    return count > 0 ? sum * (1 / count) : unknown<Value>();
  });
}

// The middle pixel, or where it is not known the first that is.
template <class Value>
cv::Mat_<Value> picked(const cv::Mat_<Value>& map, int block_px) {
  return by_blocks(map, block_px, [&](int top, int left) {
    const Value middle = map(top + block_px / 2, left + block_px / 2);
    if (is_known(middle)) return middle;
    for (int y = top; y < top + block_px; ++y) {
      for (int x = left; x < left + block_px; ++x) {
        if (is_known(map(y, x))) return map(y, x);
      }
    }
    return unknown<Value>();
  });
}

struct Extent {
  cv::Rect box;
  double pixels = 0;
};

Extent known_extent(const Image3& map) {
  Extent extent;
  for (int y = 0; y < map.rows; y += kStep_px) {
    for (int x = 0; x < map.cols; x += kStep_px) {
      if (!is_finite(map(y, x))) continue;
      extent.box |= cv::Rect(x, y, 1, 1);
      extent.pixels += kStep_px * kStep_px;
    }
  }
  return extent;
}

}  // namespace

int block_of(const LayerMaps& maps, const ExportOptions& options) {
  const Extent face = known_extent(maps.position_mm);
  const int of_texture = std::max(face.box.width, face.box.height) / options.texture_side_px;
  const double of_mesh = std::sqrt(face.pixels / (kPixelsPerTriangle * options.triangles));
  return std::max(1, std::min(of_texture, int(of_mesh)));
}

LayerMaps reduced(const LayerMaps& maps, int block_px) {
  if (block_px == 1) return maps;
  LayerMaps out;
  out.position_mm = picked(maps.position_mm, block_px);
  out.regions = picked(maps.regions, block_px);
  out.specular_intensity = averaged(maps.specular_intensity, block_px);
  for (Image3 LayerMaps::*m : {&LayerMaps::normal_specular, &LayerMaps::total_albedo,
                               &LayerMaps::deep_albedo, &LayerMaps::shallow_albedo}) {
    out.*m = averaged(maps.*m, block_px);
  }
  parallel_for(out.normal_specular.rows, [&](int y) {
    for (Vec3& n : cv::Mat_<Vec3>(out.normal_specular.row(y))) n = unit(n);
  });
  return out;
}

}  // namespace lamella::exporting
