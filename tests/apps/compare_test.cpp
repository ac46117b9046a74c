#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "apps/compare_folders.h"
#include "apps/compare_images.h"
#include "apps/compare_npz.h"
#include "apps/compare_profile.h"
#include "apps/report.h"
#include "apps/run_lamella.h"
#include "base/error.h"
#include "io/expect_error.h"
#include "io/json.h"
#include "io/layer_maps.h"
#include "io/whole_file.h"
#include "model/dipole.h"

namespace lamella::apps {
namespace {

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("lamella_compare_" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

Image3 noise(int rows, int cols, double low, double high) {
  Image3 image(rows, cols);
  cv::randu(image, cv::Scalar::all(low), cv::Scalar::all(high));
  return image;
}

LayerMaps some_maps() {
  LayerMaps maps;
  maps.position_mm = noise(20, 20, -50, 50);
  maps.normal_specular = Image3(20, 20, Vec3(0, 0, 1));
  for (Image3& n : maps.normal_diffuse) n = maps.normal_specular.clone();
  maps.specular_intensity = Image1(20, 20, 0.25f);
  maps.specular_intensity(3, 3) = 0.5f;
  for (auto member :
       {&LayerMaps::single_albedo, &LayerMaps::total_albedo, &LayerMaps::shallow_albedo,
        &LayerMaps::deep_albedo, &LayerMaps::deep_alpha, &LayerMaps::deep_ld_mm}) {
    maps.*member = noise(20, 20, 0.2, 0.8);
  }
  maps.regions = Labels(20, 20, uchar(1));
  return maps;
}

v1::Layers some_layers() {
  v1::Layers layers;
  layers.set_format("lamella.layers.v1");
  v1::Region* region = layers.add_regions();
  region->set_name("skin");
  region->mutable_specular()->set_gaussian_m(0.3);
  for (int i = 0; i <= 45; ++i) {
    region->mutable_specular()->add_theta(i * M_PI / 180);
    region->mutable_specular()->add_p(std::exp(-i * i / 300.0));
  }
  for (double ld : {2.0, 1.0, 0.7}) region->mutable_deep()->add_ld_mm(ld);
  for (int c = 0; c < 3; ++c) region->mutable_single()->add_amplitude(0.05);
  return layers;
}

void write_fit(const fs::path& folder, const LayerMaps& maps, const v1::Layers& layers) {
  fs::create_directories(folder);
  write_layer_maps(folder, maps);
  write_json(folder / "layers.json", layers);
}

int compare(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "compare");
  return testing::run_lamella(arguments).exit_code;
}

TEST(Percentile, IsLinearBetweenRanks) {
  EXPECT_DOUBLE_EQ(percentile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(percentile({1, 2, 3, 4, 5}, 0.95), 4.8);
  EXPECT_TRUE(std::isnan(percentile({}, 0.5)));
}

TEST(RatioStatistics, TellAScaleFromAnError) {
  std::vector<double> truth, found;
  for (int i = 1; i <= 40; ++i) {
    truth.push_back(i);
    found.push_back(1.25 * i);
  }
  found[3] = kNaN;
  const Json s = ratio_statistics(found, truth);
  EXPECT_NEAR(s["rel_rmse"].get<double>(), 0.25, 1e-9);
  EXPECT_NEAR(s["rel_rmse_best_scale"].get<double>(), 0, 1e-9);
  EXPECT_NEAR(s["corr"].get<double>(), 1, 1e-9);
  EXPECT_NEAR(s["median_ratio"].get<double>(), 1.25, 1e-9);
  EXPECT_TRUE(ratio_statistics({1, 2}, {1, 2}).is_null());
}

TEST(RankCorrelation, SeesOrderAlone) {
  EXPECT_NEAR(rank_correlation({1, 2, 3, 4}, {1, 8, 27, 64}), 1, 1e-12);
  EXPECT_NEAR(rank_correlation({1, 2, 3, 4}, {9, 7, 5, 1}), -1, 1e-12);
  EXPECT_NEAR(rank_correlation({1, 1, 2, 2}, {3, 3, 5, 5}), 1, 1e-12);
}

TEST(RigidMotion, IsFoundInSpiteOfOutliers) {
  const Mat33d turn(0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1);
  std::vector<Vec3d> from, to;
  for (int i = 0; i < 300; ++i) {
    from.emplace_back(std::sin(i) * 50, std::cos(3 * i) * 40, std::sin(7 * i) * 30);
    to.push_back(turn * from.back() + Vec3d(1, 2, 3));
    if (i % 20 == 0) to.back() += Vec3d(50, 0, 0);
  }
  const RigidMotion motion = robust_rigid_motion(from, to);
  EXPECT_NEAR(motion.degrees(), 36.87, 0.01);
  EXPECT_NEAR(motion.shift[1], 2, 1e-6);
}

TEST(Images, ThatAreEqualHaveNoErrorAndNaNCountsAsBlack) {
  const Image3 truth = noise(30, 40, 0.1, 2);
  const Json same = image_figures(truth, truth, Mask());
  EXPECT_NEAR(same["rel_rmse"].get<double>(), 0, 1e-12);
  EXPECT_NEAR(same["psnr_srgb_db"].get<double>(), 120, 1e-9);
  Image3 holed = truth * 0.5;
  holed(0, 0) = Vec3::all(kNaN);
  const Json half = image_figures(holed, truth, Mask());
  EXPECT_NEAR(half["rel_rmse"].get<double>(), 0.5, 0.01);
  EXPECT_NEAR(half["best_scale"].get<double>(), 2, 0.01);
  EXPECT_NEAR(half["nonfinite"].get<double>(), 1.0 / 1200, 1e-9);
}

TEST(Images, AreComparedWhereTheMaskSays) {
  const Image3 truth = noise(10, 10, 0.5, 1);
  Image3 found = truth.clone();
  found(cv::Rect(0, 0, 5, 10)) *= 3;
  Mask right(10, 10, uchar(0));
  right(cv::Rect(5, 0, 5, 10)).setTo(255);
  EXPECT_NEAR(relative_rmse(found, truth, right), 0, 1e-12);
  EXPECT_GT(relative_rmse(found, truth, Mask()), 0.5);
}

TEST(Mask, IsWhereAPngOfAnyKindIsNotBlackAndOfTheSizeOfThePicture) {
  const Folder folder;
  const fs::path file = folder / "mask.png";
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1}) {
    cv::Mat picture(10, 12, type, cv::Scalar(0, 0, 0, 255));
    picture(cv::Rect(5, 0, 7, 10)).setTo(cv::Scalar(1, 0, 0, 255));
    cv::imwrite(file.string(), picture);
    const Mask mask = read_mask(file, {12, 10});
    EXPECT_EQ(cv::countNonZero(mask), 70) << type;
    EXPECT_EQ(cv::countNonZero(mask(cv::Rect(5, 0, 7, 10)) == 255), 70) << type;
  }
  EXPECT_TRUE(testing::names(testing::complaint([&] {
                               read_mask(file, {10, 12});
                             }),
                             {"mask.png: is 12x10, the image 10x12"}));
  write_whole_text(file, "white");
  EXPECT_TRUE(testing::names(testing::complaint([&] {
                               read_mask(file, {12, 10});
                             }),
                             {"mask.png: not a PNG image; save it as one"}));
}

TEST(Folders, OfTheSameMapsDifferInNothing) {
  const Folder folder;
  write_fit(folder / "a", some_maps(), some_layers());
  const Json f = compare_folders(folder / "a", folder / "a");
  EXPECT_EQ(f["answered"]["position"], 1.0);
  EXPECT_EQ(f["position"]["error_mm"]["rms"], 0.0);
  EXPECT_NEAR(f["deep_albedo"]["error"][2]["rel_rmse"].get<double>(), 0, 1e-9);
  EXPECT_NEAR(f["summary"]["ld_mean_abs_rel_error"].get<double>(), 0, 1e-9);
  EXPECT_NEAR(f["regions"]["skin"]["p_L1"].get<double>(), 0, 1e-9);
  EXPECT_TRUE(f["summary"]["regions_without_a_figure"].empty());
}

TEST(Folders, ShowWhatIsWrongWhereItIs) {
  const Folder folder;
  LayerMaps maps = some_maps();
  v1::Layers layers = some_layers();
  write_fit(folder / "true", maps, layers);
  for (Vec3& x : maps.position_mm) x[2] += 0.5f;
  maps.deep_albedo *= 1.1f;
  maps.total_albedo *= 1.2f;
  maps.normal_specular = Image3(20, 20, unit(Vec3(0.1f, 0, 1)));
  maps.shallow_albedo(cv::Rect(0, 0, 20, 5)).setTo(Vec3::all(kNaN));
  layers.mutable_regions(0)->mutable_deep()->set_ld_mm(0, 2.2);
  layers.mutable_regions(0)->mutable_specular()->clear_gaussian_m();
  write_fit(folder / "found", maps, layers);
  const Json f = compare_folders(folder / "found", folder / "true");
  EXPECT_NEAR(f["position"]["error_mm"]["median"].get<double>(), 0.5, 1e-4);
  EXPECT_NEAR(f["position"]["after_rigid_mm"]["rms"].get<double>(), 0, 1e-4);
  EXPECT_NEAR(f["normal_specular"]["deg"]["median"].get<double>(), 5.711, 0.01);
  EXPECT_NEAR(f["deep_albedo"]["error"][0]["rel_rmse"].get<double>(), 0.1, 1e-4);
  EXPECT_NEAR(f["answered"]["shallow_albedo"].get<double>(), 0.75, 1e-9);
  EXPECT_NEAR(f["regions"]["skin"]["ld_rel_error"][0].get<double>(), 0.1, 1e-9);
  EXPECT_EQ(f["summary"]["regions_without_a_figure"][0], "skin");
  const std::string table = comparison_table(f);
  EXPECT_NE(table.find("2.20 / 2.00"), std::string::npos) << table;
  EXPECT_NE(table.find("total_albedo           100.0 %    20.0 %    20.0 %    20.0 %"),
            std::string::npos)
      << table;
}

TEST(Folders, AreComparedWithoutASignBeforeNought) {
  EXPECT_EQ(decimals(-0.0004, 3), "0.000");
  EXPECT_EQ(decimals(-0.0006, 3), "-0.001");
  EXPECT_EQ(decimals(-12, 0), "-12");
  const Folder folder;
  write_fit(folder / "true", some_maps(), some_layers());
  v1::Layers layers = some_layers();
  layers.mutable_regions(0)->mutable_single()->set_amplitude(1, 0.05 * (1 - 1e-4));
  write_fit(folder / "found", some_maps(), layers);
  const std::string table = comparison_table(compare_folders(folder / "found", folder / "true"));
  EXPECT_EQ(table.find("-0 %"), std::string::npos) << table;
}

// The smallest .npz: members stored, not deflated.
std::string stored_npz(const std::string& name, const std::string& npy) {
  const auto little = [](size_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += char(value >> (8 * i) & 255);
    return text;
  };
  const std::string sizes = little(npy.size(), 4) + little(npy.size(), 4) + little(name.size(), 2);
  const std::string local = "PK\3\4" + std::string(14, '\0') + sizes + little(0, 2) + name + npy;
  const std::string entry = "PK\1\2" + std::string(16, '\0') + sizes + std::string(16, '\0') + name;
  return local + entry + "PK\5\6" + std::string(4, '\0') + little(1, 2) + little(1, 2) +
         little(entry.size(), 4) + little(local.size(), 4) + little(0, 2);
}

TEST(Npz, GivesShapeAndValuesAndRefusesWhatIsCutShort) {
  const Folder folder;
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n";
  std::string npy = std::string("\x93NUMPY\1\0", 8) + char(header.size()) + '\0' + header;
  const float values[6] = {1, 2, 3, 4, 5, 6};
  npy.append(reinterpret_cast<const char*>(values), sizeof values);
  write_whole_text(folder / "a.npz", stored_npz("R.npy", npy));
  const NpzArray array = read_npz(folder / "a.npz", "R");
  EXPECT_EQ(array.shape, (std::vector<size_t>{2, 3}));
  EXPECT_EQ(array.values[4], 5);
  EXPECT_THROW(read_npz(folder / "a.npz", "r"), Error);
  npy.resize(npy.size() - 4);
  write_whole_text(folder / "short.npz", stored_npz("R.npy", npy));
  EXPECT_THROW(read_npz(folder / "short.npz", "R"), Error);
}

TEST(ProfileL1, IsNothingForTheDipoleItselfAndGrowsWithItsLength) {
  v1::Region region;
  for (int c = 0; c < 3; ++c) {
    region.mutable_deep()->add_ld_mm(1 + 0.2 * c);
    region.mutable_deep()->add_alpha_dot(0.9);
  }
  TrueProfile truth;
  for (int i = 0; i < 1600; ++i) {
    truth.r_mm.push_back(0.01 * i + 0.005);
    truth.reflectance.push_back(
        3 * model::dipole_reflectance(model::Dipole<double>{0.9, 1.0}, truth.r_mm.back()));
  }
  EXPECT_NEAR(profile_L1(region, 0, 0.4, 0, truth), 0, 1e-9);
  EXPECT_GT(profile_L1(region, 1, 0.4, 0, truth), 0.05);
  EXPECT_GT(profile_L1(region, 2, 0.4, 0, truth), profile_L1(region, 1, 0.4, 0, truth));
}

TEST(Compare, ExitsWithOneBelowTheQualityAskedAndWithTwoOnBadInput) {
  const Folder folder;
  const Image3 truth = noise(12, 12, 0.5, 1);
  const std::string a = folder / "a.exr", b = folder / "b.exr", small = folder / "small.exr";
  write_exr_rgb(a, truth * 1.2);
  write_exr_rgb(b, truth);
  write_exr_rgb(small, truth(cv::Rect(0, 0, 6, 6)).clone());
  EXPECT_EQ(compare({a, b, "--require", "rel_rmse<=0.3"}), 0);
  EXPECT_EQ(compare({a, b, "--require", "rel_rmse<=0.1"}), 1);
  EXPECT_EQ(compare({a, b, "--require", "rel_rmse=0.1"}), 2);
  EXPECT_EQ(compare({a, b, "--require", "beauty<=0.1"}), 2);
  EXPECT_EQ(compare({a, small}), 2);
  EXPECT_EQ(compare({a, folder / "none.exr"}), 2);
}

// Failure: every map of a fit is no number off the face.
TEST(Compare, LeavesOutWhatTheTruthDoesNotKnowAndSaysHowMuch) {
  const Folder folder;
  const std::string a = folder / "a.exr", b = folder / "b.exr", nothing = folder / "nothing.exr";
  Image3 truth = noise(12, 12, 0.5, 1);
  write_exr_rgb(a, truth * 1.2);
  truth(cv::Rect(0, 0, 12, 3)).setTo(cv::Scalar::all(double(kNaN)));
  write_exr_rgb(b, truth);
  write_exr_rgb(nothing, Image3(12, 12, Vec3::all(kNaN)));
  const testing::Outcome some = testing::run_lamella({"compare", a, b});
  EXPECT_EQ(some.exit_code, 0) << some.err;
  EXPECT_NE(some.err.find("25.0 % of the pixels are no numbers"), std::string::npos) << some.err;
  EXPECT_NE(some.out.find("20.00 %"), std::string::npos) << some.out;
  const testing::Outcome none = testing::run_lamella({"compare", a, nothing});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("has no number where it is compared"), std::string::npos) << none.err;
}

