// What the shaders look up: lobes and transmittance by region, diffusion as a sum of Gaussians.
#pragma once

#include <array>
#include <vector>

#include "io/face_maps.h"
#include "model/lobe.h"
#include "model/transmittance.h"

namespace lamella::review {

// Widths of the four Gaussians that stand for every kernel, mm on the skin. Wider ones are reached
// by blurring narrower ones again.
inline constexpr std::array<float, 4> kGaussianSigmaMm{0.25f, 0.75f, 1.9f, 4.5f};
inline constexpr float kLargestLdMm = 6.f;
inline constexpr int kLdCells = 96;

// Shares (sum 1, none negative) of the Gaussians in a dipole's kernel scaled to integrate to 1:
// least squares over the plane. `alpha`: reduced albedo, in (0, 1).
cv::Vec4f gaussian_shares(double ld_mm, double alpha);

// The same for a shallow layer's multipole, whose narrowest part is left out: what is missing to 1
// leaves where it enters. All 0 where the layer was not fitted.
cv::Vec4f shallow_shares(const v1::ShallowScattering& shallow, int channel);

// A region's rows: its deep kernel per channel, then its shallow kernel per channel. kLdCells
// columns: deep l_d from 0 to kLargestLdMm; a shallow kernel is the same in all of them.
// `typical_alpha` stands in for a region's alpha_dot.
inline constexpr int kKernelRows = 6;
cv::Mat4f kernel_table(const Vec3& typical_alpha, const v1::Layers& layers);

// Median over the face of the reduced albedo, per channel.
Vec3 typical_alpha(const FaceMaps& face);

struct RegionTables {
  std::vector<model::LobeTable> lobes;
  std::vector<model::TransmittanceTable> transmittance;
};

// A region without a lobe takes a Gaussian of the paper's middle width.
RegionTables region_tables(const FaceMaps& face, const v1::Layers& layers);

// How much of each region's lobe a pixel has: soft across borders, the nearest region where there
// is no label. One plane a region, planes sum to 1.
std::vector<Image1> region_weights(const Labels& regions, int region_count);

}  // namespace lamella::review
