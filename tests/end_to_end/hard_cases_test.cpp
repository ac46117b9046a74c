// What breaks a fit, case by case: one burst of a twin, spoilt or seen otherwise, against the fit
// of the burst as it was.
#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "fit/layers.h"
#include "io/exr.h"
#include "io/fake_session.h"
#include "io/labels.h"
#include "io/whole_file.h"
#include "twin/session_writer.h"
#include "twin/truth_writer.h"

namespace lamella {
namespace {

using Json = nlohmann::json;

// A session's folder, to be changed and fitted.
class SpoiltSession {
 public:
  explicit SpoiltSession(const fs::path& original) : folder_(scratch_.path() / "session") {
    fs::copy(original, folder_, fs::copy_options::recursive);
    std::ifstream(folder_ / "session.json") >> manifest;
  }

  Json manifest;

  bool is(const Json& frame, const std::string& role, const std::string& analyser = "") const {
    return frame["role"] == role && (analyser.empty() || frame["analyser"] == analyser);
  }

  Image3 photograph(const Json& frame) const { return read_exr_rgb(folder_ / frame["file"]); }
  Image3 photograph(const std::string& role, const std::string& analyser) const {
    for (const Json& frame : manifest["frames"]) {
      if (frame["camera"] == "left" && is(frame, role, analyser)) return photograph(frame);
    }
    ADD_FAILURE() << "no " << role;
    return {};
  }

  double scale(const std::string& role, const std::string& analyser) const {
    for (const Json& frame : manifest["frames"]) {
      if (frame["camera"] == "left" && is(frame, role, analyser)) return frame["radiance_scale"][0];
    }
    return 1;
  }

  // Calls `change(frame, &photograph)` for every photograph.
  template <class Change>
  void change_photographs(const Change& change) {
    for (Json& frame : manifest["frames"]) {
      Image3 image = photograph(frame);
      change(frame, &image);
      write_exr_rgb(folder_ / frame["file"], image);
    }
  }

  Labels regions() const { return read_labels(folder_ / "regions.png"); }
  void set_regions(const Labels& labels) { write_labels(folder_ / "regions.png", labels); }
  fs::path file(const Json& frame) const { return folder_ / frame["file"]; }

  fit::LayeredFit fitted() const {
    std::ofstream(folder_ / "session.json") << manifest;
    return fit::fit_layers(read_session(folder_), fit::Step::kAlbedo);
  }

 private:
  testing::ScratchFolder scratch_;
  fs::path folder_;
};

std::map<std::string, cv::Mat> maps_of(const LayerMaps& maps) {
  const auto named = named_maps(maps);
  return {named.begin(), named.end()};
}

void expect_numbers_where_confident(const LayerMaps& maps) {
  for (const auto& [name, map] : maps_of(maps)) {
    ASSERT_EQ(maps.confidence.count(name), 1u) << name;
    const Image1& confidence = maps.confidence.at(name);
    int wrong = 0;
    for (int y = 0; y < map.rows; ++y) {
      for (int x = 0; x < map.cols; ++x) {
        if (!(confidence(y, x) > 0)) continue;
        const float* values = map.ptr<float>(y) + x * map.channels();
        for (int k = 0; k < map.channels(); ++k) wrong += !std::isfinite(values[k]);
      }
    }
    EXPECT_EQ(wrong, 0) << name << ": not a number where confidence is above zero";
  }
}

// Of the pixels that both answer, at this quantile: how far `a` is from `b` relative to the length
// of `b`.
double difference(const cv::Mat& a, const cv::Mat& b, double quantile = 0.99) {
  std::vector<double> all;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      const float *p = a.ptr<float>(y) + x * a.channels(), *q = b.ptr<float>(y) + x * b.channels();
      double off = 0, length = 0;
      for (int k = 0; k < a.channels(); ++k)
        off += (p[k] - q[k]) * (p[k] - q[k]), length += q[k] * q[k];
      if (std::isfinite(off) && length > 0) all.push_back(std::sqrt(off / length));
    }
  }
  if (all.empty()) return 0;
  const auto at = all.begin() + std::ptrdiff_t(quantile * double(all.size() - 1));
  std::nth_element(all.begin(), at, all.end());
  return *at;
}