TEST(Compare, RefusesARequirementThatCannotBeJudgedBeforeItReportsAnything) {
  const Folder folder;
  const std::string a = folder / "a.exr";
  write_exr_rgb(a, noise(12, 12, 0.5, 1));
  for (const char* wrong :
       {"beauty<=0.1", "rel_rmse<=0x10", "rel_rmse<=0x1p-3", "rel_rmse<=nan", "rel_rmse<=inf",
        "rel_rmse<=a lot", "rel_rmse<=", "<=1", "a~b<=1", "rel_rmse.0<=1"}) {
    SCOPED_TRACE(wrong);
    const testing::Outcome outcome = testing::run_lamella({"compare", a, a, "--require", wrong});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.complaints().size(), 1u);
    EXPECT_NE(outcome.err.find("--require: "), std::string::npos) << outcome.err;
  }
}

// A fit beside the truth that it is compared with; what `spoil` does to it is a problem.
testing::Outcome compare_spoilt(const std::function<void(const fs::path&)>& spoil) {
  const Folder folder;
  LayerMaps maps = some_maps();
  maps.confidence["position"] = Image1(20, 20, 0.5f);
  write_fit(folder / "fit", maps, some_layers());
  write_whole_text(folder / "fit/model.glb", "glTF");
  write_fit(folder / "truth", maps, some_layers());
  spoil(folder / "fit");
  return testing::run_lamella({"compare", folder / "fit", folder / "truth"});
}

