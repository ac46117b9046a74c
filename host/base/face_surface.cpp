#include "base/face_surface.h"

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>

#include "base/grid_mesh.h"
#include "base/outline.h"

namespace lamella {

namespace {

// Lengths are shares of the square root of the face's area, so that they mean the same at every
// resolution.
constexpr float kClosing = 0.045f;  // an eyebrow that no region has
constexpr float kOpening = 0.015f;
constexpr float kOutlineSigma = 0.03f;
constexpr float kTearArea = 0.3f;  // pixels of torn edge; shorter ones are noise or a nostril
constexpr float kIslandShare = 0.02f;
constexpr float kHoleShare = 0.03f;
constexpr float kTearSlope = 8.f;     // neighbours this many times further apart than is usual
constexpr float kGrazingSlope = 4.f;  // seen so obliquely that an outline there frays in depth
constexpr float kCutReach = 1.5f;     // pixels beside a tear that a cut takes away
constexpr float kTornReach = 2.f;     // pixels beside a tear that see a little of both sides
constexpr float kSliver = 2.f;        // pixels: half the width of what is too narrow to believe
constexpr int kBorderRoom = 12;       // pixels around the face
constexpr int kBorderSmoothing = 6;   // passes over the outline in space

float distance_mm(const Image3& p, int y, int x, int dy, int dx) {
  return length(p(y + dy, x + dx) - p(y, x));
}

float usual_spacing_mm(const Image3& p, const Mask& known) {
  std::vector<float> spacing;
  for (int y = 0; y < p.rows; y += 3) {
    for (int x = 0; x + 1 < p.cols; x += 3) {
      if (known(y, x) && known(y, x + 1)) spacing.push_back(distance_mm(p, y, x, 0, 1));
    }
  }
  if (spacing.empty()) return 0.f;
  std::nth_element(spacing.begin(), spacing.begin() + spacing.size() / 2, spacing.end());
  return spacing[spacing.size() / 2];
}

// Pixels on either side of a step in depth of more than `limit_mm`.
Mask steps_over(const Image3& p, const Mask& known, float limit_mm) {
  Mask steps(p.size(), uchar(0));
  for (int y = 0; y + 1 < p.rows; ++y) {
    for (int x = 0; x + 1 < p.cols; ++x) {
      if (!known(y, x)) continue;
      const bool right = known(y, x + 1) && distance_mm(p, y, x, 0, 1) > limit_mm;
      const bool down = known(y + 1, x) && distance_mm(p, y, x, 1, 0) > limit_mm;
      if (right) steps(y, x) = steps(y, x + 1) = 255;
      if (down) steps(y, x) = steps(y + 1, x) = 255;
    }
  }
  return steps;
}

// Keeps the connected parts with at least `least_px` pixels.
Mask large_parts(const Mask& mask, double least_px) {
  cv::Mat labels, stats, centres;
  const int n = cv::connectedComponentsWithStats(mask, labels, stats, centres, 8, CV_32S);
  std::vector<uchar> keep(n, 0);
  for (int i = 1; i < n; ++i) keep[i] = stats.at<int>(i, cv::CC_STAT_AREA) >= least_px ? 255 : 0;
  Mask kept(mask.size());
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) kept(y, x) = keep[labels.at<int>(y, x)];
  }
  return kept;
}

// A hole is background that does not reach the border of the picture.
Mask without_small_holes(const Mask& mask, double largest_px) {
  return ~large_parts(~mask, largest_px);
}

// What closing brings back inside the face, an oblique nose or an eyelid, it does not at the rim.
// Long tears that reach the rim are cut; a cut that the face surrounds would be a hole in it, and
// is bridged.
Mask body(const Image3& p, const Mask& known, const Mask& tears, float scale_px) {
  const float usual_mm = usual_spacing_mm(p, known);
  const Mask sound = known & ~steps_over(p, known, kGrazingSlope * usual_mm);
  const Mask cut = closed(sound, kClosing * scale_px) & ~tears;
  const Mask whole = without_small_holes(cut, kHoleShare * scale_px * scale_px);
  return opened(whole, kOpening * scale_px);
}

}  // namespace

