#include "fit/bled_light.h"

#include <opencv2/imgproc.hpp>

#include "base/parallel.h"
#include "fit/order_statistics.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

constexpr float kDimShare = 0.5f;     // below it, light that came another way may tell
constexpr float kBrightShare = 0.7f;  // above it, it may not: there slope and brightness are held
constexpr int kBrightStepPx = 5;      // together
// Of the brightness that the slope has in the bright: what is outside is doubtful, and what is
// below the last faces away.
constexpr float kLeastOfSlope = 0.5f, kMostOfSlope = 1.6f, kAway = 0.2f;
constexpr int kDoubtfulNeighbours = 3;  // of nine, itself among them: one may be noise
constexpr int kAwayReachPx = 3;         // so near, what is doubtful has the same light
constexpr float kBledBias = 5;          // times that of skin that is lit as it should be
constexpr int kSlopeStepPx = 2;         // two neighbours further apart see a silhouette between

// The cosine between the measured surface and the projector.
class Facing {
 public:
  Facing(const Camera& camera, const Camera& projector, const DepthMap& depth)
      : camera_(camera),
        centre_mm_(camera.centre_mm()),
        projector_mm_(projector.centre_mm()),
        distance_mm_(depth.distance_mm),
        limit_mm_(silhouette_step_mm(kSlopeStepPx, depth.px_mm)) {}

  // NaN where a pixel has no neighbour in its row, or none in its column.
  float at(const cv::Point& p) const {
    if (std::isnan(distance_mm_(p))) return kNaN;
    const Vec3d normal = along(p, {0, 1}).cross(along(p, {1, 0}));
    const Vec3d light = projector_mm_ - point_mm(p);
    return float(normal.dot(light) / (cv::norm(normal) * cv::norm(light)));
  }

 private:
  Vec3d point_mm(const cv::Point& p) const {
    return centre_mm_ + camera_.ray(p.x, p.y) * double(distance_mm_(p));
  }

  // `p` itself where `q` is not on the same surface.
  cv::Point held(const cv::Point& q, const cv::Point& p) const {
    const bool inside = q.inside(cv::Rect(0, 0, distance_mm_.cols, distance_mm_.rows));
    return inside && std::abs(distance_mm_(q) - distance_mm_(p)) < limit_mm_ ? q : p;
  }

  Vec3d along(const cv::Point& p, const cv::Point& step) const {
    const cv::Point from = held(p - step, p), to = held(p + step, p);
    return from == to ? Vec3d(kNaN, kNaN, kNaN) : point_mm(to) - point_mm(from);
  }

  const Camera& camera_;
  Vec3d centre_mm_, projector_mm_;
  const Image1& distance_mm_;
  float limit_mm_;
};

// Cosine over brightness where nearly all light comes straight from the projector; NaN: nowhere.
float usual_slope(const Facing& facing, const Image1& share) {
  std::vector<float> slopes;
  for (int y = 0; y < share.rows; y += kBrightStepPx) {
    for (int x = 0; x < share.cols; x += kBrightStepPx) {
      if (share(y, x) < kBrightShare) continue;
      const float cosine = facing.at({x, y});
      if (!std::isnan(cosine)) slopes.push_back(cosine / share(y, x));
    }
  }
  return median_of(&slopes);
}

struct Judged {
  Mask doubtful, away;
};

Judged judge_slopes(const Facing& facing, const Image1& share) {
  const float usual = usual_slope(facing, share);
  Judged judged{Mask(share.size(), uchar(0)), Mask(share.size(), uchar(0))};
  parallel_for(share.rows, [&](int y) {
    for (int x = 0; x < share.cols; ++x) {
      if (!(share(y, x) < kDimShare)) continue;
      const float slope = facing.at({x, y}) / (usual * share(y, x));
      if (slope < kLeastOfSlope || slope > kMostOfSlope) judged.doubtful(y, x) = 255;
      if (slope < kAway) judged.away(y, x) = 255;
    }
  });
  return judged;
}

int neighbours_in(const Mask& mask, int y, int x) {
  int count = 0;
  for (int j = std::max(0, y - 1); j <= std::min(mask.rows - 1, y + 1); ++j) {
    for (int i = std::max(0, x - 1); i <= std::min(mask.cols - 1, x + 1); ++i) {
      count += mask(j, i) != 0;
    }
  }
  return count;
}

}  // namespace

Image1 projector_share(const Image3& front_lit, const Image3& led_lit, const Mask& subject) {
  Image1 share(front_lit.size(), 1.f);
  std::vector<float> of_subject;
  for (int y = 0; y < share.rows; ++y) {
    for (int x = 0; x < share.cols; ++x) {
      const float led = mean(led_lit(y, x));
      if (!(led > 0)) continue;
      share(y, x) = mean(front_lit(y, x)) / led;
      if (subject(y, x)) of_subject.push_back(share(y, x));
    }
  }
  const float middle = median_of(&of_subject);
  return middle > 0 ? Image1(share * (1 / middle)) : share;
}

void doubt_bled_light(const Camera& camera, const Camera& projector, const Image1& projector_share,
                      DepthMap* depth) {
  const Judged judged = judge_slopes(Facing(camera, projector, *depth), projector_share);
  Mask beside;
  cv::dilate(judged.away, beside, Mask::ones(2 * kAwayReachPx + 1, 2 * kAwayReachPx + 1));
  parallel_for(projector_share.rows, [&](int y) {
    for (int x = 0; x < projector_share.cols; ++x) {
      if (!(projector_share(y, x) < kDimShare)) continue;
      const bool doubtful = neighbours_in(judged.doubtful, y, x) >= kDoubtfulNeighbours;
      if (judged.away(y, x) || (doubtful && beside(y, x))) {
        depth->forget(y, x);
      } else if (doubtful) {
        depth->bias_mm(y, x) *= kBledBias;
      }
    }
  });
}

}  // namespace lamella::fit
