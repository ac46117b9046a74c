#include "fit/stereo.h"

#include <algorithm>
#include <vector>

#include "base/parallel.h"
#include "fit/order_statistics.h"
#include "fit/smooth.h"
#include "fit/triangulate.h"

namespace lamella::fit {

namespace {

constexpr int kMostRounds = 4;
constexpr double kSettledMm = 5e-4;
constexpr double kLeastSlope = 0.1;    // px per mm: below it a column says little of the distance
constexpr double kSeenThroughMm = 3;   // what the right camera sees behind a point denies it
constexpr double kDisagreementMm = 1;  // beyond the noise, between the pair and the projector
constexpr double kDoubt = 0.2;         // share of the disagreement that stays in the answer
constexpr int kApartStep_px = 3;       // how far cameras are apart is looked at in every third row

// Column and distance in the right image between pixels; NaN at silhouettes and holes.
struct DepthSample {
  double u_px = std::nan(""), distance_mm = std::nan(""), sigma_mm = 0;
};

DepthSample sample(const DepthMap& map, const cv::Vec2d& at) {
  const int x = int(std::floor(at[0])), y = int(std::floor(at[1]));
  if (!(at[0] >= 0 && at[1] >= 0) || x + 1 >= map.u_px.cols || y + 1 >= map.u_px.rows) return {};
  const double fx = at[0] - x, fy = at[1] - y;
  const auto mix = [&](const Image1& m) {
    return (m(y, x) * (1 - fx) + m(y, x + 1) * fx) * (1 - fy) +
           (m(y + 1, x) * (1 - fx) + m(y + 1, x + 1) * fx) * fy;
  };
  const Image1& d = map.distance_mm;
  const auto [low, high] = std::minmax({d(y, x), d(y, x + 1), d(y + 1, x), d(y + 1, x + 1)});
  if (!(high - low < silhouette_step_mm(2, map.px_mm))) return {};
  return {mix(map.u_px), mix(d), map.sigma_mm(y, x)};
}

struct Match {
  enum { kNone, kDenied, kFound } verdict = kNone;
  double distance_mm = 0;
  double u_px_per_mm = 0;  // how fast the columns drift apart along the left ray
  double px_per_mm = 0;    // and the point in the right image
};

double sigma_alone_mm(const DepthMap& depth, int y, int x) {
  return cv::norm(cv::Vec2d(depth.sigma_mm(y, x), depth.bias_mm(y, x)));
}

// How fast the right image's column at a point changes as it moves along the left ray, per mm.
double column_slope(const DepthMap& right, const Sighting& s) {
  const double px_per_mm = cv::norm(s.px_per_mm);
  const cv::Vec2d step = s.px_per_mm * (1 / px_per_mm);
  return (sample(right, s.pixel + step).u_px - sample(right, s.pixel - step).u_px) * 0.5 *
         px_per_mm;
}

// Newton's method for the distance at which both cameras see the same column, with the slope where
// it starts: it hardly changes on the way.
Match match(const Ray& ray, double start_mm, double u_px, const Camera& camera,
            const DepthMap& right) {
  const Vec3d centre = camera.centre_mm();
  Match m;
  m.distance_mm = start_mm;
  for (int round = 0; round < kMostRounds; ++round) {
    const Vec3d point = ray.at(m.distance_mm);
    const Sighting s =
        round == 0 ? sight(camera, point, ray.direction) : Sighting{camera.project(point), {}};
    const DepthSample here = sample(right, s.pixel);
    const double behind_mm = here.distance_mm - cv::norm(point - centre);
    if (round == 0 && behind_mm > kSeenThroughMm) m.verdict = Match::kDenied;
    if (!(std::abs(behind_mm) < kSeenThroughMm)) return m;
    if (round == 0) {
      m.u_px_per_mm = column_slope(right, s);
      m.px_per_mm = s.px_per_mm[0];
    }
    if (!(std::abs(m.u_px_per_mm) > kLeastSlope)) return m;
    const double off_mm = (here.u_px - u_px) / m.u_px_per_mm;
    m.distance_mm -= off_mm;
    if (std::abs(off_mm) < kSettledMm) break;
  }
  m.verdict = std::isnan(m.distance_mm) ? Match::kNone : Match::kFound;
  return m;
}

// What a row of points says of both cameras.
struct WordOfRow {
  int points = 0, agreed = 0;
  std::vector<float> apart_px;
};

Agreement agreement_of(const std::vector<WordOfRow>& rows) {
  WordOfRow all;
  for (const WordOfRow& row : rows) {
    all.points += row.points;
    all.agreed += row.agreed;
    all.apart_px.insert(all.apart_px.end(), row.apart_px.begin(), row.apart_px.end());
  }
  Agreement agreement{double(all.agreed) / std::max(1, all.points)};
  if (!all.apart_px.empty()) agreement.apart_px = double(median_of(&all.apart_px));
  return agreement;
}

}  // namespace

Agreement refine_with_right(const Camera& left_camera, const Camera& right_camera,
                            const Camera& projector, const DepthMap& right, DepthMap* left) {
  const Vec3d centre = left_camera.centre_mm();
  std::vector<WordOfRow> rows(size_t(left->distance_mm.rows));
  parallel_for(left->distance_mm.rows, [&](int y) {
    WordOfRow& word = rows[size_t(y)];
    for (int x = 0; x < left->distance_mm.cols; ++x) {
      float& mm = left->distance_mm(y, x);
      if (std::isnan(mm)) continue;
      ++word.points;
      const Ray ray{centre, left_camera.ray(x, y)};
      const Match m = match(ray, mm, left->u_px(y, x), right_camera, right);
      if (m.verdict == Match::kDenied) {
        left->forget(y, x);
        continue;
      }
      const double alone = sigma_alone_mm(*left, y, x);
      if (m.verdict == Match::kNone) {
        left->sigma_mm(y, x) = float(alone);
        continue;
      }
      const double per_mm = std::abs(sight(projector, ray.at(mm), ray.direction).px_per_mm[0]);
      const double sigma_u_px = left->sigma_mm(y, x) * per_mm;
      const double pair = std::sqrt(2.) * sigma_u_px / std::abs(m.u_px_per_mm);
      const double apart = m.distance_mm - mm;
      const double doubt = kDoubt * apart;
      if (y % kApartStep_px == 0) word.apart_px.push_back(float(apart * m.px_per_mm));
      if (std::abs(apart) > kDisagreementMm + 3 * (alone + pair)) {
        left->sigma_mm(y, x) = float(cv::norm(cv::Vec2d(alone, doubt)));
        continue;
      }
      ++word.agreed;
      const double w = alone * alone / (alone * alone + pair * pair);
      mm += float(w * apart);
      left->sigma_mm(y, x) = float(cv::norm(cv::Vec2d(std::sqrt(w) * pair, doubt)));
    }
  });
  return agreement_of(rows);
}

void believe_alone(DepthMap* depth) {
  parallel_for(depth->distance_mm.rows, [&](int y) {
    for (int x = 0; x < depth->distance_mm.cols; ++x) {
      if (std::isnan(depth->distance_mm(y, x))) continue;
      depth->sigma_mm(y, x) = float(sigma_alone_mm(*depth, y, x));
    }
  });
}

}  // namespace lamella::fit