FaceOutline outline_face(const Image3& position_mm, const Mask& known) {
  const double area = cv::countNonZero(known);
  if (area < 100) return {};
  const float scale_px = float(std::sqrt(area));
  // Room around the picture, so that closing does not see its border as an edge of the face.
  const int margin = int(kClosing * scale_px) + kBorderRoom;
  const cv::Rect inner = cv::boundingRect(known);
  const cv::Rect box((inner.tl() - cv::Point(margin, margin)),
                     inner.size() + cv::Size(2 * margin, 2 * margin));
  Image3 p(box.size(), Vec3(kNaN, kNaN, kNaN));
  Mask k(box.size(), uchar(0));
  const cv::Rect place(margin, margin, inner.width, inner.height);
  position_mm(inner).copyTo(p(place));
  known(inner).copyTo(k(place));

  const Mask torn = steps_over(p, k, kTearSlope * usual_spacing_mm(p, k));
  const Mask tears = grown(large_parts(torn, kTearArea * scale_px), kCutReach);
  Mask mask = body(p, k, tears, scale_px);
  mask = large_parts(mask, kIslandShare * area);
  const Mask cuts = tears & ~mask;
  Image1 soft;
  mask.convertTo(soft, CV_32F, 1.0 / 255);
  cv::GaussianBlur(soft, soft, {}, kOutlineSigma * scale_px);
  mask = large_parts(Mask((soft > 0.5f) & ~cuts), kIslandShare * area);  // smoothing heals no cut

  Image1 distance = signed_distance_px(mask) - 1.f;  // a pixel in, where positions are measured
  cv::GaussianBlur(distance, distance, {}, 1.5);
  // Room for the border's triangles too, where the picture has it.
  const cv::Rect picture(-box.tl(), position_mm.size());
  cv::Rect part = cv::boundingRect(mask);
  part = cv::Rect(part.tl() - cv::Point(kBorderRoom, kBorderRoom),
                  part.size() + cv::Size(2 * kBorderRoom, 2 * kBorderRoom)) &
         picture & cv::Rect({}, box.size());
  FaceOutline outline;
  outline.box = part + box.tl();
  outline.inside_px = distance(part).clone();
  // Slivers between unknown pixels saw both sides of an edge too.
  const Mask slivers = k & ~opened(k, kSliver);
  outline.torn = grown(torn | slivers, kTornReach)(part).clone();
  return outline;
}

Vec3 sample(const Image3& image, Vec2 pixel) {
  const float x = std::clamp(pixel[0], 0.f, float(image.cols - 1));
  const float y = std::clamp(pixel[1], 0.f, float(image.rows - 1));
  const int x0 = std::min(int(x), image.cols - 2), y0 = std::min(int(y), image.rows - 2);
  const float u = x - float(x0), v = y - float(y0);
  return (image(y0, x0) * (1 - u) + image(y0, x0 + 1) * u) * (1 - v) +
         (image(y0 + 1, x0) * (1 - u) + image(y0 + 1, x0 + 1) * u) * v;
}

