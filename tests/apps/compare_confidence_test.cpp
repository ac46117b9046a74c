// Error against confidence: bins, verdict, and what the report makes of them.
#include "apps/compare_confidence.h"

#include <gtest/gtest.h>

#include <random>

#include "apps/compare_folders.h"
#include "io/expect_error.h"
#include "io/fake_session.h"
#include "io/json.h"
#include "io/layer_maps.h"

namespace lamella::apps {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();

// Pixels whose confidence is 0 to 1 in an order of no pattern.
struct Sample {
  std::vector<double> confidence, error;
};

Sample sample_of(size_t count, const std::function<double(double confidence)>& error) {
  std::mt19937 random(7);
  Sample s;
  for (size_t i = 0; i < count; ++i) {
    s.confidence.push_back(double(random() % 100000) / 100000);
    s.error.push_back(error(s.confidence.back()));
  }
  return s;
}

std::vector<ConfidenceBin> bins_of_sample(const Sample& s) {
  return confidence_bins(s.confidence, s.error);
}

TEST(ConfidenceCurve, HasTenBinsOfAsManyPixelsEachWithTheErrorsOfThese) {
  const auto bins = bins_of_sample(sample_of(1000, [](double c) { return 2 - c; }));
  ASSERT_EQ(bins.size(), 10u);
  size_t pixels = 0;
  for (size_t i = 0; i < bins.size(); ++i) {
    EXPECT_NEAR(double(bins[i].pixels), 100, 1);
    EXPECT_LT(bins[i].least_confidence, bins[i].mean_confidence);
    EXPECT_NEAR(bins[i].mean_confidence, 0.05 + 0.1 * double(i), 0.03);
    EXPECT_NEAR(bins[i].median_error, 2 - bins[i].mean_confidence, 0.01);
    EXPECT_NEAR(bins[i].p95_error, 2 - bins[i].least_confidence, 0.012);
    pixels += bins[i].pixels;
  }
  EXPECT_EQ(pixels, 1000u);
  EXPECT_TRUE(falls(bins));
}

TEST(ConfidenceCurve, DoesNotFallWhereConfidenceIsNoiseNorWhereErrorRisesWithIt) {
  std::mt19937 random(3);
  EXPECT_FALSE(
      falls(bins_of_sample(sample_of(5000, [&](double) { return double(random() % 1000); }))));
  EXPECT_FALSE(falls(bins_of_sample(sample_of(5000, [](double c) { return 1 + c; }))));
}

// A hundredth less error is in order, and nothing that anybody could use.
TEST(ConfidenceCurve, DoesNotFallWhereItIsInOrderAndFlat) {
  EXPECT_FALSE(falls(bins_of_sample(sample_of(5000, [](double c) { return 2 - 0.02 * c; }))));
}

// Most pixels in the middle, so that a lower end alone does not make a fall.
TEST(ConfidenceCurve, DoesNotFallWhereOnlyItsEndsDo) {
  EXPECT_FALSE(falls(bins_of_sample(sample_of(5000, [](double c) {
    return c < 0.1 ? 5.0 : c > 0.9 ? 0.5 : 1 + 3 * c;
  }))));
}

TEST(ConfidenceCurve, KeepsPixelsOfOneConfidenceTogether) {
  Sample s;
  for (int i = 0; i < 1000; ++i) {
    s.confidence.push_back(i % 10 == 0 ? 0.25 : i % 10 == 1 ? 0.75 : 0.5);
    s.error.push_back(1 / s.confidence.back());
  }
  const auto bins = bins_of_sample(s);
  ASSERT_EQ(bins.size(), 3u);
  EXPECT_EQ(bins[0].pixels, 100u);
  EXPECT_EQ(bins[1].pixels, 800u);
  EXPECT_EQ(bins[2].pixels, 100u);
  EXPECT_DOUBLE_EQ(bins[1].least_confidence, 0.5);
  EXPECT_DOUBLE_EQ(bins[1].p95_error, 2);
}

TEST(ConfidenceCurve, OfOneConfidenceEverywhereIsABinAndDoesNotFall) {
  const auto bins = confidence_bins(std::vector<double>(400, 0.5), std::vector<double>(400, 2.0));
  ASSERT_EQ(bins.size(), 1u);
  EXPECT_EQ(bins[0].pixels, 400u);
  EXPECT_FALSE(falls(bins));
}

TEST(ConfidenceCurve, LeavesOutWhatIsNotKnown) {
  Sample s = sample_of(1000, [](double c) { return 2 - c; });
  const auto before = bins_of_sample(s);
  for (int i = 0; i < 300; ++i) {
    s.confidence.push_back(i % 3 == 0 ? kNotKnown : 0.99);
    s.error.push_back(i % 3 == 0   ? 50
                      : i % 3 == 1 ? kNotKnown
                                   : std::numeric_limits<double>::infinity());
  }
  const auto after = bins_of_sample(s);
  ASSERT_EQ(after.size(), before.size());
  EXPECT_EQ(after.back().pixels, before.back().pixels);
  EXPECT_EQ(after.back().p95_error, before.back().p95_error);
}

TEST(ConfidenceCurve, IsNoneOfAHandfulOfPixelsOrOfNone) {
  EXPECT_TRUE(bins_of_sample(sample_of(99, [](double c) { return 1 - c; })).empty());
  EXPECT_FALSE(bins_of_sample(sample_of(100, [](double c) { return 1 - c; })).empty());
  EXPECT_TRUE(confidence_bins({}, {}).empty());
}

TEST(PixelErrors, AreInTheUnitOfTheMapAndNoneWhereThereIsNoTruth) {
  const MapValues up{{{0, kNotKnown}, {0, 0}, {1, 1}}}, aside{{{1, 1}, {0, 0}, {0, 0}}};
  EXPECT_NEAR(pixel_errors("normal_specular", up, aside).value[0], 90, 1e-9);
  EXPECT_STREQ(pixel_errors("normal_specular", up, aside).unit, "deg");
  EXPECT_NEAR(pixel_errors("position", up, aside).value[0], std::sqrt(2.0), 1e-9);
  EXPECT_STREQ(pixel_errors("position", up, aside).unit, "mm");
  EXPECT_TRUE(std::isnan(pixel_errors("position", up, aside).value[1]));
  const MapValues found{{{0.3, 1}, {0.4, 1}, {0, 1}}}, truth{{{0.6, 0}, {0.8, 0}, {0, 0}}};
  EXPECT_NEAR(pixel_errors("deep_albedo", found, truth).value[0], 50, 1e-9);
  EXPECT_STREQ(pixel_errors("deep_albedo", found, truth).unit, "percent");
  EXPECT_FALSE(std::isfinite(pixel_errors("deep_albedo", found, truth).value[1]));
}

// A truth of 20 x 20 pixels and a fit of it, whose position is off by more the further right and
// whose deep albedo is off by more the further down; sure of both the further left.
class ConfidenceReport : public ::testing::Test {
 protected:
  ConfidenceReport() {
    maps_.regions = Labels(20, 20, uchar(1));
    maps_.position_mm = Image3(20, 20, Vec3(1, 2, 3));
    maps_.normal_specular = Image3(20, 20, Vec3(0, 0, 1));
    maps_.deep_albedo = Image3(20, 20, Vec3(0.5f, 0.4f, 0.3f));
    write("truth", maps_);
    LayerMaps fit = maps_;
    fit.position_mm = maps_.position_mm.clone();
    fit.deep_albedo = maps_.deep_albedo.clone();
    Image1 confidence(20, 20);
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 20; ++x) {
        confidence(y, x) = 0.9f - 0.04f * float(x);
        fit.position_mm(y, x)[2] += 0.01f * float(x + 1);
        fit.deep_albedo(y, x) *= 1 + 0.01f * float(y + 1);
      }
    }
    for (const char* map : {"position", "deep_albedo", "total_albedo"}) {
      fit.confidence[map] = confidence;
    }
    fit.confidence["normal_specular"] = Image1(20, 20, 0.5f);
    write("fit", fit);
  }

  void write(const std::string& name, const LayerMaps& maps) const {
    fs::create_directory(scratch_.path() / name);
    write_layer_maps(scratch_.path() / name, maps);
    v1::Layers layers;
    layers.set_format("lamella.layers.v1");
    layers.add_regions()->set_name("skin");
    write_json(scratch_.path() / name / "layers.json", layers);
  }

  Json compared() const {
    return compare_folders(scratch_.path() / "fit", scratch_.path() / "truth");
  }

  testing::ScratchFolder scratch_;
  LayerMaps maps_;
};