// "12 pixels, the first at (70, 40): 0.25 and 0.26".
std::string pixels_that_differ(const cv::Mat& a, const cv::Mat& b) {
  int count = 0;
  std::string first;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      const uchar *p = a.ptr(y, x), *q = b.ptr(y, x);
      if (std::memcmp(p, q, a.elemSize()) == 0 || ++count > 1) continue;
      const float found = *reinterpret_cast<const float*>(p);
      const float was = *reinterpret_cast<const float*>(q);
      first = fmt::format(", the first at ({}, {}): {:.9g} and {:.9g}", x, y, found, was);
    }
  }
  return count == 0 ? "" : fmt::format("{} pixels", count) + first;
}

double answered(const cv::Mat& map, const Labels& regions) {
  double known = 0, asked = 0;
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      if (!regions(y, x)) continue;
      asked += 1;
      known += std::isfinite(map.ptr<float>(y)[x * map.channels()]);
    }
  }
  return known / asked;
}

constexpr double kDriftMm = 2;

class HardCase : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = std::make_unique<testing::ScratchFolder>();
    twin::Photographer::Options options;
    options.subject = "sphere";
    options.scale = 0.3;
    options.photons = 20000;
    twin::Photographer photographer(options);
    twin::write_truth(scratch->path() / "truth", photographer);
    twin::Studio studio(photographer, 1);
    for (const char* session : {"session", "drifting"}) {
      twin::write_session(scratch->path() / session, photographer, &studio);
      fs::copy_file(scratch->path() / "truth" / "regions.png",
                    scratch->path() / session / "regions.png");
      photographer.set_drift(kDriftMm);
    }
    whole = std::make_unique<fit::LayeredFit>(spoilt().fitted());
  }
  static void TearDownTestSuite() {
    whole.reset();
    scratch.reset();
  }

  static SpoiltSession spoilt() { return SpoiltSession(scratch->path() / "session"); }

  static void expect_the_same_bytes(const fit::LayeredFit& found) {
    const auto maps = maps_of(found.maps);
    for (const auto& [name, map] : maps_of(whole->maps)) {
      EXPECT_EQ(pixels_that_differ(maps.at(name), map), "") << name;
    }
  }

  // Everything that the fit says of every map, pixel by pixel.
  static void expect_the_same(const fit::LayeredFit& found, double tolerance) {
    const auto maps = maps_of(found.maps);
    for (const auto& [name, map] : maps_of(whole->maps)) {
      EXPECT_LE(difference(maps.at(name), map), tolerance) << name;
    }
    for (int r = 0; r < whole->layers.regions_size(); ++r) {
      const v1::Region &a = found.layers.regions(r), &b = whole->layers.regions(r);
      EXPECT_NEAR(a.specular().gaussian_m(), b.specular().gaussian_m(), tolerance) << b.name();
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(a.deep().ld_mm(c), b.deep().ld_mm(c), 10 * tolerance) << b.name();
        EXPECT_NEAR(a.single().amplitude(c), b.single().amplitude(c), tolerance) << b.name();
      }
    }
  }

  static std::unique_ptr<testing::ScratchFolder> scratch;
  static std::unique_ptr<fit::LayeredFit> whole;
};

std::unique_ptr<testing::ScratchFolder> HardCase::scratch;
std::unique_ptr<fit::LayeredFit> HardCase::whole;

TEST_F(HardCase, TheFitItselfIsANumberWhereverItIsConfident) {
  expect_numbers_where_confident(whole->maps);
  for (const auto& [name, map] : maps_of(whole->maps)) {
    EXPECT_GT(answered(map, whole->maps.regions), 0.97) << name;
  }
}