namespace {

float inside_at(const Image1& inside_px, Vec2 p) {
  const int x = std::clamp(int(p[0] + 0.5f), 0, inside_px.cols - 1);
  const int y = std::clamp(int(p[1] + 0.5f), 0, inside_px.rows - 1);
  return inside_px(y, x);
}

// Follows the slope of the distance to where it is zero.
Vec2 on_outline(const Image1& inside_px, Vec2 p) {
  for (int i = 0; i < 3; ++i) {
    const float here = inside_at(inside_px, p);
    const Vec2 slope(
        (inside_at(inside_px, p + Vec2(1, 0)) - inside_at(inside_px, p - Vec2(1, 0))) / 2,
        (inside_at(inside_px, p + Vec2(0, 1)) - inside_at(inside_px, p - Vec2(0, 1))) / 2);
    const float steepness = slope.dot(slope);
    if (steepness < 0.05f) break;
    p -= slope * (here / steepness);
  }
  return p;
}

// Triangles with a corner inside, and the vertices they use, renumbered.
FaceMesh used_part(const GridMesh& grid, const Image1& inside_px) {
  FaceMesh mesh;
  std::vector<int> renamed(grid.vertices_mm.size(), -1);
  const auto inside = [&](int v) { return inside_px(grid.pixel[v]) > 0.f; };
  for (cv::Vec3i t : grid.triangles) {
    if (!inside(t[0]) && !inside(t[1]) && !inside(t[2])) continue;
    for (int& v : t.val) {
      if (renamed[v] < 0) {
        renamed[v] = int(mesh.pixel.size());
        mesh.pixel.emplace_back(float(grid.pixel[v].x), float(grid.pixel[v].y));
      }
      v = renamed[v];
    }
    mesh.triangles.push_back(t);
  }
  return mesh;
}

// The two neighbours of each border vertex along the border; -1 for the others, and for corners
// where two borders meet.
std::vector<cv::Vec2i> border_neighbours(const FaceMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (const cv::Vec3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++uses[std::minmax(t[k], t[(k + 1) % 3])];
  }
  std::vector<cv::Vec2i> neighbours(mesh.pixel.size(), cv::Vec2i(-1, -1));
  std::vector<int> count(mesh.pixel.size(), 0);
  for (const auto& [edge, n] : uses) {
    if (n != 1) continue;
    for (const auto& [v, w] : {edge, std::pair(edge.second, edge.first)}) {
      if (count[v] < 2) neighbours[v][count[v]] = w;
      ++count[v];
    }
  }
  for (size_t v = 0; v < count.size(); ++v) {
    if (count[v] != 2) neighbours[v] = {-1, -1};
  }
  return neighbours;
}

// Seen from the side, a pixel of the outline is many millimetres of depth: smooth it in space too.
void smooth_border(FaceMesh* mesh) {
  const std::vector<cv::Vec2i> neighbours = border_neighbours(*mesh);
  for (int pass = 0; pass < kBorderSmoothing; ++pass) {
    const std::vector<Vec3> x = mesh->vertices_mm;
    const std::vector<Vec2> p = mesh->pixel;
    for (size_t v = 0; v < x.size(); ++v) {
      const auto [a, b] = std::pair(neighbours[v][0], neighbours[v][1]);
      if (a < 0) continue;
      mesh->vertices_mm[v] = x[v] * 0.5f + (x[a] + x[b]) * 0.25f;
      mesh->pixel[v] = p[v] * 0.5f + (p[a] + p[b]) * 0.25f;
    }
  }
}

// Moving the border can turn a triangle there over, or leave nothing of it.
void drop_folded(FaceMesh* mesh) {
  const auto is_folded = [&](const cv::Vec3i& t) {
    const Vec2 &a = mesh->pixel[size_t(t[0])], &b = mesh->pixel[size_t(t[1])],
               &c = mesh->pixel[size_t(t[2])];
    const float up = (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1]);
    return up <= 1e-3f;
  };
  mesh->triangles.erase(std::remove_if(mesh->triangles.begin(), mesh->triangles.end(), is_folded),
                        mesh->triangles.end());
}

}  // namespace

bool is_inside(const Image1& inside_px, Vec2 pixel) { return inside_at(inside_px, pixel) > 0.f; }

FaceMesh mesh_face(const Image3& position_mm, const Image1& inside_px, int step) {
  // The cuts are in the outline; edges over the gaps that it keeps are wanted.
  const GridMesh grid = mesh_from_positions(position_mm, step, 1e9f);
  FaceMesh mesh = used_part(grid, inside_px);
  mesh.vertices_mm.reserve(mesh.pixel.size());
  for (Vec2& p : mesh.pixel) {
    if (!is_inside(inside_px, p)) p = on_outline(inside_px, p);
    mesh.vertices_mm.push_back(sample(position_mm, p));
  }
  smooth_border(&mesh);
  drop_folded(&mesh);
  return mesh;
}

}  // namespace lamella
