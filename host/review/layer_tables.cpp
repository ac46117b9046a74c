#include "review/layer_tables.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "base/fill.h"
#include "model/dipole.h"

namespace lamella::review {

namespace {

constexpr double kUnmeasuredWidth = 0.3;  // m: middle of the widths in the paper's section 5
constexpr int kWeightSidePx = 320;
constexpr float kBorderBlur = 0.012f;  // share of the width

double gaussian(double r_mm, double sigma_mm) {
  const double v = 2 * sigma_mm * sigma_mm;
  return std::exp(-r_mm * r_mm / v) / (M_PI * v);
}

std::vector<double> radii_mm(double ld_mm) {
  std::vector<double> r;
  for (double x = 0.02; x < 8.0 * ld_mm + 1.0; x *= 1.06) r.push_back(x);
  return r;
}

// Least squares with no negative share, one share at a time until nothing changes much.
cv::Vec4d non_negative(const cv::Matx44d& squares, const cv::Vec4d& products) {
  cv::Vec4d x(0, 0, 0, 0);
  for (int sweep = 0; sweep < 400; ++sweep) {
    for (int k = 0; k < 4; ++k) {
      double rest = products[k];
      for (int j = 0; j < 4; ++j) rest -= j == k ? 0.0 : squares(k, j) * x[j];
      x[k] = std::max(0.0, rest / squares(k, k));
    }
  }
  return x;
}

}  // namespace

cv::Vec4f gaussian_shares(double ld_mm, double alpha) {
  const model::Dipole<double> dipole{alpha, ld_mm};
  cv::Matx44d squares = cv::Matx44d::zeros();
  cv::Vec4d products(0, 0, 0, 0);
  double total = 0;
  for (double r : radii_mm(ld_mm)) {
    const double area = 2 * M_PI * r * 0.06 * r;  // of the ring, radii being 6 % apart
    const double wanted = model::dipole_reflectance(dipole, r);
    total += wanted * area;
    cv::Vec4d g;
    for (int k = 0; k < 4; ++k) g[k] = gaussian(r, double(kGaussianSigmaMm[size_t(k)]));
    // Weighed by r: what a profile adds to the picture is 2 pi r R.
    squares += (g * g.t()) * (area * r);
    products += g * (wanted * area * r);
  }
  const cv::Vec4d x = non_negative(squares, products / total);
  const double sum = x[0] + x[1] + x[2] + x[3];
  return sum > 0 ? cv::Vec4f(x / sum) : cv::Vec4f(1, 0, 0, 0);
}

cv::Mat4f kernel_table(const Vec3& alpha) {
  cv::Mat4f table(3, kLdCells);
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < kLdCells; ++i) {
      const double ld_mm = kLargestLdMm * (i + 0.5) / kLdCells;
      table(c, i) = gaussian_shares(ld_mm, double(alpha[c]));
    }
  }
  return table;
}

Vec3 typical_alpha(const FaceMaps& face) {
  Vec3 typical(0.9f, 0.8f, 0.7f);
  if (face.maps.deep_alpha.empty()) return typical;
  for (int c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (int y = 0; y < face.maps.deep_alpha.rows; y += 5) {
      for (int x = 0; x < face.maps.deep_alpha.cols; x += 5) {
        if (face.outline.inside_px(y, x) > 0) values.push_back(face.maps.deep_alpha(y, x)[c]);
      }
    }
    if (values.empty()) continue;
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    typical[c] = std::clamp(values[values.size() / 2], 0.05f, 0.995f);
  }
  return typical;
}

namespace {

model::LobeTable lobe_of(const v1::SpecularLobe& lobe) {
  if (lobe.theta_size() >= 2 && lobe.p_size() == lobe.theta_size()) {
    return {{lobe.theta().begin(), lobe.theta().end()}, {lobe.p().begin(), lobe.p().end()}};
  }
  const double m = lobe.has_gaussian_m() ? lobe.gaussian_m() : kUnmeasuredWidth;
  std::vector<double> theta, p;
  for (double t = 0; t <= M_PI / 4; t += 0.01) {
    theta.push_back(t);
    p.push_back(std::exp(-t * t / (m * m)));
  }
  return {theta, p};
}

double mean_intensity(const FaceMaps& face, int label) {
  if (face.maps.specular_intensity.empty()) return 0.25;
  const Mask here = (face.maps.regions == label) & (face.outline.inside_px > 0.f);
  return cv::countNonZero(here) > 0 ? cv::mean(face.maps.specular_intensity, here)[0] : 0.25;
}

}  // namespace

RegionTables region_tables(const FaceMaps& face, const v1::Layers& layers) {
  RegionTables tables;
  for (int i = 0; i < std::max(1, layers.regions_size()); ++i) {
    const bool named = i < layers.regions_size();
    tables.lobes.push_back(lobe_of(named ? layers.regions(i).specular() : v1::SpecularLobe()));
    tables.transmittance.emplace_back(tables.lobes.back(), mean_intensity(face, i + 1));
  }
  return tables;
}

std::vector<Image1> region_weights(const Labels& regions, int region_count) {
  const double scale = std::min(1.0, double(kWeightSidePx) / std::max(regions.cols, regions.rows));
  Labels small;
  cv::resize(regions, small, {}, scale, scale, cv::INTER_NEAREST);
  std::vector<Image1> planes;
  Image1 sum(small.size(), 0.f);
  for (int i = 0; i < region_count; ++i) {
    Image1 plane(small.size(), 0.f);
    plane.setTo(1.f, small == i + 1);
    plane.setTo(kNaN, small == 0);
    plane = fill_unknown(plane);
    cv::GaussianBlur(plane, plane, {}, 1.0 + kBorderBlur * small.cols);
    sum += plane;
    planes.push_back(plane);
  }
  if (cv::countNonZero(sum) == 0) planes[0].setTo(1.f);  // no labels: the first lobe everywhere
  for (Image1& plane : planes) cv::divide(plane, cv::max(sum, 1e-6f), plane);
  if (cv::countNonZero(sum) == 0) planes[0].setTo(1.f);
  return planes;
}

}  // namespace lamella::review
