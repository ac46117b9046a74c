#include "export/for_view.h"

#include <algorithm>

#include "base/error.h"

namespace lamella::exporting {

namespace {

constexpr double kEdgePx = 4;            // of a triangle: its facets are smaller than one looks for
constexpr double kAlmostLargest = 0.95;  // share of the face: at the very rim lengths are noise
constexpr double kUsualSlabMm = 0.5;     // the epidermis in the paper's section 4.2
constexpr int kLeastTriangles = 100, kLeastSidePx = 16;
constexpr char kDeep[] = "deep scattering", kShallow[] = "shallow scattering";

struct Footprint {
  cv::Vec2d low_px{1e9, 1e9}, high_px{-1e9, -1e9};
  double area_px2 = 0;           // of the whole face
  double area_texels = 0;        // of the maps
  std::vector<double> texel_px;  // side of a map's pixel in the view
  std::vector<double> px_per_mm;
  cv::Rect texels;  // of the face in the maps
};

// Half the cross product of the sides of a map's pixel, and their lengths, projected.
void add_pixel(const LayerMaps& maps, const Camera& camera, const cv::Point& at, Footprint* f) {
  const Vec3d here = maps.position_mm(at), right = maps.position_mm(at + cv::Point(1, 0)),
              down = maps.position_mm(at + cv::Point(0, 1));
  if (!is_finite(Vec3(here + right + down))) return;
  for (const Vec3d& p : {here, right, down}) {
    if ((camera.cam_from_rig * p + camera.translation_mm)[2] <= 0) return;  // behind the camera
  }
  const cv::Vec2d a = camera.project(here);
  const cv::Vec2d u = camera.project(right) - a, v = camera.project(down) - a;
  ++f->area_texels;
  const double turn = u[0] * v[1] - u[1] * v[0];
  if (turn <= 0) return;  // seen from behind
  f->area_px2 += turn;
  f->texel_px.push_back(std::max(cv::norm(u), cv::norm(v)));
  f->px_per_mm.push_back(
      std::max(cv::norm(u) / cv::norm(right - here), cv::norm(v) / cv::norm(down - here)));
  for (int k = 0; k < 2; ++k) {
    f->low_px[k] = std::min(f->low_px[k], a[k]);
    f->high_px[k] = std::max(f->high_px[k], a[k]);
  }
}

Footprint footprint_of(const LayerMaps& maps, const Camera& camera) {
  Footprint f;
  cv::Point low(maps.position_mm.cols, maps.position_mm.rows), high(0, 0);
  for (int y = 0; y + 1 < maps.position_mm.rows; ++y) {
    for (int x = 0; x + 1 < maps.position_mm.cols; ++x) {
      if (!is_finite(maps.position_mm(y, x))) continue;
      low = {std::min(low.x, x), std::min(low.y, y)};
      high = {std::max(high.x, x), std::max(high.y, y)};
      add_pixel(maps, camera, {x, y}, &f);
    }
  }
  f.texels = cv::Rect(low, high + cv::Point(1, 1));
  return f;
}

double almost_largest(std::vector<double> values) {
  const auto at = values.begin() + long(kAlmostLargest * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double deep_radius_mm(const v1::Region& region) {
  const auto& ld_mm = region.deep().ld_mm();
  return ld_mm.empty() ? 0 : *std::max_element(ld_mm.begin(), ld_mm.end());
}

// A slab lets light travel about as far sideways as it is thick.
double shallow_radius_mm(const v1::Region& region) {
  const auto& ld_mm = region.shallow().ld_mm();
  if (ld_mm.empty()) return 0;
  const double longest_mm = *std::max_element(ld_mm.begin(), ld_mm.end());
  const v1::ShallowScattering& slab = region.shallow();
  return std::min(longest_mm, slab.has_thickness_mm() ? slab.thickness_mm() : kUsualSlabMm);
}

void choose_layer(const std::string& name, const v1::Layers& layers,
                  double (*radius_mm)(const v1::Region&), ViewChoice* choice) {
  LayerChoice c;
  c.layer = name;
  for (const v1::Region& region : layers.regions()) {
    c.radius_mm = std::max(c.radius_mm, radius_mm(region));
  }
  if (c.radius_mm <= 0) return;  // was not fitted: nothing to keep or to leave out
  c.radius_px = c.radius_mm * choice->px_per_mm;
  c.is_kept = c.radius_px >= 1;
  c.why = c.is_kept ? "more than a pixel" : "less than a pixel is albedo, which the textures have";
  choice->layers.push_back(c);
}

}  // namespace

ViewChoice choose_for_view(const LayerMaps& maps, const v1::Layers& layers, const View& view,
                           const std::string& where) {
  const Footprint f = footprint_of(maps, view.camera);
  const cv::Rect2d frame(0, 0, view.camera.width, view.camera.height);
  const cv::Rect2d face(cv::Point2d(f.low_px[0], f.low_px[1]),
                        cv::Point2d(f.high_px[0], f.high_px[1]));
  if (f.texel_px.empty() || (face & frame).empty()) {
    throw_bad_input(where, "its camera does not see the face", "turn it towards the face");
  }
  ViewChoice choice;
  choice.face_px = cv::Size2f(face.size());
  choice.px_per_mm = almost_largest(f.px_per_mm);
  const double most_side = std::max(f.texels.width, f.texels.height);
  const double side = most_side * std::min(1.0, almost_largest(f.texel_px));
  choice.texture_side_px = std::max(kLeastSidePx, int(std::ceil(side)));
  const double triangles = 2 * std::min(f.area_px2 / (kEdgePx * kEdgePx), f.area_texels);
  choice.triangles = std::max(kLeastTriangles, int(std::ceil(triangles)));
  choose_layer(kDeep, layers, deep_radius_mm, &choice);
  choose_layer(kShallow, layers, shallow_radius_mm, &choice);
  return choice;
}

v1::Layers kept_layers(const v1::Layers& layers, const ViewChoice& choice) {
  v1::Layers kept = layers;
  for (const LayerChoice& c : choice.layers) {
    for (v1::Region& region : *kept.mutable_regions()) {
      if (c.is_kept) continue;
      if (c.layer == kDeep) region.clear_deep();
      if (c.layer == kShallow) region.clear_shallow();
    }
  }
  return kept;
}

ExportOptions options_for_view(const ViewChoice& choice, const ExportOptions& most) {
  ExportOptions options = most;
  options.triangles = std::min(most.triangles, choice.triangles);
  options.texture_side_px = std::min(most.texture_side_px, choice.texture_side_px);
  return options;
}

}  // namespace lamella::exporting
