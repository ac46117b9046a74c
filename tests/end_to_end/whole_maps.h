// A fit's maps at the size of the photographs, as its files have them.
#pragma once

#include "fit/layers.h"

namespace lamella::testing {

template <class Image>
Image in_whole(const Image& map, const PixelWindow& window, const cv::Scalar& around) {
  if (map.empty()) return map;
  Image whole(window.whole);
  whole.setTo(around);
  map.copyTo(whole(window.area));
  return whole;
}

inline LayerMaps in_whole(LayerMaps maps) {
  const PixelWindow window = *maps.window;
  const cv::Scalar unknown = cv::Scalar::all(kNaN);
  for (Image3* map :
       {&maps.position_mm, &maps.normal_specular, &maps.normal_diffuse[0], &maps.normal_diffuse[1],
        &maps.normal_diffuse[2], &maps.single_albedo, &maps.total_albedo, &maps.shallow_albedo,
        &maps.deep_albedo, &maps.deep_alpha, &maps.deep_ld_mm}) {
    *map = in_whole(*map, window, unknown);
  }
  maps.specular_intensity = in_whole(maps.specular_intensity, window, unknown);
  for (auto& [name, map] : maps.stddev) map = in_whole(map, window, unknown);
  for (auto& [name, map] : maps.confidence) map = in_whole(map, window, cv::Scalar(0));
  maps.regions = in_whole(maps.regions, window, cv::Scalar(0));
  maps.window.reset();
  return maps;
}

}  // namespace lamella::testing