TEST_F(HardCase, HalfTheExposureWithTwiceTheScaleIsTheSameFit) {
  SpoiltSession session = spoilt();
  for (Json& camera : session.manifest["rig"]["cameras"]) {
    camera["saturation"] = 0.5 * camera["saturation"].get<double>();
    camera["read_noise"] = 0.5 * camera["read_noise"].get<double>();
  }
  session.change_photographs([](Json& frame, Image3* image) {
    *image *= 0.5f;
    for (Json& scale : frame["radiance_scale"]) scale = 2 * scale.get<double>();
  });
  expect_the_same(session.fitted(), 1e-4);
}

TEST_F(HardCase, FramesInAnyOrderUnderAnyNameAreTheSameFitByteForByte) {
  SpoiltSession session = spoilt();
  Json& frames = session.manifest["frames"];
  int number = 0;
  for (Json& frame : frames) {
    const fs::path from = session.file(frame);
    frame["file"] = "frames/" + std::to_string((7 * number++) % 101) + ".exr";
    fs::rename(from, session.file(frame));
  }
  std::reverse(frames.begin(), frames.end());
  expect_the_same_bytes(session.fitted());
}

TEST_F(HardCase, OnOneProcessorTheFitIsTheSameToTheLastBit) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const fit::LayeredFit found = spoilt().fitted();
  expect_the_same_bytes(found);
  for (int r = 0; r < whole->layers.regions_size(); ++r) {
    EXPECT_TRUE(google::protobuf::util::MessageDifferencer::Equals(found.layers.regions(r),
                                                                   whole->layers.regions(r)))
        << whole->layers.regions(r).name();
  }
  for (const auto& [name, value] : whole->layers.checks()) {
    EXPECT_EQ(found.layers.checks().at(name), value) << name;
  }
}

// x to y to z to x: the one turn that leaves the gradients what they are.
Json turned(const Json& v) { return Json::array({v[2], v[0], v[1]}); }

TEST_F(HardCase, InARigThatIsTurnedTheResultsTurnWithIt) {
  SpoiltSession session = spoilt();
  Json& rig = session.manifest["rig"];
  for (Json& led : rig["leds"]) led["direction"] = turned(led["direction"]);
  std::vector<Json*> poses{&rig["projector"]};
  for (Json& camera : rig["cameras"]) poses.push_back(&camera);
  for (Json* pose : poses) {
    Json& r = (*pose)["rotation"];
    for (int row = 0; row < 3; ++row) {
      const Json t = turned({r[3 * row], r[3 * row + 1], r[3 * row + 2]});
      for (int k = 0; k < 3; ++k) r[3 * row + k] = t[k];
    }
  }
  // A white surface that faces +Z is 1 in either rig's units, and +Z was +Y.
  const auto light_along = [&](int axis) {
    double sum = 0;
    for (const Json& led : rig["leds"]) sum += std::max(0.0, led["direction"][axis].get<double>());
    return sum;
  };
  const double unit = light_along(0) / light_along(2);
  const std::map<std::string, std::string> role_after{
      {"GRADIENT_X", "GRADIENT_Y"}, {"GRADIENT_Y", "GRADIENT_Z"}, {"GRADIENT_Z", "GRADIENT_X"}};
  for (Json& frame : session.manifest["frames"]) {
    const auto after = role_after.find(frame["role"]);
    if (after != role_after.end()) frame["role"] = after->second;
    if (frame["role"].get<std::string>().rfind("GRADIENT", 0) != 0) continue;
    for (Json& scale : frame["radiance_scale"]) scale = unit * scale.get<double>();
  }
  fit::LayeredFit found = session.fitted();
  const auto turn_back = [](Image3* map) {
    for (Vec3& v : *map) v = Vec3(v[1], v[2], v[0]);
  };
  turn_back(&found.maps.position_mm);
  turn_back(&found.maps.normal_specular);
  for (Image3& normal : found.maps.normal_diffuse) turn_back(&normal);
  expect_the_same(found, 2e-3);  // where light is tabulated, the table's cells do not turn
}

