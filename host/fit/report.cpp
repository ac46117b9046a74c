#include "fit/report.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/parallel.h"
#include "fit/mesh_depth.h"
#include "fit/motion_report.h"
#include "fit/unheld.h"

namespace lamella::fit {

namespace {

constexpr double kIor = 1.38;                      // of skin's top layer, Donner and Jensen 2006
constexpr float kSigmaAtHalfConfidence_mm = 0.1f;  // mm
constexpr double kLeastCoveredByMesh = 0.97;       // what every map of a fit must answer

using Values = google::protobuf::RepeatedField<double>;

template <class Sequence>
void put(Values* to, const Sequence& from) {
  to->Add(from.begin(), from.end());
}

struct Reason {
  const char* layer;
  const std::string& why;
  Doubt doubt;
};

void put_why(const Reason& reason, v1::Region* region, LayeredFit* fit) {
  if (reason.why.empty()) return;
  (*region->mutable_layers()->mutable_why())[reason.layer] = reason.why;
  if (reason.doubt == Doubt::kNone) return;
  fit->doubted.push_back({region->name(), reason.layer, reason.why, reason.doubt});
}

// 1 for a perfect measurement, 1/2 at the sigma above, 0 where there is none.
Image1 confidence_of(const Image1& sigma_mm) {
  Image1 confidence(sigma_mm.size(), 0.f);
  for (int y = 0; y < sigma_mm.rows; ++y) {
    for (int x = 0; x < sigma_mm.cols; ++x) {
      const float s = sigma_mm(y, x);
      if (is_finite(s)) confidence(y, x) = 1.f / (1.f + s / kSigmaAtHalfConfidence_mm);
    }
  }
  return confidence;
}

void put_confidence(const std::string& name, const Image1& confidence, LayeredFit* fit) {
  if (!confidence.empty()) fit->maps.confidence[name] = confidence;
}

void put_stddev(const std::string& map, const Image3& stddev, LayeredFit* fit) {
  if (stddev.empty()) return;
  std::vector<cv::Mat> planes;
  cv::split(stddev, planes);
  for (size_t c = 0; c < 3; ++c) fit->maps.stddev[map + "." + "RGB"[c]] = planes[c];
}

// Of the pixels of a map, 0 where one of its channels is no number.
void clear_unknown(const cv::Mat& map, Image1* confidence) {
  const int channels = map.channels();
  parallel_for(map.rows, [&](int y) {
    const float* value = map.ptr<float>(y);
    for (int x = 0; x < map.cols; ++x, value += channels) {
      const bool known = std::all_of(value, value + channels, [](float v) { return is_finite(v); });
      if (!known) (*confidence)(y, x) = 0;
    }
  });
}

void put_deep(const RegionScattering& from, v1::Region* region) {
  v1::DeepScattering* deep = region->mutable_deep();
  put(deep->mutable_ld_mm(), from.ld_mm);
  put(deep->mutable_ld_mm_stddev(), from.ld_mm_stddev);
  put(deep->mutable_alpha_dot(), from.alpha_dot);
  put(deep->mutable_alpha_dot_stddev(), from.alpha_dot_stddev);
  put(deep->mutable_rms(), from.deep_rms);
  deep->set_dots(unsigned(from.dots));
}

void put_shallow(const RegionScattering& from, v1::Region* region) {
  v1::ShallowScattering* shallow = region->mutable_shallow();
  put(shallow->mutable_alpha(), from.shallow_alpha);
  put(shallow->mutable_alpha_stddev(), from.shallow_alpha_stddev);
  put(shallow->mutable_ld_mm(), from.shallow_ld_mm);
  put(shallow->mutable_ld_mm_stddev(), from.shallow_ld_mm_stddev);
  put(shallow->mutable_rms(), from.shallow_rms);
  shallow->set_thickness_mm(from.thickness_mm);
}

void put_single_layer(const std::array<SingleLayer, 3>& from, v1::Region* region) {
  v1::SingleLayer* single = region->mutable_single_layer();
  for (const SingleLayer& channel : from) {
    single->add_ld_mm(channel.ld_mm);
    single->add_ld_mm_stddev(channel.ld_mm_stddev);
    single->add_alpha(channel.alpha);
    single->add_alpha_stddev(channel.alpha_stddev);
    single->add_rms(channel.rms);
  }
}

void put_led_gains(const LedGains& from, v1::LedGains* to) {
  to->set_why(from.why);
  if (!from.is_known) return;
  put(to->mutable_gradient(), from.gradient);
  put(to->mutable_gradient_stddev(), from.gradient_stddev);
  put(to->mutable_low_order(), from.low_order);
  put(to->mutable_low_order_stddev(), from.low_order_stddev);
  to->set_mended(from.is_mended);
}

// Also a line of the check, where a mesh is not all that it should be.
void report_source(const Burst& burst, const Mask& measured, LayeredFit* fit) {
  const Mask labelled = burst.regions > 0;
  const double covered =
      double(cv::countNonZero(measured & labelled)) / std::max(1, cv::countNonZero(labelled));
  v1::GeometrySource* source = fit->layers.mutable_geometry();
  source->set_covered(covered);
  if (!burst.mesh) {
    source->set_kind(burst.right_fringe.empty() ? v1::GeometrySource::LEFT_PROJECTOR
                                                : v1::GeometrySource::LEFT_RIGHT_PROJECTOR);
    return;
  }
  source->set_kind(v1::GeometrySource::MESH);
  source->set_triangles(uint32_t(burst.mesh->triangles.size()));
  source->set_sigma_mm(kMeshSigmaMm);
  if (covered >= kLeastCoveredByMesh) return;
  fit->check.lines.push_back(
      {Grade::kPoor, "mesh",
       fmt::format("the left camera sees it in {:.1f} % of labelled pixels, at least {:g} %",
                   100 * covered, 100 * kLeastCoveredByMesh),
       100 * covered, "%", 100 * kLeastCoveredByMesh});
}

void put_one_layer(const OneLayerVerdict& from, LayeredFit* fit) {
  if (from.why.empty()) return;
  v1::OneLayer* to = fit->layers.mutable_one_layer();
  to->set_found(from.is_one);
  to->set_why(from.why);
  if (!from.is_told) return;
  to->set_excess(from.excess);
  to->set_excess_stddev(from.excess_stddev);
}

}  // namespace

void start_report(const Burst& burst, LayeredFit* fit) {
  *fit->layers.mutable_quality() = message_from_quality(burst.quality);
  fit->layers.set_format("lamella.layers.v1");
  fit->layers.set_ior(kIor);
  (*fit->layers.mutable_checks())["projector_black_level"] = burst.black_level;
  *fit->layers.mutable_motion() = message_from_motion(burst.motion);
  for (CheckLine& line : judge_motion(burst.motion)) fit->check.lines.push_back(std::move(line));
  report_regions(burst, fit);
}

void report_regions(const Burst& burst, LayeredFit* fit) {
  fit->maps.regions = burst.regions;
  fit->layers.clear_regions();
  for (size_t i = 1; i < burst.region_names.size(); ++i) {
    fit->layers.add_regions()->set_name(burst.region_names[i]);
  }
}

void report_geometry(const Burst& burst, const Geometry& geometry, LayeredFit* fit) {
  report_source(burst, geometry.measured, fit);
  const Mask unheld = unheld_pixels(fit->maps.regions, geometry.measured);
  Image1 confidence = confidence_of(geometry.sigma_mm);
  fit->maps.position_mm = geometry.position_mm.clone();
  fit->maps.position_mm.setTo(cv::Scalar::all(kNaN), unheld);
  confidence.setTo(0, unheld);
  put_confidence("position", confidence, fit);
}

void report_normals(const Normals& normals, LayeredFit* fit) {
  put_led_gains(normals.led_gains, fit->layers.mutable_led_gains());
  fit->maps.normal_specular = normals.specular;
  fit->maps.normal_diffuse = normals.diffuse;
  put_confidence("normal_specular", normals.specular_confidence, fit);
  put_confidence("normal_diffuse", normals.diffuse_confidence, fit);
}

void report_specular(const SpecularFit& specular, LayeredFit* fit) {
  fit->maps.specular_intensity = specular.intensity;
  fit->maps.single_albedo = specular.single_albedo;
  put_confidence("specular_intensity", specular.intensity_confidence, fit);
  put_confidence("single_albedo", specular.intensity_confidence, fit);
  if (!specular.intensity_stddev.empty()) {
    fit->maps.stddev["specular_intensity"] = specular.intensity_stddev;
  }
  put_stddev("single_albedo", specular.single_stddev, fit);
  for (int i = 0; i < fit->layers.regions_size(); ++i) {
    v1::Region* region = fit->layers.mutable_regions(i);
    v1::LayerChoice* choice = region->mutable_layers();
    const RegionLobe& lobe = specular.lobes[size_t(i)];
    choice->set_specular(lobe.fitted);
    put_why({"specular", lobe.why, lobe.doubt}, region, fit);
    if (!lobe.theta_rad.empty()) {
      v1::SpecularLobe* out = region->mutable_specular();
      put(out->mutable_theta(), lobe.theta_rad);
      put(out->mutable_p(), lobe.p);
      put(out->mutable_p_stddev(), lobe.p_stddev);
      out->set_gaussian_m(lobe.gaussian_m);
      out->set_gaussian_m_stddev(lobe.gaussian_m_stddev);
    }
    const RegionSingle& single = specular.single[size_t(i)];
    choice->set_single(single.fitted);
    put_why({"single", single.why, single.doubt}, region, fit);
    put(region->mutable_single()->mutable_amplitude(), single.amplitude);
    put(region->mutable_single()->mutable_amplitude_stddev(), single.amplitude_stddev);
  }
  v1::SingleGlobal* global = fit->layers.mutable_single();
  put(global->mutable_g(), specular.g);
  put(global->mutable_g_stddev(), specular.g_stddev);
  global->set_g_assumes(specular.g_assumes);
}

void report_separation(const Separation& separation, LayeredFit* fit) {
  fit->maps.shallow_albedo = separation.shallow_albedo;
  fit->maps.deep_albedo = separation.deep_albedo;
  put_confidence("shallow_albedo", separation.confidence, fit);
  put_confidence("deep_albedo", separation.deep_confidence, fit);
  put_stddev("shallow_albedo", separation.shallow_stddev, fit);
  put_stddev("deep_albedo", separation.deep_stddev, fit);
  (*fit->layers.mutable_checks())["separation_closure_rms"] = separation.closure_rms;
}

void report_scattering(const Scattering& scattering, LayeredFit* fit) {
  fit->maps.deep_ld_mm = scattering.deep_ld_mm;
  fit->maps.deep_alpha = scattering.deep_alpha;
  const auto deep = fit->maps.confidence.find("deep_albedo");
  if (deep != fit->maps.confidence.end()) put_confidence("deep_alpha", deep->second, fit);
  put_confidence("deep_ld", scattering.ld_confidence, fit);
  put_one_layer(scattering.one_layer, fit);
  for (int i = 0; i < fit->layers.regions_size(); ++i) {
    v1::Region* region = fit->layers.mutable_regions(i);
    const RegionScattering& from = scattering.regions[size_t(i)];
    v1::LayerChoice* choice = region->mutable_layers();
    choice->set_deep(from.deep_fitted);
    choice->set_shallow(from.shallow_fitted);
    put_why({"deep", from.deep_why, from.deep_doubt}, region, fit);
    put_why({"shallow", from.shallow_why, from.shallow_doubt}, region, fit);
    if (from.ld_mm[0] > 0) put_deep(from, region);
    if (from.shallow_ld_mm[0] > 0) put_shallow(from, region);
    if (from.single_layer[0].ld_mm > 0) put_single_layer(from.single_layer, region);
  }
}

void report_albedo(const Albedo& albedo, LayeredFit* fit) {
  fit->maps.total_albedo = albedo.total;
  put_confidence("total_albedo", albedo.confidence, fit);
}

void report_rerender(const RerenderResiduals& residuals, LayeredFit* fit) {
  const std::pair<const char*, double> named[] = {
      {"rerender_front_parallel_rms", residuals.front_parallel},
      {"rerender_front_cross_rms", residuals.front_cross},
      {"rerender_full_parallel_rms", residuals.full_parallel},
      {"rerender_full_cross_rms", residuals.full_cross}};
  for (const auto& [name, residual] : named) {
    if (std::isfinite(residual)) (*fit->layers.mutable_checks())[name] = residual;
  }
}

void settle_confidence(LayerMaps* maps) {
  for (auto& [name, confidence] : maps->confidence) confidence = confidence.clone();  // maps share
  for (const auto& [name, map] : named_maps(*maps)) {
    const auto confidence = maps->confidence.find(name);
    if (confidence != maps->confidence.end()) clear_unknown(map, &confidence->second);
  }
}

}  // namespace lamella::fit