TEST_F(ConfidenceReport, HasACurveForEveryMapWithATruthInUnitsThatItsNamesTell) {
  const Json f = compared()["confidence"];
  const Json& position = f["position"];
  EXPECT_EQ(position["unit"], "mm");
  EXPECT_EQ(position["falls"], true);
  EXPECT_NEAR(position["spearman_confidence_vs_error"].get<double>(), -1, 1e-9);
  ASSERT_EQ(position["curve"].size(), 10u);
  EXPECT_EQ(position["curve"][0]["pixels"], 40);
  EXPECT_NEAR(position["curve"][0]["confidence_least"].get<double>(), 0.14, 0.003);
  EXPECT_NEAR(position["curve"][0]["error_median_mm"].get<double>(), 0.195, 1e-3);
  EXPECT_NEAR(position["curve"][9]["error_p95_mm"].get<double>(), 0.02, 1e-3);
  EXPECT_EQ(f["deep_albedo"]["unit"], "percent");
  EXPECT_EQ(f["deep_albedo"]["falls"], false);
  EXPECT_NEAR(f["deep_albedo"]["curve"][4]["error_median_percent"].get<double>(), 10.5, 0.1);
  EXPECT_TRUE(f["normal_specular"]["falls"].is_null());
  EXPECT_EQ(f["normal_specular"]["curve"].size(), 1u);
  EXPECT_FALSE(f["total_albedo"].contains("curve"));
}

