#include "io/doubtful.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

LayerMaps flat_maps() {
  LayerMaps maps;
  const cv::Size size(4, 4);
  maps.position_mm = maps.normal_specular = Image3(size, Vec3(0, 0, 1));
  maps.total_albedo = maps.shallow_albedo = maps.deep_albedo = Image3(size, Vec3(.3f, .2f, .1f));
  maps.specular_intensity = Image1(size, .25f);
  return maps;
}

TEST(Doubtful, MapsOfTheProjectorsLightAreUnknownInItsShadow) {
  LayerMaps maps = flat_maps();
  maps.confidence["position"] = Image1(4, 4, 1.f);
  maps.confidence["position"](1, 2) = 0.1f;
  const LayerMaps sure = without_doubtful(maps);
  EXPECT_FALSE(is_finite(sure.deep_albedo(1, 2)));
  EXPECT_FALSE(is_finite(sure.shallow_albedo(1, 2)));
  EXPECT_TRUE(is_finite(sure.deep_albedo(0, 0)));
  EXPECT_TRUE(is_finite(sure.total_albedo(1, 2)));  // the LEDs reach there
  EXPECT_TRUE(is_finite(maps.deep_albedo(1, 2)));   // what was read stays as it is
}

TEST(Doubtful, AMapIsUnknownWhereItSaysSo) {
  LayerMaps maps = flat_maps();
  maps.confidence["total_albedo"] = Image1(4, 4, 1.f);
  maps.confidence["total_albedo"](3, 3) = 0.f;
  const LayerMaps sure = without_doubtful(maps);
  EXPECT_FALSE(is_finite(sure.total_albedo(3, 3)));
  EXPECT_TRUE(is_finite(sure.deep_albedo(3, 3)));
}

TEST(Doubtful, NothingIsWhereNoConfidenceIsGiven) {
  const LayerMaps maps = flat_maps();
  EXPECT_EQ(cv::norm(without_doubtful(maps).deep_albedo, maps.deep_albedo, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace lamella
