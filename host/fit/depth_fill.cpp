#include "fit/depth_fill.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr int kGrain = 256;  // holes that one processor fills at a time
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

  // Of the holes those that touch what is known, taken off.
  std::vector<cv::Point> first_ring(Mask* holes) const {
    std::vector<cv::Point> ring;
    for (int y = 0; y < holes->rows; ++y) {
      for (int x = 0; x < holes->cols; ++x) {
        if ((*holes)(y, x) && touches_known({x, y})) ring.emplace_back(x, y);
      }
    }
    for (const cv::Point& p : ring) (*holes)(p) = 0;
    return ring;
  }

  // Of the holes those that touch one of `filled`, taken off.
  std::vector<cv::Point> next_ring(const std::vector<cv::Point>& filled, Mask* holes) const {
    std::vector<cv::Point> ring;
    for (const cv::Point& p : filled) {
      for (const auto& [dy, dx] : kAround) {
        const cv::Point q = p + cv::Point(dx, dy);
        if (!is_inside(q) || !(*holes)(q)) continue;
        (*holes)(q) = 0;
        ring.push_back(q);
      }
    }
    return ring;
  }

  // Fills those of `holes`, each of which touches what is known.
  void fill_ring(const std::vector<cv::Point>& holes) {
    std::vector<Filled> ring(holes.size());
    parallel_for(
        int(holes.size()), [&](int i) { ring[size_t(i)] = from_neighbours(holes[size_t(i)]); },
        kGrain);
    for (const Filled& f : ring) {
      depth_.distance_mm(f.at) = f.distance_mm;
      depth_.sigma_mm(f.at) = f.sigma_mm;
    }
  }

 private:
  bool is_inside(const cv::Point& p) const {
    return cv::Rect({0, 0}, depth_.distance_mm.size()).contains(p);
  }

  bool touches_known(const cv::Point& p) const {
    return std::any_of(kAround.begin(), kAround.end(), [&](const std::array<int, 2>& step) {
      const cv::Point q = p + cv::Point(step[1], step[0]);
      return is_inside(q) && !std::isnan(depth_.distance_mm(q));
    });
  }

  // Neighbours on two sides of a silhouette do not agree: a gap is a shadow, and what lies in the
  // shadow is behind, so the furthest speak.
  Filled from_neighbours(const cv::Point& p) const {
    const Vec3 ray(camera_.ray(p.x, p.y));
    std::array<float, 8> mm, sigma;
    size_t count = 0;
    for (const auto& [dy, dx] : kAround) {
      const cv::Point q = p + cv::Point(dx, dy);
      if (!is_inside(q) || std::isnan(depth_.distance_mm(q))) continue;
      mm[count] = along_plane(p, ray, q);
      sigma[count++] = depth_.sigma_mm(q);
    }
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
  Mask holes = wanted & ~(depth->distance_mm == depth->distance_mm);
  std::vector<cv::Point> ring = filler.first_ring(&holes);
  while (!ring.empty()) {
    filler.fill_ring(ring);
    ring = filler.next_ring(ring, &holes);
  }
}

}  // namespace lamella::fit