void expect_problem(const testing::Outcome& outcome, const std::string& problem) {
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_NE(outcome.err.find(problem), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.out.find(problem), std::string::npos) << outcome.out;
}

TEST(Compare, ExitsWithNoughtWhereTheFitIsWhole) {
  const testing::Outcome outcome = compare_spoilt([](const fs::path&) {});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
}

TEST(Compare, OfARegionOfAnyNameGivesTheFiguresAndShowsTheNameSoThatNoTerminalObeysIt) {
  const testing::Outcome outcome = compare_spoilt([](const fs::path& fit) {
    v1::Layers layers = some_layers();
    layers.mutable_regions(0)->set_name("a/b~\x1b[2J");
    for (const fs::path& folder : {fit, fit.parent_path() / "truth"}) {
      write_json(folder / "layers.json", layers);
    }
  });
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("a/b~\\x1b[2J       0.300 / 0.300"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find('\x1b'), std::string::npos);
}

TEST(Compare, GivesTheFiguresOfRegionsWhateverMapsTheFitHas) {
  const Folder folder;
  v1::Layers layers = some_layers();
  for (int c = 0; c < 3; ++c) layers.mutable_single()->add_g(0.65);
  write_fit(folder / "truth", some_maps(), layers);
  write_fit(folder / "fit", some_maps(), layers);
  for (const char* map : {"deep_ld", "deep_alpha", "deep_albedo", "shallow_albedo", "single_albedo",
                          "specular_intensity", "normal_diffuse", "normal_specular", "position"}) {
    fs::remove(folder / (std::string("fit/") + map + ".exr"));
    const Json figures = compare_folders(folder / "fit", folder / "truth");
    EXPECT_EQ(figures["summary"]["p_L1_mean"], 0.0);
    EXPECT_EQ(figures["regions"]["skin"]["gaussian_m_abs_error"], 0.0);
  }
}