TEST_F(ConfidenceReport, HasTheCurveOfTheTotalAlbedoWhereTheFitAndTheTruthHaveOne) {
  LayerMaps fit = maps_;
  maps_.total_albedo = Image3(20, 20, Vec3(0.5f, 0.5f, 0.5f));
  fit.total_albedo = maps_.total_albedo * 1.25;
  fit.confidence["total_albedo"] = Image1(20, 20, 0.5f);
  write("truth", maps_);
  write("fit", fit);
  const Json total = compared()["confidence"]["total_albedo"];
  ASSERT_TRUE(total.contains("curve")) << total;
  EXPECT_NEAR(total["curve"][0]["error_median_percent"].get<double>(), 25, 0.1);
}

// The line of the report that begins with `name`, of the confidences' part.
std::string confidence_line(const std::string& table, const std::string& name) {
  const size_t part = table.find("least sure tenth");
  const size_t at = table.find("\n  " + name, part);
  if (part == std::string::npos || at == std::string::npos) return "none in " + table;
  return table.substr(at + 1, table.find('\n', at + 1) - at - 1);
}

TEST_F(ConfidenceReport, ShowsTheEndsOfTheCurvesAndWhichOfThemSayNothing) {
  const std::string table = comparison_table(compared());
  const std::string position = confidence_line(table, "position");
  EXPECT_TRUE(position.ends_with(" mm")) << position;
  EXPECT_NE(position.find("0.195"), std::string::npos) << position;
  EXPECT_NE(position.find("0.0146"), std::string::npos) << position;
  EXPECT_TRUE(confidence_line(table, "deep albedo").ends_with("does not order the errors"));
  EXPECT_TRUE(confidence_line(table, "specular normal").ends_with("is the same everywhere"));
}

TEST_F(ConfidenceReport, LeavesOutAMapWithoutConfidence) {
  LayerMaps fit = maps_;
  fit.confidence["position"] = Image1(20, 20, 0.5f);
  write("fit", fit);
  const Json f = compared();
  EXPECT_EQ(f["confidence"].size(), 1u);
  EXPECT_EQ(confidence_line(comparison_table(f), "deep albedo").substr(0, 4), "none");
  fs::remove(scratch_.path() / "fit/confidence.exr");
  EXPECT_TRUE(confidence_curves_of(compared()).empty());
  EXPECT_EQ(comparison_table(compared()).find("least sure"), std::string::npos);
}

TEST_F(ConfidenceReport, CanBeReadBackAsCurvesFromTheShapeToTheSkin) {
  const std::vector<ConfidenceCurve> curves = confidence_curves_of(compared());
  ASSERT_EQ(curves.size(), 3u);
  const auto position = std::find_if(curves.begin(), curves.end(),
                                     [](const ConfidenceCurve& c) { return c.map == "position"; });
  ASSERT_NE(position, curves.end());
  EXPECT_TRUE(position->falls);
  EXPECT_EQ(position->unit, "mm");
  ASSERT_EQ(position->bins.size(), 10u);
  EXPECT_NEAR(position->bins[0].median_error, 0.195, 1e-3);
  EXPECT_EQ(position->bins[0].pixels, 40u);
}

}  // namespace
}  // namespace lamella::apps
