// What breaks a fit, case by case: one burst of a twin, spoilt, against the fit of the burst as it
// was.
#include "end_to_end/hard_case.h"

namespace lamella {
namespace {

TEST_F(HardCase, NotANumberInAPhotographNamesItsFile) {
  for (const float what : {kNaN, std::numeric_limits<float>::infinity()}) {
    SpoiltSession session = spoilt();
    std::string spoilt_file;
    session.change_photographs([&](Json& frame, Image3* image) {
      if (!session.is(frame, "STRIPES") || frame.value("index", 0) != 2) return;
      (*image)(20, 30)[1] = what;
      spoilt_file = frame["file"];
    });
    try {
      session.fitted();
      ADD_FAILURE() << "fitted";
    } catch (const std::exception& error) {
      EXPECT_NE(std::string(error.what()).find(fs::path(spoilt_file).filename()), std::string::npos)
          << error.what();
    }
  }
}

TEST_F(HardCase, AClippedHighlightIsNotMeasuredAndSpoilsNothingAround) {
  SpoiltSession session = spoilt();
  const cv::Size size = whole->maps.regions.size();
  const cv::Point middle(size.width / 2, size.height / 2);
  const float saturation = session.manifest["rig"]["cameras"][0]["saturation"];
  session.change_photographs([&](Json& frame, Image3* image) {
    if (frame["camera"] != "left" || frame["analyser"] != "PARALLEL") return;
    cv::circle(*image, middle, 5, cv::Scalar::all(saturation), cv::FILLED);
  });
  const fit::LayeredFit found = session.fitted();
  expect_numbers_where_confident(found.maps);
  // Its neighbourhood's, no surer than neighbours are alike.
  EXPECT_LE(found.maps.confidence.at("specular_intensity")(middle), 0.81f);
  EXPECT_NEAR(found.maps.specular_intensity(middle), whole->maps.specular_intensity(middle),
              0.5f * whole->maps.specular_intensity(middle));
  cv::Mat near = cv::Mat::zeros(size, CV_8U);
  cv::circle(near, middle, 14, 1, cv::FILLED);
  Image1 c = found.maps.specular_intensity.clone();
  c.setTo(kNaN, near);
  EXPECT_LT(difference(c, whole->maps.specular_intensity, 0.95), 0.05);
}

TEST_F(HardCase, RegionsOfAPixelAndOfALineAreAnsweredFromTheirNeighbours) {
  SpoiltSession session = spoilt();
  Labels regions = session.regions();
  const int middle = regions.rows / 2;
  auto& names = session.manifest["regions"]["names"];
  const uchar pixel = uchar(names.size()), line = uchar(names.size() + 1);
  names.push_back("speck");
  names.push_back("hair");
  regions(middle, regions.cols / 2) = pixel;
  for (int y = middle + 20; y < middle + 50; ++y) regions(y, regions.cols / 2 - 9) = line;
  session.set_regions(regions);
  const fit::LayeredFit found = session.fitted();
  expect_numbers_where_confident(found.maps);
  ASSERT_EQ(found.layers.regions_size(), whole->layers.regions_size() + 2);
  for (int r = found.layers.regions_size() - 2; r < found.layers.regions_size(); ++r) {
    const v1::Region& region = found.layers.regions(r);
    EXPECT_TRUE(std::isfinite(region.specular().gaussian_m())) << region.name();
    ASSERT_EQ(region.deep().ld_mm_size(), 3) << region.name();
    for (int c = 0; c < 3; ++c) {
      EXPECT_GT(region.deep().ld_mm(c), 0) << region.name();
      EXPECT_TRUE(std::isfinite(region.single().amplitude(c))) << region.name();
    }
  }
}

TEST_F(HardCase, WhereThePolarizedLightIsNegativeThereIsNoSpecularLayerAndTheOthersStay) {
  SpoiltSession session = spoilt();
  const cv::Size size = whole->maps.regions.size();
  const cv::Rect dull(size.width / 2 - 30, size.height / 2 - 12, 24, 24);
  std::map<std::string, Image3> cross;  // in the scale of the parallel photograph
  for (const char* role : {"GRADIENT_FULL", "GRADIENT_X", "GRADIENT_Y", "GRADIENT_Z", "FRONT"}) {
    cross[role] = session.photograph(role, "CROSS") *
                  (session.scale(role, "CROSS") / session.scale(role, "PARALLEL"));
  }
  session.change_photographs([&](Json& frame, Image3* image) {
    if (frame["camera"] != "left" || frame["analyser"] != "PARALLEL") return;
    Image3(cross.at(frame["role"]) * 0.99f)(dull).copyTo((*image)(dull));
  });
  const fit::LayeredFit found = session.fitted();
  expect_numbers_where_confident(found.maps);
  const cv::Rect inside(dull.tl() + cv::Point(4, 4), cv::Size(16, 16));
  for (const float c : found.maps.specular_intensity(inside)) EXPECT_LT(c, 0.05f);
  EXPECT_LT(difference(found.maps.deep_albedo(inside), whole->maps.deep_albedo(inside)), 0.03);
  EXPECT_LT(difference(found.maps.position_mm, whole->maps.position_mm), 0.01);
}

TEST_F(HardCase, SkinThatReflectsNothingInOnePlaceIsBlackThereAndNotElsewhere) {
  SpoiltSession session = spoilt();
  const cv::Size size = whole->maps.regions.size();
  const cv::Rect black(size.width / 2 - 8, size.height / 2 + 10, 16, 10);
  session.change_photographs([&](Json& frame, Image3* image) {
    if (frame["camera"] == "left") (*image)(black).setTo(0);
  });
  const fit::LayeredFit found = session.fitted();
  expect_numbers_where_confident(found.maps);
  for (const Vec3& albedo : found.maps.total_albedo(black)) {
    EXPECT_FALSE(albedo[1] > 0.02f) << "known, and not black";
  }
  Image3 total = found.maps.total_albedo.clone();
  total(black + cv::Size(16, 16) - cv::Point(8, 8)).setTo(kNaN);
  EXPECT_LT(difference(total, whole->maps.total_albedo, 0.9), 0.02);
}

TEST_F(HardCase, AThirdOfTheDotsStillGivesEveryRegionItsLength) {
  SpoiltSession session = spoilt();
  Image3 front = session.photograph("FRONT", "CROSS");
  session.change_photographs([&](Json& frame, Image3* image) {
    if (frame["camera"] != "left" || !session.is(frame, "DOTS")) return;
    const cv::Rect painted_over(0, 0, image->cols, image->rows * 2 / 3);
    front(painted_over).copyTo((*image)(painted_over));
  });
  const fit::LayeredFit found = session.fitted();
  expect_numbers_where_confident(found.maps);
  for (const v1::Region& region : found.layers.regions()) {
    ASSERT_EQ(region.deep().ld_mm_size(), 3) << region.name();
    for (int c = 0; c < 3; ++c) {
      EXPECT_GT(region.deep().ld_mm(c), 0) << region.name();
      EXPECT_GT(region.deep().ld_mm_stddev(c), 0) << region.name();
    }
  }
}

TEST_F(HardCase, ASubjectThatDriftsIsFittedWhereItIsOnAverage) {
  const SpoiltSession session(scratch->path() / "drifting");
  const fit::LayeredFit found = session.fitted();
  EXPECT_TRUE(found.layers.motion().mended()) << found.layers.motion().why();
  EXPECT_NEAR(found.layers.motion().moved_mm(), kDriftMm, 0.15 * kDriftMm);
  expect_numbers_where_confident(found.maps);
  const LayerMaps& rest = whole->maps;
  EXPECT_LT(difference(found.maps.position_mm, rest.position_mm, 0.5) * 100,
            0.1);  // mm of some 100
  EXPECT_LT(difference(found.maps.normal_diffuse[0], rest.normal_diffuse[0], 0.5), 0.005);
  EXPECT_LT(difference(found.maps.total_albedo, rest.total_albedo, 0.5), 0.02);
  EXPECT_LT(difference(found.maps.deep_ld_mm, rest.deep_ld_mm, 0.5), 0.03);
}

TEST_F(HardCase, AGradientThatIsTooBrightIsFoundAndMended) {
  SpoiltSession session = spoilt();
  session.change_photographs([&](Json& frame, Image3* image) {
    if (session.is(frame, "GRADIENT_X")) *image *= 1.05f;
  });
  const fit::LayeredFit found = session.fitted();
  EXPECT_FALSE(whole->layers.led_gains().mended());
  EXPECT_TRUE(found.layers.led_gains().mended());
  EXPECT_NEAR(found.layers.led_gains().gradient(0), 0.05, 0.005);
  const LayerMaps& rest = whole->maps;
  EXPECT_LT(difference(found.maps.normal_diffuse[0], rest.normal_diffuse[0], 0.5), 0.006);
  EXPECT_LT(difference(found.maps.normal_specular, rest.normal_specular, 0.5), 0.006);
}

TEST_F(HardCase, ASubjectAtRestIsLeftAsItIs) {
  EXPECT_FALSE(whole->layers.motion().mended());
  EXPECT_EQ(whole->layers.motion().frames_size(), 20);
}

TEST_F(HardCase, WithoutTheRightCameraLeftAndProjectorSuffice) {
  SpoiltSession session = spoilt();
  Json frames = Json::array();
  for (const Json& frame : session.manifest["frames"]) {
    if (frame["camera"] == "left") frames.push_back(frame);
  }
  session.manifest["frames"] = frames;
  session.manifest["rig"]["cameras"].erase(1);
  const fit::LayeredFit found = session.fitted();
  expect_numbers_where_confident(found.maps);
  EXPECT_GT(answered(found.maps.position_mm, found.maps.regions), 0.97);
  EXPECT_LT(difference(found.maps.position_mm, whole->maps.position_mm, 0.5), 0.002);
}

}  // namespace
}  // namespace lamella
