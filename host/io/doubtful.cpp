#include "io/doubtful.h"

namespace lamella {

namespace {

constexpr float kLeastConfidence = 0.25f;

template <class Image>
void forget_where_doubtful(const LayerMaps& maps, const std::string& name, Image* map) {
  const auto confidence = maps.confidence.find(name);
  if (map->empty() || confidence == maps.confidence.end()) return;
  *map = map->clone();
  map->setTo(cv::Scalar::all(kNaN), confidence->second < kLeastConfidence);
}

}  // namespace

LayerMaps without_doubtful(const LayerMaps& maps) {
  LayerMaps sure = maps;
  forget_where_doubtful(maps, "normal_specular", &sure.normal_specular);
  forget_where_doubtful(maps, "total_albedo", &sure.total_albedo);
  forget_where_doubtful(maps, "single_albedo", &sure.single_albedo);
  for (const char* name : {"specular_intensity", "position"}) {
    forget_where_doubtful(maps, name, &sure.specular_intensity);
  }
  for (const char* name : {"shallow_albedo", "position"}) {
    forget_where_doubtful(maps, name, &sure.shallow_albedo);
  }
  for (const char* name : {"deep_albedo", "position"}) {
    forget_where_doubtful(maps, name, &sure.deep_albedo);
  }
  return sure;
}

}  // namespace lamella
