// The figures by which two sets of numbers are compared. Not-known numbers (NaN) are left out; a
// figure that too few numbers are left for is null.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "base/vec.h"

namespace lamella::apps {

using Json = nlohmann::ordered_json;

// Numbers as JSON; not finite is null.
Json number(double value);

// Linear between the two nearest ranks; `share` from 0 to 1. NaN where there is nothing.
double percentile(std::vector<double> values, double share);
double median(const std::vector<double>& values);

// The finite ones among `values`.
std::vector<double> finite(const std::vector<double>& values);

// mean, median, p95, rms.
Json error_statistics(const std::vector<double>& errors);

// Of `found` against `truth`: rel_rmse (RMS error over RMS truth), the same after the best single
// factor on `found`, corr, median_ratio. Null under ten pairs.
Json ratio_statistics(const std::vector<double>& found, const std::vector<double>& truth);

// Rank correlation (Spearman), ties at their mean rank.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);

double degrees_between(const Vec3& a, const Vec3& b);

// The rotation and shift that bring `from` nearest to `to` in the least-squares sense (Kabsch).
struct RigidMotion {
  Mat33d rotation = Mat33d::eye();
  Vec3d shift{0, 0, 0};

  Vec3d operator()(const Vec3d& x) const { return rotation * x + shift; }
  double degrees() const;
};
RigidMotion rigid_motion(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to);

// The same, blind to outliers: refitted four times to the points within three times the median
// residual.
RigidMotion robust_rigid_motion(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to);

}  // namespace lamella::apps