// Left is right: the projector's columns run the other way, so that red and blue of its fringes
// change places, and with them of everything.
TEST_F(HardCase, AMirroredFaceOfOtherColoursIsTheSameFaceMirrored) {
  SpoiltSession session = spoilt();
  Json& rig = session.manifest["rig"];
  const auto mirror_pose = [](Json* pose, double width) {
    (*pose)["cx"] = width - (*pose)["cx"].get<double>();
    for (const int k : {1, 2, 3, 6}) {
      (*pose)["rotation"][k] = -(*pose)["rotation"][k].get<double>();
    }
    (*pose)["translation_mm"][0] = -(*pose)["translation_mm"][0].get<double>();
  };
  for (Json& camera : rig["cameras"]) mirror_pose(&camera, camera["width"].get<double>() - 1);
  const double columns = rig["projector"]["width"];
  mirror_pose(&rig["projector"], columns);
  for (Json& led : rig["leds"]) {
    led["direction"][0] = -led["direction"][0].get<double>();
    if (led.contains("intensity")) std::swap(led["intensity"][0], led["intensity"][2]);
  }
  Json& tint = rig["projector_to_led"];
  std::reverse(tint.begin(), tint.end());  // rows and columns, both
  Json& dots = session.manifest["patterns"]["dots"]["offset_px"];
  dots[0] = columns - dots[0].get<double>();
  for (Json& frame : session.manifest["frames"]) {
    if (frame["role"] == "STRIPES") frame["index"] = (6 - frame.value("index", 0)) % 4;
  }
  // What the gradient along x lights is what the others leave of the whole.
  const std::map<std::string, Image3> full{
      {"PARALLEL", session.photograph("GRADIENT_FULL", "PARALLEL")},
      {"CROSS", session.photograph("GRADIENT_FULL", "CROSS")}};
  session.change_photographs([&](Json& frame, Image3* image) {
    if (frame["role"] == "GRADIENT_X" && frame["camera"] == "left") {
      *image = full.at(frame["analyser"]) - *image;
    }
    cv::flip(*image, *image, 1);
    for (Vec3& v : *image) std::swap(v[0], v[2]);
    std::swap(frame["radiance_scale"][0], frame["radiance_scale"][2]);
  });
  Labels regions = session.regions();
  cv::flip(regions, regions, 1);
  session.set_regions(regions);

  const LayerMaps found = session.fitted().maps;
  const auto mirrored = [](const cv::Mat& map) {
    cv::Mat back;
    cv::flip(map, back, 1);
    return back;
  };
  Image3 position_mm = mirrored(found.position_mm), normal = mirrored(found.normal_specular),
         deep = mirrored(found.deep_albedo), ld_mm = mirrored(found.deep_ld_mm);
  for (Image3* map : {&position_mm, &normal}) {
    for (Vec3& v : *map) v[0] = -v[0];
  }
  for (Image3* map : {&deep, &ld_mm}) {
    for (Vec3& v : *map) std::swap(v[0], v[2]);
  }
  // Sampled elsewhere, and of other noise along x: the same within what noise does.
  EXPECT_LT(difference(position_mm, whole->maps.position_mm, 0.5) * 100, 0.1);  // mm of some 100
  EXPECT_LT(difference(normal, whole->maps.normal_specular, 0.5), 0.01);
  EXPECT_LT(difference(deep, whole->maps.deep_albedo, 0.5), 0.02);
  EXPECT_LT(difference(ld_mm, whole->maps.deep_ld_mm, 0.5), 0.02);
}

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
  EXPECT_LT(difference(found.maps.deep_ld_mm, rest.deep_ld_mm, 0.5), 0.02);
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
