// The main job through the real programs: the firmware plays a burst on the simulated rig, the twin
// photographs what its light did, the host receives, fits, compares and exports. And: what goes
// wrong on the rig is seen in the picture.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/process_child.h"
#include "apps/run_lamella.h"
#include "io/json_tree.h"
#include "io/mesh_writer.h"
#include "io/session.h"
#include "io/whole_file.h"

namespace lamella::apps {

namespace {

constexpr double kReady_s = 400;

// One twin for all tests: simulating its skin is the slow part.
class EndToEnd : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new PrivateFolder;
    const std::vector<std::string> arguments{LAMELLA_BINARY,      "twin",
                                             "--serve",           socket(),
                                             "--subject",         "sphere",
                                             "--scale",           "0.2",
                                             "--calibration-out", at("calibration.json"),
                                             "--truth-out",       at("truth")};
    twin_ = new ChildProcess("twin", arguments, folder_->path());
    twin_->wait_for_line({"serving ", kReady_s, "starting"}, [] { return false; });
  }

  static void TearDownTestSuite() {
    delete twin_;
    delete folder_;
  }

  static std::string at(const std::string& name) { return (folder_->path() / name).string(); }
  static std::string socket() { return at("twin.socket"); }

  // A burst on a rig with this fault ("" for none) becomes the session `name`.
  static testing::Outcome capture(const std::string& name, const std::string& fault) {
    std::vector<std::string> arguments{
        (fs::path(LAMELLA_BINARY).parent_path() / "lamella-rigd").string(),
        "--hal",
        "sim",
        "--rig",
        LAMELLA_SIM_RIG,
        "--twin",
        socket(),
        "--calibration",
        at("calibration.json"),
        "--listen",
        "127.0.0.1:0"};
    if (!fault.empty()) arguments.insert(arguments.end(), {"--inject", fault});
    ChildProcess firmware("rigd-" + name, arguments, folder_->path());
    const std::string address =
        firmware.wait_for_line({"listening on ", kReady_s, "starting"}, [] { return false; });
    return testing::run_lamella(
        {"capture", "--rig", address, "--out", at(name), "--flashing-confirmed"});
  }

  // Mean radiance of one photograph.
  static double brightness(const std::string& name, Role role, Analyser analyser) {
    const Session session = read_session(at(name));
    const Photograph p = read_photograph(session, *session.find("left", role, 0, analyser));
    const cv::Scalar sum = cv::mean(p.radiance);
    return (sum[0] + sum[1] + sum[2]) / 3;
  }

 private:
  static inline PrivateFolder* folder_ = nullptr;
  static inline ChildProcess* twin_ = nullptr;
};

}  // namespace

TEST_F(EndToEnd, ABurstIsCapturedFittedComparedAndExported) {
  const testing::Outcome captured = capture("good", "");
  ASSERT_EQ(captured.exit_code, 0) << captured.err;
  fs::copy(at("truth"), at("good") + "/truth", fs::copy_options::recursive);
  const testing::Outcome fit = testing::run_lamella({"fit", at("good")});
  ASSERT_EQ(fit.exit_code, 1) << fit.err;  // at a fifth of its size the patterns are too fine
  EXPECT_NE(fit.err.find("below the quality asked: period of the stripes"), std::string::npos);
  const testing::Outcome compared =
      testing::run_lamella({"compare", at("good") + "/fit", at("good") + "/truth", "--json"});
  // Nobody labelled the photographs, so the regions that the truth names are missing, and nothing
  // else is.
  ASSERT_EQ(compared.exit_code, 1) << compared.err;
  EXPECT_NE(compared.err.find("no region forehead"), std::string::npos) << compared.err;
  const auto figures = json_tree(compared.out);
  for (const std::string problem : figures["problems"]) {
    EXPECT_NE(problem.find("no region"), std::string::npos) << problem;
  }
  EXPECT_LT(figures["position"]["error_mm"]["median"], 0.3);
  EXPECT_LT(figures["normal_specular"]["deg"]["median"], 5.0);
  EXPECT_LT(figures["specular_intensity"]["all"]["rel_rmse"], 0.4);
  EXPECT_EQ(testing::run_lamella({"export", at("good"), "--out", at("face.glb")}).exit_code, 0);
  EXPECT_GT(fs::file_size(at("face.glb")), 1000u);
  auto view = json_tree(read_text(at("truth") + "/views/point_side.json"));
  view["camera"]["translation_mm"] = {5000, 0, 1000};
  std::ofstream(at("beside.json")) << json_text(view, 1);
  const testing::Outcome beside = testing::run_lamella(
      {"render", at("good"), "--view", at("beside.json"), "--out", at("beside.exr")});
  EXPECT_EQ(beside.exit_code, 1);
  EXPECT_NE(beside.err.find("the picture is black"), std::string::npos) << beside.err;
}

