#include "model/lobe.h"

#include <algorithm>
#include <cmath>

namespace lamella::model {

namespace {

constexpr double kPiD = 3.14159265358979323846;

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::upper_bound(x.begin(), x.end(), at);
  if (above == x.begin()) return y.front();
  if (above == x.end()) return y.back();
  const size_t i = size_t(above - x.begin());
  const double t = (at - x[i - 1]) / (x[i] - x[i - 1]);
  return y[i - 1] + t * (y[i] - y[i - 1]);
}

// 1/m^2 of the Gaussian that goes on where the table ends, from its last tenth.
double tail_steepness(const std::vector<double>& theta, const std::vector<double>& p) {
  const size_t last = theta.size() - 1;
  const size_t before = last - std::max<size_t>(1, last / 10);
  if (p[last] <= 0 || p[before] <= p[last]) return 1 / (0.3 * 0.3);
  const double squares = theta[last] * theta[last] - theta[before] * theta[before];
  return std::log(p[before] / p[last]) / squares;
}

// Best amplitude of exp(-(theta/m)^2) and the squared residual that it leaves.
double residual_of_width(const std::vector<double>& theta, const std::vector<double>& p, double m) {
  double ep = 0, ee = 0, pp = 0;
  for (size_t i = 0; i < theta.size(); ++i) {
    const double e = std::exp(-theta[i] * theta[i] / (m * m));
    ep += e * p[i];
    ee += e * e;
    pp += p[i] * p[i];
  }
  return pp - ep * ep / ee;
}

}  // namespace

LobeTable::LobeTable(const std::vector<double>& theta_rad, const std::vector<double>& p) {
  const double steepness = tail_steepness(theta_rad, p);
  const double end = theta_rad.back();
  double integral = 0;
  for (int i = 0; i <= kCells; ++i) {
    const double mu = 1 - double(i) / kCells;
    const double theta = std::acos(mu);
    cells_[size_t(i)] =
        float(theta <= end ? interpolate(theta_rad, p, theta)
                           : p.back() * std::exp(-steepness * (theta * theta - end * end)));
    // d(omega) = 2 pi d(cos theta): trapezoids in the cosine are exact for the interpolant.
    integral += (i == 0 || i == kCells ? 0.5 : 1.0) * cells_[size_t(i)] * mu;
  }
  integral *= 2 * kPiD / kCells;
  if (integral <= 0) return;
  for (float& cell : cells_) cell = float(cell / integral);
}

double beckmann(double cos_theta, double m) {
  if (cos_theta <= 0) return 0;
  const double c2 = cos_theta * cos_theta;
  const double tan2 = (1 - c2) / c2;
  return std::exp(-tan2 / (m * m)) / (kPiD * m * m * c2 * c2);
}

double gaussian_width(const std::vector<double>& theta_rad, const std::vector<double>& p) {
  // One dimension is left once the amplitude is solved for: golden section in log m.
  constexpr double kGolden = 0.6180339887498949;
  double low = std::log(0.01), high = std::log(3.0);
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double ra = residual_of_width(theta_rad, p, std::exp(a));
  double rb = residual_of_width(theta_rad, p, std::exp(b));
  while (high - low > 1e-7) {
    if (ra < rb) {
      high = b;
      b = a;
      rb = ra;
      a = high - kGolden * (high - low);
      ra = residual_of_width(theta_rad, p, std::exp(a));
    } else {
      low = a;
      a = b;
      ra = rb;
      b = low + kGolden * (high - low);
      rb = residual_of_width(theta_rad, p, std::exp(b));
    }
  }
  return std::exp((low + high) / 2);
}

double integral_over_table(const std::vector<double>& theta_rad, const std::vector<double>& p) {
  const auto weight = [&](size_t i) {
    return 2 * kPiD * p[i] * std::sin(theta_rad[i]) * std::cos(theta_rad[i]);
  };
  double sum = 0;
  for (size_t i = 1; i < theta_rad.size(); ++i) {
    sum += 0.5 * (weight(i - 1) + weight(i)) * (theta_rad[i] - theta_rad[i - 1]);
  }
  return sum;
}

}  // namespace lamella::model
