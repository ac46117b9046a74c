#include "twin/truth_writer.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/parallel.h"
#include "base/progress.h"
#include "io/json_tree.h"
#include "io/labels.h"
#include "io/view.h"
#include "io/whole_file.h"
#include "twin/npz.h"
#include "twin/patterns.h"
#include "twin/truth_maps.h"

namespace lamella::twin {

namespace {

using nlohmann::json;

json specular_truth(const Skin& skin) {
  std::vector<double> theta, p;
  for (int i = 0; i <= 90; ++i) {
    theta.push_back(i * CV_PI / 4 / 90);
    p.push_back(facet_density(float(std::cos(theta.back())), skin.roughness));
  }
  return {{"theta", theta}, {"p", p}, {"gaussian_m", gaussian_width(theta, p)}};
}

template <class Figure>
json per_channel(const Figure& figure) {
  return json::array({figure(0), figure(1), figure(2)});
}

// Which layers there are, where one is missing; without this all four are there.
json layers_truth(const Skin& skin) {
  json why = json::object();
  if (!skin.has_epidermis()) {
    why["shallow"] =
        "the skin is one layer, without an epidermis; what the stripes call shallow comes back "
        "from the dermis, near where it entered";
  }
  if (!skin.single_is_polarized) {
    why["single"] = "no light that is scattered once keeps its polarization";
  }
  return {{"specular", true},
          {"single", skin.single_is_polarized},
          {"shallow", skin.has_epidermis()},
          {"deep", true},
          {"why", why}};
}

// The epidermis as a medium of its own: reduced albedo and diffuse mean free path, which whoever
// reads of a layer that is there asks for.
void add_epidermis(const Skin& skin, json* shallow) {
  for (size_t c = 0; c < 3; ++c) {
    const double absorbed = double(skin.epidermis_absorption_per_mm[c]);
    const double extinct = absorbed + double(skin.epidermis_reduced_scattering_per_mm[c]);
    (*shallow)["alpha"].push_back(1 - absorbed / extinct);
    (*shallow)["ld_mm"].push_back(1 / std::sqrt(3 * absorbed * extinct));
  }
}

json region_json(const Photographer& photographer, size_t k, const RegionTruth& truth) {
  const Skin& skin = photographer.skins()[k];
  const auto& profiles = photographer.profiles()[k];
  json region;
  region["name"] = kRegionNames[k];
  region["specular"] = specular_truth(skin);
  region["deep"] = {{"ld_mm", per_channel([&](size_t c) { return truth.dipole[c].ld_mm; })},
                    {"alpha_dot", per_channel([&](size_t c) { return truth.dipole[c].alpha; })}};
  if (skin.has_epidermis()) region["shallow"] = {{"thickness_mm", skin.epidermis_mm}};
  region["single"] = {{"amplitude", per_channel([&](size_t c) {
                         const double g = kPhaseG[c];
                         return single_albedo(skin, int(c)) * (1 - g) / ((1 + g) * (1 + g));
                       })}};
  region["mc"] = {{"Rsingle", per_channel([&](size_t c) { return profiles[c].single_total; })},
                  {"Rshallow", per_channel([&](size_t c) { return profiles[c].shallow_total; })},
                  {"Rdeep", per_channel([&](size_t c) { return profiles[c].deep_total; })}};
  region["skin"] = {{"d", skin.epidermis_mm},
                    {"derm_mua", skin.dermis_absorption_per_mm},
                    {"derm_musp", skin.dermis_reduced_scattering_per_mm}};
  if (skin.has_epidermis()) {
    region["skin"]["epi_mua"] = skin.epidermis_absorption_per_mm;
    region["skin"]["epi_musp"] = skin.epidermis_reduced_scattering_per_mm;
  }
  const bool complete = skin.has_epidermis() && skin.single_is_polarized;
  if (complete) return region;
  region["layers"] = layers_truth(skin);
  if (skin.has_epidermis()) add_epidermis(skin, &region["shallow"]);
  return region;
}

void write_layers(const fs::path& file, const Photographer& photographer,
                  const std::array<RegionTruth, kRegionCount>& truth) {
  json layers;
  layers["format"] = "lamella.layers.v1";
  for (size_t k = 0; k < kRegionCount; ++k) {
    layers["regions"].push_back(region_json(photographer, k, truth[k]));
  }
  layers["single"] = {{"g", kPhaseG},
                      {"note", "alpha of eq. 3 as printed: scattering albedo / ior^2"}};
  layers["ior"] = kIor;
  const Vec3 drift = photographer.drift_mm();
  if (length(drift) > 0) layers["motion"] = {{"drift_mm", {drift[0], drift[1], drift[2]}}};
  if (!photographer.led_gains().empty()) layers["led_strengths"] = photographer.led_gains();
  write_whole_text(file, json_text(layers, 1));
}

void write_kernels(const fs::path& file, const SkinProfiles& profiles) {
  NpyArray r{"r", {Profile::kCount}, {}};
  for (int i = 0; i < Profile::kCount; ++i) r.values.push_back(Profile::radius_mm(i));
  NpyArray values{"R", {kRegionCount, 3, Profile::kCount}, {}};
  for (const auto& region : profiles) {
    for (const Profile& profile : region) {
      for (int i = 0; i < Profile::kCount; ++i) values.values.push_back(profile.at(i));
    }
  }
  write_npz(file, {r, values});
}

// ---- views ----

struct NamedView {
  std::string name;
  View view;
};

Camera turned_camera(const Photographer& photographer, double yaw_deg, double pitch_deg) {
  Camera c = photographer.rig().left;
  c.id.clear();
  const double yaw = yaw_deg * CV_PI / 180, pitch = pitch_deg * CV_PI / 180;
  const Mat33d facing(1, 0, 0, 0, -1, 0, 0, 0, -1);
  const Mat33d about_y(std::cos(yaw), 0, -std::sin(yaw), 0, 1, 0, std::sin(yaw), 0, std::cos(yaw));
  const Mat33d about_x(1, 0, 0, 0, std::cos(pitch), -std::sin(pitch), 0, std::sin(pitch),
                       std::cos(pitch));
  c.cam_from_rig = facing * about_x * about_y;
  return c;
}

// A point from the side, another camera, and a sky of LEDs.
std::vector<NamedView> views(const Photographer& photographer) {
  NamedView side{"point_side", {photographer.rig().left, {}}};
  side.view.lights.push_back({.kind = Light::Kind::kPoint, .position_mm = {700, 200, 700}});
  NamedView novel{"novel_view", {turned_camera(photographer, 30, 0), {}}};
  novel.view.lights.push_back({.kind = Light::Kind::kProjector});
  NamedView sky{"led_env", {turned_camera(photographer, 0, 8), {}}};
  Light leds{.kind = Light::Kind::kLeds};
  for (const Led& led : photographer.rig().stage.leds()) {
    const Vec3 w = led.direction;
    const float key = dot(w, unit({-0.6f, 0.35f, 0.7f})), rim = dot(w, unit({0.9f, 0.4f, -0.1f}));
    leds.weights.push_back((key > 0.8f ? 3.f : 0.f) + (rim > 0.85f ? 1.5f : 0.f));
  }
  sky.view.lights.push_back(leds);
  return {side, novel, sky};
}

Radiance radiance_of(const Photographer& photographer, const Receivers& r, const Light& light) {
  Radiance sum;
  PatchLight on_surface;
  if (light.kind == Light::Kind::kLeds) {
    on_surface = photographer.led_light(light.weights);
    sum = photographer.polarized_leds(r, light.weights);
  } else if (light.kind == Light::Kind::kPoint) {
    const PointLight point(photographer.surface(), light.position_mm);
    on_surface = photographer.point_light(point, light.radiance_at_origin);
    sum = photographer.polarized_point(r, point, light.radiance_at_origin);
  } else {
    const Image3 white = even_pattern(photographer.rig(), 1.f);
    on_surface = photographer.projector_light(white);
    sum = photographer.polarized_projector(r, white);
  }
  const Radiance d = photographer.depolarized(r, {&on_surface})[0];
  for (size_t i = 0; i < sum.size(); ++i) sum[i] += d[i];
  return sum;
}

// Does the left camera see this place of the subject?
bool seen_from_left(const Photographer& photographer, const Vec3& x, const Vec3& normal) {
  const Camera& left = photographer.rig().left;
  const Vec3 to_camera = Vec3(left.centre_mm()) - x;
  if (dot(normal, unit(to_camera)) <= 0.1f) return false;
  const cv::Vec2d pixel = left.project(Vec3d(x));
  const bool inside = pixel[0] > -0.5 && pixel[1] > -0.5 && pixel[0] < left.width - 0.5 &&
                      pixel[1] < left.height - 0.5;
  return inside && !photographer.surface().scene->occluded(x + normal * 0.2f, unit(to_camera), 0.f,
                                                           length(to_camera));
}

void write_one_view(const fs::path& folder, const Photographer& photographer,
                    const NamedView& named) {
  const Receivers r = photographer.see(named.view.camera);
  const Radiance radiance = radiance_of(photographer, r, named.view.lights[0]);
  Mask subject(r.height, r.width, uchar(0)), seen(r.height, r.width, uchar(0));
  parallel_for(
      int(r.size()),
      [&](int n) {
        const size_t i = size_t(n);
        const Vec3 x = r.targets.position_mm[i];
        if (!photographer.subject().labelled(x)) return;
        subject(r.pixel[i] / r.width, r.pixel[i] % r.width) = 255;
        const bool visible = seen_from_left(photographer, x, r.normal[i]);
        if (visible) seen(r.pixel[i] / r.width, r.pixel[i] % r.width) = 255;
      },
      1024);
  write_view(folder / (named.name + ".json"), named.view);
  write_exr_rgb(folder / (named.name + ".exr"), r.image(radiance, {0, 0, 0}), PixelType::kHalf);
  write_labels(folder / (named.name + "_mask.png"), subject);
  write_labels(folder / (named.name + "_mask_seen.png"), seen);
}

}  // namespace

void write_truth(const fs::path& folder, const Photographer& photographer) {
  const auto regions = region_truth(photographer.profiles());
  fs::create_directories(folder / "views");
  Progress progress("truth", 5);
  const TruthMaps truth = truth_maps(photographer, regions);
  progress.advance(1);
  write_layer_maps(folder, truth.maps);
  write_exr_rgb(folder / "shallow_albedo_physical.exr", truth.shallow_physical, PixelType::kHalf);
  write_exr_rgb(folder / "deep_albedo_physical.exr", truth.deep_physical, PixelType::kHalf);
  write_layers(folder / "layers.json", photographer, regions);
  write_kernels(folder / "kernels.npz", photographer.profiles());
  int done = 2;
  for (const NamedView& view : views(photographer)) {
    write_one_view(folder / "views", photographer, view);
    progress.advance(done++);
  }
}

}  // namespace lamella::twin