TEST(Compare, ExitsWithOneAndSaysWhichMapIsMissing) {
  expect_problem(compare_spoilt([](const fs::path& fit) { fs::remove(fit / "position.exr"); }),
                 "missing position.exr");
}

TEST(Compare, NamesAFileThatSeveralFiguresCannotUseOnce) {
  const testing::Outcome outcome = compare_spoilt([](const fs::path& fit) {
    write_exr(fit / "confidence.exr",
              {{"position", Image1(9, 8, 1.f)}, {"normal_specular", Image1(9, 8, 1.f)}});
  });
  const std::string words = "lamella: confidence.exr is 8x9, expected 20x20";
  ASSERT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find(words), outcome.err.rfind(words)) << outcome.err;
}

TEST(Compare, ExitsWithOneAndSaysWhichMapIsOfAnotherSize) {
  expect_problem(compare_spoilt([](const fs::path& fit) {
                   write_exr_rgb(fit / "deep_albedo.exr", Image3(9, 8, Vec3(1, 1, 1)));
                 }),
                 "deep_albedo.exr is 8x9, expected 20x20");
}

TEST(Compare, ExitsWithOneAndSaysWhichMapAnswersTooLittle) {
  expect_problem(compare_spoilt([](const fs::path& fit) {
                   write_exr_rgb(fit / "deep_ld.exr", Image3(20, 20, Vec3::all(kNaN)));
                 }),
                 "deep_ld.exr answers 0.0 %");
}

