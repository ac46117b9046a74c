#include "fit/non_negative.h"

#include <cmath>
#include <vector>

namespace lamella::fit {

namespace {

constexpr double kMemberRidge =
    1e-10;  // of the scaled diagonal: keeps members that look alike apart

// The unconstrained solution over the free unknowns; zero for the others.
cv::Mat1d solve_free(const cv::Mat1d& m, const cv::Mat1d& b, const std::vector<bool>& free) {
  std::vector<int> index;
  for (int i = 0; i < m.rows; ++i) {
    if (free[size_t(i)]) index.push_back(i);
  }
  const int n = int(index.size());
  cv::Mat1d x(m.rows, 1, 0.0);
  if (n == 0) return x;
  cv::Mat1d sub(n, n), rhs(n, 1), solution;
  for (int i = 0; i < n; ++i) {
    rhs(i) = b(index[size_t(i)]);
    for (int j = 0; j < n; ++j) sub(i, j) = m(index[size_t(i)], index[size_t(j)]);
  }
  cv::solve(sub, rhs, solution, cv::DECOMP_CHOLESKY);
  for (int i = 0; i < n; ++i) x(index[size_t(i)]) = solution(i);
  return x;
}

// Moves from `x` towards `target` until the first bounded unknown meets zero, and fixes it there.
void step_to_bound(const cv::Mat1d& target, int bounded, cv::Mat1d* x, std::vector<bool>* free) {
  double step = 1;
  int met = -1;
  for (int i = 0; i < bounded; ++i) {
    if (!(*free)[size_t(i)] || target(i) > 0) continue;
    const double span = (*x)(i)-target(i);
    const double limit = span > 0 ? (*x)(i) / span : 0.0;
    if (met < 0 || limit < step) {
      step = limit;
      met = i;
    }
  }
  *x = *x + step * (target - *x);
  if (met >= 0) {
    (*x)(met) = 0;
    (*free)[size_t(met)] = false;
  }
}

bool feasible(const cv::Mat1d& x, int bounded, const std::vector<bool>& free) {
  for (int i = 0; i < bounded; ++i) {
    if (free[size_t(i)] && x(i) <= 0) return false;
  }
  return true;
}

// The fixed unknown that would lower the residual most if set free, or -1.
int steepest(const cv::Mat1d& gradient, int bounded, const std::vector<bool>& free) {
  int best = -1;
  double most = 1e-9;
  for (int i = 0; i < bounded; ++i) {
    if (!free[size_t(i)] && gradient(i) > most) {
      most = gradient(i);
      best = i;
    }
  }
  return best;
}

}  // namespace

cv::Mat1d solve_non_negative(const cv::Mat1d& m, const cv::Mat1d& b, int bounded) {
  const int n = m.rows;
  cv::Mat1d scale(n, 1), scaled(n, n), rhs(n, 1);
  for (int i = 0; i < n; ++i) scale(i) = m(i, i) > 0 ? 1 / std::sqrt(m(i, i)) : 0.0;
  for (int i = 0; i < n; ++i) {
    rhs(i) = b(i) * scale(i);
    for (int j = 0; j < n; ++j) scaled(i, j) = m(i, j) * scale(i) * scale(j);
    scaled(i, i) += scale(i) > 0 ? kMemberRidge : 1.0;
  }
  const double magnitude = std::max(1e-300, cv::norm(rhs));
  rhs /= magnitude;
  std::vector<bool> free(static_cast<size_t>(n), false);
  for (int i = bounded; i < n; ++i) free[size_t(i)] = true;
  cv::Mat1d x = solve_free(scaled, rhs, free);
  for (int iteration = 0; iteration < 10 * n; ++iteration) {
    const cv::Mat1d gradient = rhs - scaled * x;
    const int entering = steepest(gradient, bounded, free);
    if (entering < 0) break;
    free[size_t(entering)] = true;
    cv::Mat1d target = solve_free(scaled, rhs, free);
    while (!feasible(target, bounded, free)) {
      step_to_bound(target, bounded, &x, &free);
      target = solve_free(scaled, rhs, free);
    }
    x = target;
  }
  for (int i = 0; i < n; ++i) x(i) *= scale(i) * magnitude;
  return x;
}

}  // namespace lamella::fit
