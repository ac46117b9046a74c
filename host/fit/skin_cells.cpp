#include "fit/skin_cells.h"

#include <algorithm>

#include "base/parallel.h"
#include "fit/diffuse_total.h"
#include "fit/order_statistics.h"

namespace lamella::fit {

namespace {

constexpr double kCellMm = 2;
constexpr double kLeastSeen = 0.3;          // of a cell's pixels
constexpr float kFrontal = 0.6f;            // cosine towards camera and projector
constexpr float kOpen = 0.75f;              // share of the LEDs' light that is not hidden
constexpr float kPeakCosine = 0.98480775f;  // 10 degrees
constexpr double kDarkest = 1e-4;           // whose logarithm is still taken
constexpr size_t kAngleBins = 12;
constexpr size_t kFewestOfAngle = 5;
constexpr double kMostGloss = 0.1, kMostSheen = 1;  // beyond: a normal that is off, or a shadow

struct CellSums {
  int seen = 0, peak = 0;
  Vec3d albedo{0, 0, 0};
  double cosine = 0, mirrored = 0, polarized = 0;
};

double safe_log(double value) { return std::log(std::max(value, kDarkest)); }

class CellMaker {
 public:
  CellMaker(const Burst& burst, const Geometry& geometry, const Normals& normals)
      : burst_(burst),
        geometry_(geometry),
        normals_(normals),
        total_(burst, geometry, normals),
        px_per_mm_(1 / burst.session->left.pixel_mm()) {}

  int step_px() const { return std::max(1, int(std::lround(kCellMm * px_per_mm_))); }

  CellSums sum(const cv::Rect& pixels) const {
    CellSums sums;
    for (int y = pixels.y; y < pixels.br().y; ++y) {
      for (int x = pixels.x; x < pixels.br().x; ++x) {
        if (is_seen_well(y, x)) add(y, x, &sums);
      }
    }
    return sums;
  }

  // `cosine`: the mean towards the camera.
  SkinCell cell(const CellSums& sums, int pixels, double* cosine) const {
    SkinCell cell;
    if (sums.seen == 0 || sums.seen < kLeastSeen * pixels || sums.polarized <= 0) return cell;
    const double per_pixel = 1.0 / sums.seen;
    cell.area_mm2 = sums.seen / (px_per_mm_ * px_per_mm_);
    cell.peak_mm2 = sums.peak / (px_per_mm_ * px_per_mm_);
    const Vec3d& a = sums.albedo;
    cell.red = safe_log(a[0] * per_pixel) - safe_log(a[1] * per_pixel);
    cell.yellow = safe_log(a[1] * per_pixel) - safe_log(a[2] * per_pixel);
    cell.light = safe_log((a[0] + a[1] + a[2]) / 3 * per_pixel);
    cell.gloss = sums.mirrored / sums.polarized;
    cell.sheen = safe_log(sums.polarized * per_pixel);
    *cosine = sums.cosine * per_pixel;
    return cell;
  }

 private:
  bool is_seen_well(int y, int x) const {
    const Vec3& n = normals_.specular(y, x);
    if (!burst_.regions(y, x) || is_clipped(burst_.clipped_led, y, x) || !is_finite(n))
      return false;
    if (!is_finite(geometry_.position_mm(y, x))) return false;
    return dot(n, geometry_.to_camera(y, x)) > kFrontal &&
           dot(n, geometry_.to_projector(y, x)) > kFrontal &&
           normals_.ambient_visibility(y, x) > kOpen;
  }

  void add(int y, int x, CellSums* sums) const {
    const Vec3 n = normals_.specular(y, x), v = geometry_.to_camera(y, x);
    const float n_v = dot(n, v), full = polarized_at(burst_.full, y, x);
    const Vec3 mirror = n * (2 * n_v) - v;
    const Vec3 half = unit(v + geometry_.to_projector(y, x));
    ++sums->seen;
    sums->peak += dot(n, half) > kPeakCosine;
    sums->albedo += Vec3d(total_.from_leds(y, x).albedo);
    sums->cosine += double(n_v);
    sums->polarized += double(full);
    // A gradient lights by (1 + w.a)/2: twice it less the whole is the sum of S w.a.
    for (int a = 0; a < 3; ++a) {
      const float along = 2 * polarized_at(burst_.gradient[size_t(a)], y, x) - full;
      sums->mirrored += double(along * mirror[a]);
    }
  }

  static float polarized_at(const AnalyserPair& pair, int y, int x) {
    return mean(pair.parallel(y, x) - pair.cross(y, x));
  }

  const Burst& burst_;
  const Geometry& geometry_;
  const Normals& normals_;
  DiffuseTotal total_;
  double px_per_mm_;
};

// Skin shines more, and more sharply, the more grazing it is looked at, whatever it is like: takes
// the middle of all cells out that are looked at under an angle like the cell's.
void relate_to_angle(double SkinCell::*figure, double most, const std::vector<double>& cosines,
                     std::vector<SkinCell>* cells) {
  std::array<std::vector<double>, kAngleBins> values;
  for (size_t i = 0; i < cells->size(); ++i) {
    if ((*cells)[i].area_mm2 <= 0) continue;
    const double bin = std::clamp(cosines[i], 0.0, 1.0) * kAngleBins;
    values[std::min(kAngleBins - 1, size_t(bin))].push_back((*cells)[i].*figure);
  }
  std::vector<std::pair<double, double>> middle;  // cosine, figure
  for (size_t bin = 0; bin < kAngleBins; ++bin) {
    if (values[bin].size() < kFewestOfAngle) continue;
    middle.push_back({(double(bin) + 0.5) / kAngleBins, median_of(&values[bin])});
  }
  if (middle.empty()) middle.push_back({0.5, 0});
  for (size_t i = 0; i < cells->size(); ++i) {
    double& value = (*cells)[i].*figure;
    size_t above = 0;
    while (above < middle.size() && middle[above].first < cosines[i]) ++above;
    const auto& a = middle[above == 0 ? 0 : above - 1];
    const auto& b = middle[std::min(above, middle.size() - 1)];
    const double t = b.first > a.first ? (cosines[i] - a.first) / (b.first - a.first) : 0;
    value = std::clamp(value - (a.second + t * (b.second - a.second)), -most, most);
  }
}

}  // namespace

SkinCells skin_cells(const Burst& burst, const Geometry& geometry, const Normals& normals) {
  const CellMaker maker(burst, geometry, normals);
  SkinCells out;
  out.step_px = maker.step_px();
  const cv::Rect picture({0, 0}, burst.regions.size());
  const auto blocks = [&](int pixels) { return (pixels + out.step_px - 1) / out.step_px; };
  out.size = {blocks(picture.width), blocks(picture.height)};
  out.cells.resize(size_t(out.size.area()));
  std::vector<double> cosines(out.cells.size(), 1.0);
  parallel_for(out.size.height, [&](int row) {
    for (int column = 0; column < out.size.width; ++column) {
      const cv::Rect pixels =
          cv::Rect(column * out.step_px, row * out.step_px, out.step_px, out.step_px) & picture;
      const size_t i = size_t(row * out.size.width + column);
      out.cells[i] = maker.cell(maker.sum(pixels), pixels.area(), &cosines[i]);
    }
  });
  relate_to_angle(&SkinCell::gloss, kMostGloss, cosines, &out.cells);
  relate_to_angle(&SkinCell::sheen, kMostSheen, cosines, &out.cells);
  return out;
}

}  // namespace lamella::fit
