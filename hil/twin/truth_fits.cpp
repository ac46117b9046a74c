#include "twin/truth_fits.h"

#include <algorithm>
#include <cmath>

namespace lamella::twin {

namespace {

constexpr double kInternal = 3.112;  // A of a dipole at ior 1.38

struct Samples {
  std::vector<double> r, log_density, weight;
};

Samples samples_of(const Profile& profile) {
  Samples s;
  double largest = 0;
  for (int i = 0; i < Profile::kCount; ++i) {
    const double r = Profile::radius_mm(i);
    if (r <= 1 || r >= 8 || i % 8 != 4) continue;
    const double density = profile.at(i);
    s.r.push_back(r);
    s.log_density.push_back(std::log(std::max(density, 1e-300)));
    s.weight.push_back(r * std::sqrt(density));
    largest = std::max(largest, s.weight.back());
  }
  for (double& w : s.weight) w /= largest;
  return s;
}

struct Parameters {
  double logit, log_ld;
  double alpha() const { return 1 / (1 + std::exp(-logit)); }
  double ld_mm() const { return std::exp(log_ld); }
};

double residual(const Samples& s, size_t i, const Parameters& q) {
  return s.weight[i] * (std::log(dipole(s.r[i], q.alpha(), q.ld_mm())) - s.log_density[i]);
}

double cost(const Samples& s, const Parameters& q) {
  double sum = 0;
  for (size_t i = 0; i < s.r.size(); ++i) sum += std::pow(residual(s, i, q), 2);
  return sum;
}

// One damped Gauss-Newton step from `q`.
Parameters step(const Samples& s, const Parameters& q, double damping) {
  constexpr double kDelta = 1e-5;
  double aa = 0, ab = 0, bb = 0, ga = 0, gb = 0;
  for (size_t i = 0; i < s.r.size(); ++i) {
    const double f = residual(s, i, q);
    const double a = (residual(s, i, {q.logit + kDelta, q.log_ld}) - f) / kDelta;
    const double b = (residual(s, i, {q.logit, q.log_ld + kDelta}) - f) / kDelta;
    aa += a * a, ab += a * b, bb += b * b, ga += a * f, gb += b * f;
  }
  aa *= 1 + damping, bb *= 1 + damping;
  const double det = aa * bb - ab * ab;
  if (!(det > 0)) return q;
  return {q.logit - (bb * ga - ab * gb) / det, q.log_ld - (aa * gb - ab * ga) / det};
}

}  // namespace

double dipole(double r_mm, double alpha, double ld_mm) {
  const double s = std::sqrt(3 * (1 - alpha)), sigma = 1 / ld_mm;
  const double zr = s * ld_mm, zv = zr * (1 + 4 * kInternal / 3);
  double sum = 0;
  for (double z : {zr, zv}) {
    const double d = std::hypot(r_mm, z);
    sum += z * (sigma + 1 / d) * std::exp(-sigma * d) / (d * d);
  }
  return alpha / (4 * M_PI) * sum;
}

DipoleFit nearest_dipole(const Profile& profile) {
  const Samples s = samples_of(profile);
  Parameters q{2.5, 0};
  double at = cost(s, q), damping = 1e-2;
  for (int i = 0; i < 100 && damping < 1e8; ++i) {
    const Parameters next = step(s, q, damping);
    const double there = cost(s, next);
    if (there < at) {
      const bool done = at - there < 1e-13 * at;
      q = next;
      at = there;
      damping *= 0.2;
      if (done) break;
    } else {
      damping *= 5;
    }
  }
  return {q.alpha(), q.ld_mm()};
}

double alpha_of_reflectance(double reflectance) {
  if (!(reflectance > 0 && reflectance < 1)) return std::nan("");
  double low = 0, high = std::sqrt(3.0);  // of s; the reflectance falls with it
  for (int i = 0; i < 60; ++i) {
    const double s = 0.5 * (low + high), alpha = 1 - s * s / 3;
    const double r = alpha / 2 * (1 + std::exp(-4.0 / 3 * kInternal * s)) * std::exp(-s);
    (r > reflectance ? low : high) = s;
  }
  return 1 - low * low / 3;
}

double gaussian_width(const std::vector<double>& theta, const std::vector<double>& p) {
  const auto error = [&](double m) {
    double gg = 0, gp = 0, pp = 0;
    for (size_t i = 0; i < theta.size(); ++i) {
      const double g = std::exp(-std::pow(theta[i] / m, 2));
      gg += g * g, gp += g * p[i], pp += p[i] * p[i];
    }
    return pp - gp * gp / gg;  // with the best a
  };
  double low = 0.03, high = 1.2;
  const double golden = 0.618033988749895;
  for (int i = 0; i < 60; ++i) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    (error(a) < error(b) ? high : low) = error(a) < error(b) ? b : a;
  }
  return 0.5 * (low + high);
}

}  // namespace lamella::twin
