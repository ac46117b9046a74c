#include "review/layer_tables.h"

#include <algorithm>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "base/fill.h"
#include "base/parallel.h"
#include "model/dipole.h"
#include "model/multipole.h"

namespace lamella::review {

namespace {

constexpr double kUnmeasuredWidth = 0.3;  // m: middle of the widths in the paper's section 5
constexpr double kUsualSlabMm = 0.5;      // thickness of the epidermis in the paper's section 4.2
constexpr double kLocalSigmaMm = 0.1;     // less than what the picture of the skin resolves
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

using Profile = std::function<double(double r_mm)>;

constexpr int kMostShares = int(kGaussianSigmaMm.size()) + 1;
using Shares = cv::Vec<double, kMostShares>;

// Least squares with no negative share, one share at a time until nothing changes much.
Shares non_negative(const cv::Matx<double, kMostShares, kMostShares>& squares,
                    const Shares& products) {
  Shares x = Shares::all(0);
  for (int sweep = 0; sweep < 400; ++sweep) {
    for (int k = 0; k < kMostShares; ++k) {
      if (squares(k, k) <= 0) continue;
      double rest = products[k];
      for (int j = 0; j < kMostShares; ++j) rest -= j == k ? 0.0 : squares(k, j) * x[j];
      x[k] = std::max(0.0, rest / squares(k, k));
    }
  }
  return x;
}

// Of the Gaussians, and last of the light that does not spread: none of it where `local_sigma_mm`
// is 0, else as a Gaussian so narrow. Sum 1, or 0 where the profile has no light.
Shares shares_of(const Profile& profile, double ld_mm, double local_sigma_mm) {
  cv::Matx<double, kMostShares, kMostShares> squares = squares.zeros();
  Shares products = Shares::all(0);
  double total = 0;
  for (double r : radii_mm(ld_mm)) {
    const double area = 2 * M_PI * r * 0.06 * r;  // of the ring, radii being 6 % apart
    const double wanted = std::max(0.0, profile(r));
    total += wanted * area;
    Shares g = Shares::all(0);
    for (int k = 0; k + 1 < kMostShares; ++k) {
      g[k] = gaussian(r, double(kGaussianSigmaMm[size_t(k)]));
    }
    if (local_sigma_mm > 0) g[kMostShares - 1] = gaussian(r, local_sigma_mm);
    // Weighed by r: what a profile adds to the picture is 2 pi r R.
    squares += (g * g.t()) * (area * r);
    products += g * (wanted * area * r);
  }
  if (!(total > 0)) return Shares::all(0);
  const Shares x = non_negative(squares, products / total);
  const double sum = cv::sum(x)[0];
  return sum > 0 ? x / sum : Shares::all(0);
}

cv::Vec4f of_gaussians(const Shares& s) {
  return {float(s[0]), float(s[1]), float(s[2]), float(s[3])};
}

}  // namespace

cv::Vec4f gaussian_shares(double ld_mm, double alpha) {
  const model::Dipole<double> dipole{alpha, ld_mm};
  const Shares x =
      shares_of([&](double r) { return model::dipole_reflectance(dipole, r); }, ld_mm, 0);
  return cv::sum(x)[0] > 0 ? of_gaussians(x) : cv::Vec4f(1, 0, 0, 0);
}

cv::Vec4f shallow_shares(const v1::ShallowScattering& shallow, int channel) {
  if (shallow.ld_mm_size() != 3 || shallow.alpha_size() != 3) return {0, 0, 0, 0};
  const double ld_mm = shallow.ld_mm(channel), alpha = std::min(shallow.alpha(channel), 0.9999);
  if (!(ld_mm > 0 && alpha > 0)) return {0, 0, 0, 0};
  const double thickness_mm = shallow.has_thickness_mm() ? shallow.thickness_mm() : kUsualSlabMm;
  const model::Multipole<double> slab{alpha, ld_mm, thickness_mm};
  return of_gaussians(shares_of([&](double r) { return model::multipole_reflectance(slab, r); },
                                ld_mm, kLocalSigmaMm));
}

cv::Mat4f kernel_table(const Vec3& typical_alpha, const v1::Layers& layers) {
  const int regions = std::max(1, layers.regions_size());
  cv::Mat4f table(regions * kKernelRows, kLdCells);
  parallel_for(table.rows, [&](int row) {
    const int c = row % 3;
    const bool is_deep = row % kKernelRows < 3;
    const v1::Region* region =
        layers.regions_size() > 0 ? &layers.regions(row / kKernelRows) : nullptr;
    if (!is_deep) {
      table.row(row).setTo(region ? shallow_shares(region->shallow(), c) : cv::Vec4f());
      return;
    }
    const bool has_alpha = region && region->deep().alpha_dot_size() == 3;
    const double alpha = has_alpha ? region->deep().alpha_dot(c) : double(typical_alpha[c]);
    for (int i = 0; i < kLdCells; ++i) {
      const double ld_mm = kLargestLdMm * (i + 0.5) / kLdCells;
      table(row, i) = gaussian_shares(ld_mm, std::clamp(alpha, 0.01, 0.9999));
    }
  });
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
