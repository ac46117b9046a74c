// The pixels that lobes and single scattering are fitted to, with everything about them that does
// not depend on what is fitted.
#pragma once

#include <array>
#include <vector>

#include "fit/led_response.h"
#include "fit/normals.h"

namespace lamella::fit {

// A lobe is a mixture of Beckmann lobes of these widths: positive, smooth, falling, even about the
// normal, with a tail, and normalised by closed form. Below the narrowest, neither the normals nor
// 150 lights resolve anything.
inline constexpr size_t kWidths = 10;
std::array<double, kWidths> mixture_widths();

// Values of the mixture's members against the cosine of the angle to the normal.
class MixtureTable {
 public:
  using Values = std::array<float, kWidths>;
  MixtureTable();
  Values operator()(float cos_theta) const;

 private:
  static constexpr int kCells = 1024;
  std::vector<Values> cells_;
};

struct SamplingPlan {
  std::vector<SkinModel> skins;  // what the samples are computed with, by label - 1
  int per_region = 0;
};

struct LobeSample {
  cv::Point pixel;
  uint8_t region = 0;               // label - 1
  uint8_t block = 0;                // of the jackknife
  float cos_h = 0;                  // n.h under the projector
  float front_lobe = 0;             // radiance under FRONT per c p(h)
  float front_single = 0;           // radiance under FRONT per amplitude
  MixtureTable::Values led_lobe{};  // radiance under GRADIENT_FULL per c, of each member
  float led_single = 0;             // radiance under GRADIENT_FULL per amplitude
  Vec3 front{0, 0, 0};              // S, measured
  float full = 0;                   // the same under GRADIENT_FULL, mean of channels and neighbours
  Vec3 front_variance{0, 0, 0};     // noise, without that of S itself
  float full_variance = 0;          // of `full`
  Vec3 diffuse_reflectance{0, 0, 0};  // under the projector
};

inline constexpr int kBlocks = 8;

// At most about `plan.per_region` of every region, spread evenly. Chosen by geometry, shadow and
// clipping alone, never by brightness.
std::vector<LobeSample> collect_samples(const Burst& burst, const Geometry& geometry,
                                        const Normals& normals, const LightVisibility& visibility,
                                        const SamplingPlan& plan);

}  // namespace lamella::fit
