#include "fit/dot_pattern.h"

#include <cmath>

namespace lamella::fit {

namespace {

constexpr int kSide = BlurredDots::kSide;
constexpr float kLogOfNothing = -104;  // exp() is no float then, and slow to find that out

int wave_number(int i) { return i < kSide / 2 ? i : i - kSide; }

// Fourier coefficient of one disc of radius a in a unit cell: a J1(2 pi a k)/k.
double disc_wave(double radius, double k) {
  if (k == 0) return M_PI * radius * radius;
  return radius * std::cyl_bessel_j(1.0, 2 * M_PI * radius * k) / k;
}

// Of every wave of the grid, the square of its cycles per mm.
cv::Mat1f squared_waves(const PatternMetric& per_period) {
  cv::Mat1f f2(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double kx = wave_number(x), ky = wave_number(y);
      f2(y, x) =
          float(per_period[0] * kx * kx + 2 * per_period[1] * kx * ky + per_period[2] * ky * ky);
    }
  }
  return f2;
}

}  // namespace

void BlurredDots::look_up(float u, float v, Sample* sample) const {
  const float x = (u - std::floor(u)) * kSide, y = (v - std::floor(v)) * kSide;
  const int x0 = int(x) & (kSide - 1), y0 = int(y) & (kSide - 1);
  const int x1 = (x0 + 1) & (kSide - 1), y1 = (y0 + 1) & (kSide - 1);
  const float fx = x - std::floor(x), fy = y - std::floor(y);
  const Sample& a = samples_[size_t(y0 * kSide + x0)];
  const Sample& b = samples_[size_t(y0 * kSide + x1)];
  const Sample& c = samples_[size_t(y1 * kSide + x0)];
  const Sample& d = samples_[size_t(y1 * kSide + x1)];
  for (size_t j = 0; j < sample->size(); ++j) {
    (*sample)[j] = (a[j] + fx * (b[j] - a[j])) * (1 - fy) + (c[j] + fx * (d[j] - c[j])) * fy;
  }
}

DotPattern::DotPattern(const Patterns& patterns)
    : pitch_px_(patterns.dot_pitch_px), offset_px_(patterns.dot_offset_px), waves_(kSide, kSide) {
  const double radius = 0.5 * patterns.dot_diameter_px / pitch_px_;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      waves_(y, x) = float(-disc_wave(radius, std::hypot(wave_number(x), wave_number(y))));
    }
  }
  waves_(0, 0) += 1;
}

DotPattern::Place DotPattern::place(const Vec2& projector_px) const {
  const double u = (projector_px[0] - offset_px_[0]) / pitch_px_;
  const double v = (projector_px[1] - offset_px_[1]) / pitch_px_;
  const double column = std::round(u), row = std::round(v);
  return {int(column), int(row), float(u - column), float(v - row)};
}

BlurredDots DotPattern::blurred(const PatternMetric& metric) const {
  const cv::Mat1f f2 = squared_waves(metric / (pitch_px_ * pitch_px_));
  std::vector<BlurredDots::Sample> samples(size_t(kSide * kSide));
  cv::Mat_<cv::Vec2f> spectrum(kSide, kSide);
  cv::Mat1f cell;
  for (int j = 0; j < GaussianBasis::kSize; ++j) {
    const double sigma = GaussianBasis::sigma_mm(j);
    const float exponent = float(-2 * M_PI * M_PI * sigma * sigma);
    for (int i = 0; i < kSide * kSide; ++i) {
      const float log_share = exponent * f2(i / kSide, i % kSide);
      const float share = log_share > kLogOfNothing ? std::exp(log_share) : 0.f;
      spectrum(i / kSide, i % kSide) = {waves_(i / kSide, i % kSide) * share, 0.f};
    }
    cv::dft(spectrum, cell, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT);
    for (int i = 0; i < kSide * kSide; ++i) {
      samples[size_t(i)][size_t(j)] = cell(i / kSide, i % kSide);
    }
  }
  return BlurredDots(std::move(samples));
}

}  // namespace lamella::fit
