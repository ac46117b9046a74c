#include "apps/bench_floor_steps.h"

#include <algorithm>

#include "base/error.h"
#include "base/parallel.h"
#include "fit/intensity.h"
#include "fit/pattern_extinction.h"
#include "fit/report.h"
#include "fit/specular_normals.h"

namespace lamella::apps {

namespace {

// Stereo, and stereo reconciled with normals.
void run_position(const KnownScene& scene, fit::LayeredFit* fit) {
  fit::Geometry geometry = fit::reconstruct_geometry(scene.burst);
  fit::merge_with_normals(scene.burst, scene.normals, &geometry);
  fit::report_geometry(scene.burst, geometry, fit);
}

void run_diffuse_normals(const KnownScene& scene, fit::LayeredFit* fit) {
  fit::report_normals(scene.estimated, fit);
}

void run_specular_normals(const KnownScene& scene, fit::LayeredFit* fit) {
  const Camera& camera = scene.burst.session->left;
  const Vec3 centre_mm(camera.centre_mm());
  const Image3& scene_mm = scene.geometry.scene_mm;
  Image1 distance_mm(scene_mm.size());
  parallel_for(scene_mm.rows, [&](int y) {
    for (int x = 0; x < scene_mm.cols; ++x) {
      distance_mm(y, x) = length(scene_mm(y, x) - centre_mm);
    }
  });
  fit::Normals normals = scene.normals;
  normals.specular = fit::add_specular_detail(
      scene.burst, fit::specular_moments(scene.burst, distance_mm),
      {scene.geometry.to_camera, distance_mm, float(camera.pixel_mm())}, scene.normals.diffuse[2]);
  fit::report_normals(normals, fit);
}

std::vector<fit::SkinModel> skin_models(const std::vector<fit::RegionFit>& fits, float g) {
  std::vector<fit::SkinModel> models;
  for (const fit::RegionFit& fit : fits) {
    const model::LobeTable lobe(fit.lobe.theta_rad, fit.lobe.p);
    models.push_back({lobe, model::TransmittanceTable(lobe, fit.intensity), g});
  }
  return models;
}

std::vector<fit::LobeSample> samples_of(const KnownScene& scene,
                                        const fit::LightVisibility& visibility,
                                        const fit::SamplingPlan& plan) {
  return fit::collect_samples(scene.burst, scene.geometry, scene.normals, visibility, plan);
}

// GRADIENT_FULL is there to tell c: as that is known, a photograph that shows it and nothing else.
void show_intensity_alone(const Truth& truth, std::vector<fit::LobeSample>* samples) {
  std::erase_if(*samples, [&](const fit::LobeSample& sample) {
    return !is_finite(truth.maps.specular_intensity(sample.pixel));
  });
  for (fit::LobeSample& sample : *samples) {
    sample.full = truth.maps.specular_intensity(sample.pixel);
    sample.full_variance = 0;
    sample.led_lobe.fill(1);
    sample.led_single = 0;
  }
}

// As the fit does it: a few samples first, for what the samples themselves are computed with.
void run_lobe(const KnownScene& scene, fit::LayeredFit* fit) {
  const fit::Quality& quality = scene.burst.quality;
  const fit::LightVisibility visibility(scene.normals.around);
  const float g = true_asymmetry(scene.truth);
  std::vector<fit::RegionFit> fits(scene.burst.region_names.size() - 1, fit::prior_region_fit());
  for (const int per_region : {quality.lobe_samples / 4, quality.lobe_samples}) {
    std::vector<fit::LobeSample> samples =
        samples_of(scene, visibility, {skin_models(fits, g), per_region});
    show_intensity_alone(scene.truth, &samples);
    fits = fit::fit_lobes(samples, fits, quality.lobe_rounds);
  }
  fit::SpecularFit specular;
  for (const fit::RegionFit& region : fits) {
    specular.lobes.push_back(region.lobe);
    specular.single.push_back(region.single);
  }
  fit::report_specular(specular, fit);
}

// A region's c is found from its samples here too, as the lobe's integral is known at each; twice,
// as light that the surface reflects does not enter the skin.
void run_intensity(const KnownScene& scene, fit::LayeredFit* fit) {
  const fit::LightVisibility visibility(scene.normals.around);
  std::vector<fit::RegionFit> skin = true_skin(scene.truth);
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<fit::SkinModel> models = skin_models(skin, true_asymmetry(scene.truth));
    const fit::Responses responses =
        fit::skin_responses(scene.burst, scene.geometry, scene.normals, visibility, models);
    std::vector<fit::LobeSample> samples =
        samples_of(scene, visibility, {models, scene.burst.quality.lobe_samples});
    for (fit::LobeSample& sample : samples) sample.led_lobe.fill(responses.led_lobe(sample.pixel));
    skin = fit::fit_lobes(samples, skin, 0);
    fit->maps.specular_intensity = fit::estimate_intensity(scene.burst, responses, skin).c;
  }
}

void run_separation(const KnownScene& scene, fit::LayeredFit* fit) {
  fit::report_separation(fit::separate_layers(scene.burst, scene.geometry, scene.normals), fit);
}

void run_scattering(const KnownScene& scene, fit::LayeredFit* fit) {
  fit::Separation separation = true_separation(scene.truth);
  const fit::Scattering scattering = fit::fit_scattering(scene.burst, scene.geometry, scene.normals,
                                                         fit::LayerUse::kAuto, &separation);
  fit::report_separation(separation, fit);
  fit::report_scattering(scattering, fit);
}

}  // namespace

KnownScene know_scene(const Session& session, const fs::path& truth) {
  KnownScene scene;
  scene.truth = read_truth(truth, session);
  scene.burst = fit::linearise(session);
  take_regions(scene.truth, &scene.burst);
  scene.geometry = true_geometry(scene.burst, scene.truth);
  fit::remove_pattern_extinction(scene.geometry, &scene.burst);
  fit::Geometry moved = scene.geometry;
  scene.estimated = fit::estimate_normals(scene.burst, &moved);
  scene.normals = true_normals(scene.estimated, scene.truth);
  return scene;
}

const std::vector<FloorStep>& floor_steps() {
  static const std::vector<FloorStep> steps{
      {{"position_median_mm", "position_rms_mm"}, "normals", run_position},
      {{"specular_normal_median_deg"}, "positions, diffuse normals", run_specular_normals},
      {{"diffuse_normal_median_deg"}, "positions", run_diffuse_normals},
      {{"c_rel_rmse"}, "positions, normals, lobes, single scattering", run_intensity},
      {{"gaussian_m_abs_error_rad", "p_l1", "single_rel_error"}, "positions, normals, c", run_lobe},
      {{"ld_rel_error", "profile_l1"},
       "positions, normals, shallow and deep albedo",
       run_scattering},
      {{"shallow_albedo_rel_rmse", "deep_albedo_rel_rmse"}, "positions, normals", run_separation}};
  return steps;
}

const FloorStep& step_of_figure(const std::string& figure) {
  for (const FloorStep& step : floor_steps()) {
    if (std::find(step.figures.begin(), step.figures.end(), figure) != step.figures.end()) {
      return step;
    }
  }
  throw_bad_input("--floor", "no step of the fit makes \"" + figure + "\"");
}

}  // namespace lamella::apps