void expect_bad_input(const testing::Outcome& outcome, const std::string& file) {
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.complaints().size(), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find(file), std::string::npos) << outcome.err;
}

// Failure: a map that could not be read was as one that is missing.
TEST(Compare, ExitsWithTwoWhereAMapOrAViewIsDamaged) {
  expect_bad_input(compare_spoilt([](const fs::path& fit) {
                     const fs::path views = fit.parent_path() / "truth/views";
                     write_exr_rgb(views / "side.exr", Image3(20, 20, Vec3(1, 1, 1)));
                     write_whole_text(fit / "views/side.exr", "not an image");
                   }),
                   "views/side.exr");
  expect_bad_input(compare_spoilt([](const fs::path& fit) {
                     std::fstream map(fit / "deep_albedo.exr",
                                      std::ios::in | std::ios::out | std::ios::binary);
                     map.seekg(-5, std::ios::end);
                     const char flipped = char(map.get() ^ 4);
                     map.seekp(-5, std::ios::end);
                     map.put(flipped);
                   }),
                   "deep_albedo.exr");
}

TEST(Compare, ExitsWithOneWhereAViewIsOfAnotherSize) {
  expect_problem(compare_spoilt([](const fs::path& fit) {
                   const fs::path views = fit.parent_path() / "truth/views";
                   write_exr_rgb(views / "side.exr", Image3(20, 20, Vec3(1, 1, 1)));
                   write_exr_rgb(fit / "views/side.exr", Image3(9, 8, Vec3(1, 1, 1)));
                 }),
                 "views/side.exr: 8x9 pixels, expected 20x20");
}

TEST(Compare, ExitsWithTwoWhereTheFolderIsNoFit) {
  const testing::Outcome outcome =
      compare_spoilt([](const fs::path& fit) { fs::remove(fit / "layers.json"); });
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("no layers.json"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace lamella::apps