TEST_F(EndToEnd, ABurstIsFittedToAMeshAtLeastAsWellAsToItsFringes) {
  ASSERT_EQ(capture("shaped", "").exit_code, 0);
  testing::write_ply(at("shaped.ply"), read_exr_xyz(at("truth") + "/position.exr"), 1, 8);
  const auto figures = [&](std::vector<std::string> extra) {
    std::vector<std::string> fit{"fit", at("shaped")};
    fit.insert(fit.end(), extra.begin(), extra.end());
    EXPECT_LE(testing::run_lamella(fit).exit_code, 1);  // a rim of pixels sees past the mesh
    return json_tree(
        testing::run_lamella({"compare", at("shaped") + "/fit", at("truth"), "--json"}).out);
  };
  const auto fringes = figures({}), mesh = figures({"--mesh", at("shaped.ply")});
  EXPECT_LT(mesh["position"]["error_mm"]["median"], 0.01);
  EXPECT_LT(mesh["position"]["error_mm"]["median"], fringes["position"]["error_mm"]["median"]);
  for (const char* normals : {"normal_specular", "normal_diffuse"}) {
    const auto of = [&](const auto& all) {
      return (all[normals].contains("g") ? all[normals]["g"] : all[normals])["deg"]["median"]
          .template get<double>();
    };
    EXPECT_LE(of(mesh), of(fringes) + 0.01) << normals;
  }
}

TEST_F(EndToEnd, AFlippedBitOnTheLedChainChangesThePhotograph) {
  const testing::Outcome captured = capture("true", "");
  ASSERT_EQ(captured.exit_code, 0) << captured.err;
  // The highest bit of LED 122, which faces the subject: chip 3, output 17 of the rig file. None of
  // its bits is read back before the burst.
  capture("flipped", "flip-bit:936");
  const double change = brightness("flipped", Role::kGradientFull, Analyser::kCross) -
                        brightness("true", Role::kGradientFull, Analyser::kCross);
  EXPECT_GT(std::abs(change), 1e-4);
}

TEST_F(EndToEnd, ALateBlankDarkensThePhotographByItsShareOfTheLight) {
  ASSERT_EQ(capture("punctual", "").exit_code, 0);
  EXPECT_EQ(capture("late", "late-blank:6000").exit_code, 1) << "a late edge marks the burst";
  const double ratio = brightness("late", Role::kGradientFull, Analyser::kCross) /
                       brightness("punctual", Role::kGradientFull, Analyser::kCross);
  EXPECT_NEAR(ratio, 24.0 / 30.0, 0.02);
}

// What it spoils is taken again; the photographs that show it are kept beside the session's own. A
// crossed one has surface reflection in it, a parallel one lacks some: the burst may begin either
// way.
TEST_F(EndToEnd, AnAnalyserStillMovingChangesSurfaceReflectionInWhatItSpoils) {
  ASSERT_EQ(capture("settled", "").exit_code, 0);
  EXPECT_EQ(capture("moving", "slow-actuator:3").exit_code, 1);
  const Session session = read_session(at("settled")), other = read_session(at("moving"));
  double change = 0;
  for (const Frame& spoilt : other.retaken) {
    if (spoilt.camera != "left") continue;
    const Frame* same = session.find("left", spoilt.role, spoilt.index, spoilt.analyser);
    ASSERT_NE(same, nullptr);
    const cv::Scalar difference = cv::mean(read_photograph(other, spoilt).radiance) -
                                  cv::mean(read_photograph(session, *same).radiance);
    const bool crossed = spoilt.analyser == Analyser::kCross;
    change = std::max(change, crossed ? difference[1] : -difference[1]);
  }
  EXPECT_GT(change, 0.005);
}

}  // namespace lamella::apps
