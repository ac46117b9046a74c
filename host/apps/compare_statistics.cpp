#include "apps/compare_statistics.h"

#include <algorithm>
#include <numeric>

namespace lamella::apps {

namespace {

constexpr size_t kFewestPairs = 10;

double mean_of(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / double(v.size());
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double ma = mean_of(a), mb = mean_of(b);
  double ab = 0, aa = 0, bb = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : kNaN;
}

std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<int> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return values[a] < values[b]; });
  std::vector<double> rank(values.size());
  for (size_t i = 0; i < order.size();) {
    size_t end = i;
    while (end < order.size() && values[order[end]] == values[order[i]]) ++end;
    for (size_t k = i; k < end; ++k) rank[order[k]] = 0.5 * double(i + end - 1);
    i = end;
  }
  return rank;
}

}  // namespace

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return kNaN;
  const double at = share * double(values.size() - 1);
  const auto low = values.begin() + long(at);
  std::nth_element(values.begin(), low, values.end());
  if (low + 1 == values.end()) return *low;
  const double above = *std::min_element(low + 1, values.end());
  return *low + (at - std::floor(at)) * (above - *low);
}

double median(const std::vector<double>& values) { return percentile(values, 0.5); }

std::vector<double> finite(const std::vector<double>& values) {
  std::vector<double> kept;
  std::copy_if(values.begin(), values.end(), std::back_inserter(kept),
               [](double v) { return std::isfinite(v); });
  return kept;
}

Json error_statistics(const std::vector<double>& errors) {
  const std::vector<double> e = finite(errors);
  if (e.empty()) return nullptr;
  const double squares = std::inner_product(e.begin(), e.end(), e.begin(), 0.0);
  return {{"mean", mean_of(e)},
          {"median", median(e)},
          {"p95", percentile(e, 0.95)},
          {"rms", std::sqrt(squares / double(e.size()))}};
}

Json ratio_statistics(const std::vector<double>& found, const std::vector<double>& truth) {
  std::vector<double> a, b, ratio;
  double ab = 0, aa = 0, bb = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    if (!std::isfinite(found[i]) || !std::isfinite(truth[i])) continue;
    a.push_back(found[i]);
    b.push_back(truth[i]);
    ratio.push_back(truth[i] == 0 ? double(kNaN) : found[i] / truth[i]);
    ab += found[i] * truth[i];
    aa += found[i] * found[i];
    bb += truth[i] * truth[i];
  }
  if (a.size() < kFewestPairs) return nullptr;
  const double scale = ab / std::max(aa, 1e-30);
  double plain = 0, scaled = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    plain += (a[i] - b[i]) * (a[i] - b[i]);
    scaled += (scale * a[i] - b[i]) * (scale * a[i] - b[i]);
  }
  const bool all_ratios = finite(ratio).size() == ratio.size();
  return {{"rel_rmse", number(std::sqrt(plain / bb))},
          {"rel_rmse_best_scale", number(std::sqrt(scaled / bb))},
          {"corr", number(correlation(a, b))},
          {"median_ratio", all_ratios ? number(median(ratio)) : Json()}};
}

double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  return correlation(ranks(a), ranks(b));
}

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(double(length(cross(a, b))), double(dot(a, b))) * 180 / M_PI;
}

double RigidMotion::degrees() const {
  const double cosine = (cv::trace(rotation) - 1) / 2;
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI;
}

RigidMotion rigid_motion(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to) {
  Vec3d from_mean(0, 0, 0), to_mean(0, 0, 0);
  for (size_t i = 0; i < from.size(); ++i) {
    from_mean += from[i] * (1.0 / double(from.size()));
    to_mean += to[i] * (1.0 / double(from.size()));
  }
  Mat33d moments = Mat33d::zeros();
  for (size_t i = 0; i < from.size(); ++i) {
    moments += (from[i] - from_mean) * (to[i] - to_mean).t();
  }
  cv::Mat1d w, u, vt;
  cv::SVD::compute(cv::Mat1d(moments), w, u, vt);
  const Mat33d left(u), right(vt);
  const double turn = cv::determinant(right.t() * left.t()) < 0 ? -1 : 1;
  RigidMotion motion;
  motion.rotation = right.t() * Mat33d::diag(Vec3d(1, 1, turn)) * left.t();
  motion.shift = to_mean - motion.rotation * from_mean;
  return motion;
}

RigidMotion robust_rigid_motion(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to) {
  RigidMotion motion;
  for (int pass = 0; pass < 4; ++pass) {
    std::vector<double> residual(from.size());
    for (size_t i = 0; i < from.size(); ++i) residual[i] = cv::norm(motion(from[i]) - to[i]);
    const double limit = std::max(3 * median(residual), 1e-6);
    std::vector<Vec3d> near_from, near_to;
    for (size_t i = 0; i < from.size(); ++i) {
      if (residual[i] > limit) continue;
      near_from.push_back(from[i]);
      near_to.push_back(to[i]);
    }
    motion = rigid_motion(near_from, near_to);
  }
  return motion;
}

}  // namespace lamella::apps
