#include "fit/depth_fill.h"

#include <algorithm>
#include <array>

#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr float kSigmaPerPxMm = 0.05f;
constexpr std::array<std::array<int, 2>, 8> kAround{
    {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {-1, 1}, {1, -1}, {1, 1}}};

struct Filled {
  cv::Point at;
  float distance_mm;
  float sigma_mm;
};

class Filler {
 public:
  Filler(const Camera& camera, const Image3& normal, DepthMap* depth)
      : camera_(camera), normal_(normal), depth_(*depth) {}

  std::vector<cv::Point> holes(const Mask& wanted) const {
    std::vector<cv::Point> found;
    for (int y = 0; y < wanted.rows; ++y) {
      for (int x = 0; x < wanted.cols; ++x) {
        if (wanted(y, x) && std::isnan(depth_.distance_mm(y, x))) found.emplace_back(x, y);
      }
    }
    return found;
  }

  // Fills the ring of holes that touch what is known; those that do not stay in `holes`.
  void fill_ring(std::vector<cv::Point>* holes) {
    std::vector<Filled> ring;
    std::vector<cv::Point> rest;
    for (const cv::Point& p : *holes) {
      const Filled f = from_neighbours(p);
      if (std::isnan(f.distance_mm)) {
        rest.push_back(p);
      } else {
        ring.push_back(f);
      }
    }
    for (const Filled& f : ring) {
      depth_.distance_mm(f.at) = f.distance_mm;
      depth_.sigma_mm(f.at) = f.sigma_mm;
    }
    holes->swap(rest);
  }

 private:
  // Neighbours on two sides of a silhouette do not agree: a gap is a shadow, and what lies in the
  // shadow is behind, so the furthest speak.
  Filled from_neighbours(const cv::Point& p) const {
    const cv::Rect inside(0, 0, depth_.distance_mm.cols, depth_.distance_mm.rows);
    const Vec3 ray(camera_.ray(p.x, p.y));
    std::array<float, 8> mm, sigma;
    size_t count = 0;
    for (const auto& [dy, dx] : kAround) {
      const cv::Point q = p + cv::Point(dx, dy);
      if (!inside.contains(q) || std::isnan(depth_.distance_mm(q))) continue;
      mm[count] = along_plane(p, ray, q);
      sigma[count++] = depth_.sigma_mm(q);
    }
    if (count == 0) return {p, kNaN, kNaN};
    const float furthest = *std::max_element(mm.begin(), mm.begin() + count);
    float sum = 0, sigma_sum = 0, speaking = 0;
    for (size_t k = 0; k < count; ++k) {
      if (furthest - mm[k] > silhouette_step_mm(1, depth_.px_mm)) continue;
      sum += mm[k];
      sigma_sum += sigma[k];
      ++speaking;
    }
    return {p, sum / speaking, std::max(kFilledSigmaMm, sigma_sum / speaking) + kSigmaPerPxMm};
  }

  // Where the ray of `p` meets the plane through the point of `q`.
  float along_plane(const cv::Point& p, const Vec3& ray, const cv::Point& q) const {
    const float known = depth_.distance_mm(q);
    const Vec3 other(camera_.ray(q.x, q.y));
    const Vec3 n = is_finite(normal_(p)) ? normal_(p) : -ray;
    const float facing = dot(n, ray);
    if (facing > -1e-3f) return known;
    const float limit = silhouette_step_mm(1, depth_.px_mm);
    return std::clamp(known * dot(n, other) / facing, known - limit, known + limit);
  }

  const Camera& camera_;
  const Image3& normal_;
  DepthMap& depth_;
};

}  // namespace

void fill_depth(const Camera& camera, const Mask& wanted, const Image3& normal, DepthMap* depth) {
  Filler filler(camera, normal, depth);
  std::vector<cv::Point> holes = filler.holes(wanted);
  for (size_t before = holes.size() + 1; !holes.empty() && holes.size() < before;) {
    before = holes.size();
    filler.fill_ring(&holes);
  }
}

}  // namespace lamella::fit
