// A fit made up from closed forms: a dome with two regions, as `fit` would write it.
#pragma once

#include <cmath>

#include "io/json.h"
#include "io/layer_maps.h"

namespace lamella::testing {

inline LayerMaps fake_maps(cv::Size size) {
  LayerMaps m;
  const Vec3 unknown(kNaN, kNaN, kNaN);
  m.position_mm = Image3(size, unknown);
  m.normal_specular = Image3(size, unknown);
  m.regions = Labels(size, uchar(0));
  const float radius_mm = 60, mm_per_pixel = 100.f / float(size.width);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float px = (float(x) - 0.5f * float(size.width)) * mm_per_pixel;
      const float py = (0.5f * float(size.height) - float(y)) * mm_per_pixel;
      const float squared = radius_mm * radius_mm - px * px - py * py;
      if (squared < 900) continue;
      m.position_mm(y, x) = Vec3(px, py, std::sqrt(squared));
      m.normal_specular(y, x) = unit(m.position_mm(y, x));
      m.regions(y, x) = py > -20 ? 1 : 2;
    }
  }
  for (Image3& normal : m.normal_diffuse) normal = m.normal_specular.clone();
  m.specular_intensity = Image1(size, 0.25f);
  m.single_albedo = Image3(size, Vec3(0.5f, 0.5f, 0.5f));
  m.shallow_albedo = Image3(size, Vec3(0.1f, 0.1f, 0.1f));
  m.deep_albedo = Image3(size, Vec3(0.4f, 0.3f, 0.2f));
  m.total_albedo = m.shallow_albedo + m.deep_albedo;
  m.deep_alpha = Image3(size, Vec3(0.9f, 0.8f, 0.7f));
  m.deep_ld_mm = Image3(size, Vec3(2.f, 1.f, 0.7f));
  return m;
}

inline v1::Layers fake_layers() {
  v1::Layers layers;
  layers.set_format("lamella.layers.v1");
  for (const char* name : {"skin", "lips"}) {
    v1::Region* region = layers.add_regions();
    region->set_name(name);
    for (double theta = 0; theta < 0.785; theta += 0.05) {
      region->mutable_specular()->add_theta(theta);
      region->mutable_specular()->add_p(3.5 * std::exp(-theta * theta / 0.09));
    }
    region->mutable_specular()->set_gaussian_m(0.3);
    for (double ld_mm : {2.0, 1.0, 0.7}) {
      region->mutable_deep()->add_ld_mm(ld_mm);
      region->mutable_deep()->add_alpha_dot(0.8);
      region->mutable_shallow()->add_ld_mm(0.5 * ld_mm);
      region->mutable_shallow()->add_alpha(0.9);
      region->mutable_single()->add_amplitude(0.06);
    }
    region->mutable_shallow()->set_thickness_mm(0.5);
    v1::LayerChoice* choice = region->mutable_layers();
    choice->set_specular(true);
    choice->set_single(true);
    choice->set_shallow(true);
    choice->set_deep(true);
  }
  layers.set_ior(1.38);
  return layers;
}

inline void write_fake_fit(const fs::path& folder, cv::Size size) {
  write_layer_maps(folder, fake_maps(size));
  write_json(folder / "layers.json", fake_layers());
}

}  // namespace lamella::testing
