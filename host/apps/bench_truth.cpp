#include "apps/bench_truth.h"

#include "base/error.h"
#include "base/parallel.h"

namespace lamella::apps {

namespace {

constexpr float kKnownSigmaMm = 0.001f;  // of a true position: never 0, as weights are its inverse

void require_map(const cv::Mat& map, const fs::path& file, cv::Size expected) {
  if (map.empty())
    throw_bad_input(file.string(), "missing: no floor can be told without it",
                    "take the session of `lamella twin` again");
  if (map.size() == expected) return;
  throw_bad_input(file.string(),
                  size_words(map.size()) + " pixels, the left camera has " + size_words(expected),
                  "take the truth of the same session");
}

template <class Values>
std::vector<double> listed(const Values& values) {
  return {values.begin(), values.end()};
}

}  // namespace

Truth read_truth(const fs::path& folder, const Session& session) {
  if (!fs::exists(folder / "layers.json")) {
    throw_bad_input(folder.string(), "no truth to hold a fit against",
                    "take a session of `lamella twin`");
  }
  Truth truth{folder, read_layer_maps(folder), read_layers(folder / "layers.json")};
  const LayerMaps& maps = truth.maps;
  const cv::Size size(session.left.width, session.left.height);
  require_map(maps.position_mm, folder / "position.exr", size);
  require_map(maps.normal_diffuse[0], folder / "normal_diffuse.exr", size);
  require_map(maps.specular_intensity, folder / "specular_intensity.exr", size);
  require_map(maps.shallow_albedo, folder / "shallow_albedo.exr", size);
  require_map(maps.deep_albedo, folder / "deep_albedo.exr", size);
  for (uint8_t label : maps.regions) {
    if (label <= truth.layers.regions_size()) continue;
    throw_bad_input((folder / "regions.png").string(),
                    "label " + std::to_string(label) + " is no region of layers.json",
                    "take the truth of the same session");
  }
  return truth;
}

void take_regions(const Truth& truth, fit::Burst* burst) {
  burst->regions = truth.maps.regions;
  burst->region_names = {"background"};
  for (const v1::Region& region : truth.layers.regions()) {
    burst->region_names.push_back(region.name());
  }
}

fit::Geometry true_geometry(const fit::Burst& burst, const Truth& truth) {
  const Session& session = *burst.session;
  const Image3& position_mm = truth.maps.position_mm;
  const cv::Size size = position_mm.size();
  const Vec3 nowhere(kNaN, kNaN, kNaN);
  const Vec3d centre_mm = session.left.centre_mm();
  fit::Geometry g{Image3(size, nowhere),
                  Image1(size, kKnownSigmaMm),
                  Image2(size, Vec2(kNaN, kNaN)),
                  Image3(size, nowhere),
                  Image3(size, nowhere),
                  Image1(size, kNaN),
                  position_mm.clone(),
                  Mask(size, 0)};
  parallel_for(size.height, [&](int y) {
    for (int x = 0; x < size.width; ++x) {
      if (!burst.regions(y, x)) continue;
      g.to_camera(y, x) = Vec3(-session.left.ray(x, y));
      if (!is_finite(position_mm(y, x))) continue;
      const float mm = float(cv::norm(Vec3d(position_mm(y, x)) - centre_mm));
      fit::move_along_ray(session, {x, y}, mm, &g);
      g.measured(y, x) = 255;
    }
  });
  return g;
}

fit::Normals true_normals(const fit::Normals& estimated, const Truth& truth) {
  fit::Normals normals = estimated;
  normals.specular = truth.maps.normal_specular;
  normals.diffuse = truth.maps.normal_diffuse;
  return normals;
}

std::vector<fit::RegionFit> true_skin(const Truth& truth) {
  std::vector<fit::RegionFit> skin;
  for (const v1::Region& region : truth.layers.regions()) {
    fit::RegionFit fit = fit::prior_region_fit();
    if (region.specular().p_size() > 1 &&
        region.specular().p_size() == region.specular().theta_size()) {
      fit.lobe.theta_rad = listed(region.specular().theta());
      fit.lobe.p = listed(region.specular().p());
    }
    for (int c = 0; c < std::min(3, region.single().amplitude_size()); ++c) {
      fit.single.amplitude[size_t(c)] = region.single().amplitude(c);
    }
    skin.push_back(fit);
  }
  return skin;
}

float true_asymmetry(const Truth& truth) {
  const auto& g = truth.layers.single().g();
  double sum = 0;
  for (const double channel : g) sum += channel;
  return g.empty() ? fit::SkinModel().g : float(sum / g.size());
}

fit::Separation true_separation(const Truth& truth) {
  fit::Separation separation;
  separation.shallow_albedo = truth.maps.shallow_albedo.clone();
  separation.deep_albedo = truth.maps.deep_albedo.clone();
  separation.confidence = Image1(separation.deep_albedo.size(), 1.f);
  separation.deep_confidence = separation.confidence.clone();
  return separation;
}

}  // namespace lamella::apps
