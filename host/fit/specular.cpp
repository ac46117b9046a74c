#include "fit/specular.h"

#include "base/filled.h"
#include "base/parallel.h"
#include "fit/intensity.h"
#include "fit/lobe_fit.h"
#include "fit/phase_asymmetry.h"
#include "model/single_scattering.h"

namespace lamella::fit {

namespace {

// A few samples first, for what the samples themselves are computed with; then enough of them.
constexpr int kFirstShare = 4;

SkinModel skin_of(const RegionFit& fit, float g) {
  const model::LobeTable lobe(fit.lobe.theta_rad, fit.lobe.p);
  return {lobe, model::TransmittanceTable(lobe, fit.intensity), g};
}

std::vector<SkinModel> skins_of(const std::vector<RegionFit>& fits, float g) {
  std::vector<SkinModel> skins;
  for (const RegionFit& fit : fits) skins.push_back(skin_of(fit, g));
  return skins;
}

// alpha of eq. 3 from a region's amplitude, or from its deviation, on every pixel of it.
Image3 single_albedo_map(const Labels& regions, const SpecularFit& fit,
                         std::array<double, 3> RegionSingle::*amplitude) {
  std::vector<Vec3> alpha(1, Vec3(kNaN, kNaN, kNaN));
  for (const RegionSingle& single : fit.single) {
    Vec3 a;
    for (int c = 0; c < 3; ++c) {
      a[c] = float(model::alpha_from_amplitude((single.*amplitude)[size_t(c)], fit.g[size_t(c)]));
    }
    alpha.push_back(a);
  }
  Image3 map(regions.size());
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) map(y, x) = alpha[regions(y, x)];
  }
  return map;
}

// S as eq. 1 and 3 give it with everything fitted.
Image3 predicted(const Labels& regions, const SpecularFit& fit, const Image1& lobe,
                 const Image1& single) {
  auto s = filled<Image3>(regions.size(), Vec3(kNaN, kNaN, kNaN));
  parallel_for(s.rows, [&](int y) {
    for (int x = 0; x < s.cols; ++x) {
      if (!regions(y, x)) continue;
      const std::array<double, 3>& amplitude = fit.single[size_t(regions(y, x) - 1)].amplitude;
      for (int c = 0; c < 3; ++c) {
        s(y, x)[c] = fit.intensity(y, x) * lobe(y, x) + float(amplitude[size_t(c)]) * single(y, x);
      }
    }
  });
  return s;
}

}  // namespace

SpecularFit fit_specular(const Burst& burst, const Geometry& geometry, const Normals& normals) {
  const LightVisibility visibility(normals.around);
  std::vector<RegionFit> fits(burst.region_names.size() - 1, prior_region_fit());
  PhaseAsymmetry asymmetry;
  const int samples = burst.quality.lobe_samples;
  for (int samples_per_region : {samples / kFirstShare, samples}) {
    const std::vector<LobeSample> collected =
        collect_samples(burst, geometry, normals, visibility,
                        {skins_of(fits, asymmetry.mean_g()), samples_per_region});
    fits = fit_lobes(collected, fits, burst.quality.lobe_rounds);
    if (!burst.has_given_regions && fits.size() > 1) share_single(&fits);
    asymmetry = estimate_asymmetry(fits);
  }
  SpecularFit out;
  for (const RegionFit& fit : fits) {
    out.lobes.push_back(fit.lobe);
    out.single.push_back(fit.single);
  }
  out.g = asymmetry.g;
  out.g_stddev = asymmetry.g_stddev;
  out.g_assumes = asymmetry.assumes;
  const Responses responses =
      skin_responses(burst, geometry, normals, visibility, skins_of(fits, asymmetry.mean_g()));
  const IntensityMap intensity = estimate_intensity(burst, responses, fits);
  out.intensity = intensity.c;
  out.intensity_confidence = intensity.confidence;
  out.intensity_stddev = intensity.stddev;
  out.single_albedo = single_albedo_map(burst.regions, out, &RegionSingle::amplitude);
  out.single_stddev = single_albedo_map(burst.regions, out, &RegionSingle::amplitude_stddev);
  out.polarized_front = predicted(burst.regions, out, responses.front_lobe, responses.front_single);
  out.polarized_full = predicted(burst.regions, out, responses.led_lobe, responses.led_single);
  return out;
}

}  // namespace lamella::fit
