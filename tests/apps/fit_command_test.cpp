// fit judges the photographs as check does: what check calls unusable is refused for the same
// reason, what it calls poor is fitted with a warning and exit 1. So is a layer that cannot be
// judged; a figure at its bound is only named.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "apps/run_lamella.h"
#include "io/fake_session.h"
#include "io/json.h"
#include "io/layer_maps.h"
#include "io/mesh_writer.h"
#include "io/session.h"
#include "io/whole_file.h"
#include "layers.pb.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

class FitCommand : public ::testing::Test {
 protected:
  FitCommand() { testing::write_fake_session(session(), cv::Size(96, 128)); }

  fs::path session() const { return scratch_.path() / "session"; }

  void change(Role role, int index, const std::function<void(Image3*)>& change) const {
    const Session read = read_session(session());
    const fs::path file = session() / read.find("left", role, index, Analyser::kCross)->file;
    Image3 image = read_exr_rgb(file);
    change(&image);
    write_exr_rgb(file, image);
  }

  void shrink_lips_to_a_speck() const {
    const std::string file = (session() / "regions.png").string();
    cv::Mat1b labels = cv::imread(file, cv::IMREAD_UNCHANGED);
    labels.setTo(1, labels == 2);
    labels(cv::Rect(48, 90, 3, 3)) = uchar(2);
    cv::imwrite(file, labels);
  }

  // Behind "lips: deep: ", which may name more than one of each.
  static std::string why_of(const std::string& reason) {
    return reason.substr(reason.find(": ", reason.find(": ") + 2) + 2);
  }

  // "lips: deep: ..." of every region and layer that layers.json gives one for.
  std::set<std::string> reasons_of_report() const {
    v1::Layers layers;
    read_json(session() / "fit/layers.json", &layers);
    std::set<std::string> reasons;
    for (const v1::Region& region : layers.regions()) {
      for (const auto& [layer, why] : region.layers().why()) {
        reasons.insert(region.name() + ": " + layer + ": " + why);
      }
    }
    return reasons;
  }

  Outcome run(const char* command) const { return run_lamella({command, session().string()}); }

  testing::ScratchFolder scratch_;
};

bool is_of_a_bound_or_misfit(const std::string& reason) {
  return reason.ends_with(", is the fit's own bound") || reason.ends_with("it hardly tells l_d");
}

// Too coarse for the dots, the fake session takes figures of its layers to their bounds, or its
// kernels off any dipole's. Which, hangs on noise; there is no other word.
TEST_F(FitCommand, FitsAGoodSessionAndNamesOnlyFiguresAtTheirBoundsAndKernelsThatAreOff) {
  const Outcome fit = run("fit");
  EXPECT_EQ(fit.exit_code, 0);
  const std::string warning = "lamella: warning: ";
  const std::set<std::string> reasons = reasons_of_report();
  std::set<std::string> whys;
  for (const std::string& reason : reasons) {
    EXPECT_EQ(is_of_a_bound_or_misfit(reason), fit.err.find(why_of(reason)) != std::string::npos)
        << reason;
    if (is_of_a_bound_or_misfit(reason)) {
      EXPECT_NE(fit.out.find("\n" + reason + "\n"), std::string::npos) << reason << fit.out;
    }
    whys.insert(why_of(reason));
  }
  std::istringstream lines(fit.err);
  for (std::string line; std::getline(lines, line);) {
    ASSERT_TRUE(line.starts_with(warning) && is_of_a_bound_or_misfit(line)) << line;
    EXPECT_EQ(whys.count(why_of(line.substr(warning.size()))), 1u) << line;
  }
}

TEST_F(FitCommand, FitsARegionWithoutADotWithAWarningAndExitsWithOne) {
  shrink_lips_to_a_speck();
  const Outcome fit = run("fit");
  EXPECT_EQ(run("check").exit_code, 0);
  EXPECT_EQ(fit.exit_code, 1);
  const std::string named = "lips: deep: no dot of the pattern lies on it: its neighbours' values";
  EXPECT_NE(fit.err.find("lamella: warning: below the quality asked: lips: deep, shallow: " +
                         why_of(named) + "\n"),
            std::string::npos)
      << fit.err;
  EXPECT_TRUE(fit.complaints().empty()) << fit.err;
  EXPECT_NE(fit.out.find("\n" + named + "\n"), std::string::npos) << fit.out;
  EXPECT_EQ(reasons_of_report().count(named), 1u);
}

// Failure: whoever read the report alone took for good what had a warning and exit code 1.
TEST_F(FitCommand, HasItsWarningsInTheReportToo) {
  shrink_lips_to_a_speck();
  const Outcome fit = run("fit");
  v1::Layers layers;
  read_json(session() / "fit/layers.json", &layers);
  std::string told;
  bool any_below = false;
  for (const v1::Warning& warning : layers.warnings()) {
    told += "lamella: warning: ";
    told += warning.below_quality_asked() ? "below the quality asked: " : "";
    told += warning.text() + "\n";
    any_below = any_below || warning.below_quality_asked();
  }
  EXPECT_EQ(told, fit.err);
  EXPECT_TRUE(any_below);
}

TEST_F(FitCommand, RefusesForTheReasonOfCheckAndLeavesNothing) {
  change(Role::kStripes, 2, [](Image3* i) { i->setTo(cv::Scalar::all(0)); });
  const std::set<std::string> before = scratch_.contents();
  const Outcome check = run("check"), fit = run("fit");
  EXPECT_EQ(check.exit_code, 2);
  EXPECT_EQ(fit.exit_code, 2);
  EXPECT_EQ(fit.err, check.err);
  EXPECT_EQ(fit.complaints().size(), 1u);
  EXPECT_NE(fit.err.find("left STRIPES 2 CROSS"), std::string::npos) << fit.err;
  EXPECT_EQ(scratch_.contents(), before);
}

TEST_F(FitCommand, FitsADraftAtTheSizeOfThePhotographsAndSaysWhatItSpent) {
  testing::write_fake_session(session(), cv::Size(320, 424));
  const Outcome fit = run_lamella({"fit", session().string(), "--quality", "draft"});
  EXPECT_LE(fit.exit_code, 1) << fit.err;
  EXPECT_TRUE(fit.complaints().empty()) << fit.err;
  EXPECT_EQ(fit.err.find("would not resolve"), std::string::npos) << fit.err;
  EXPECT_EQ(read_layer_maps(session() / "fit").normal_specular.size(), cv::Size(320, 424));
  v1::Layers layers;
  read_json(session() / "fit/layers.json", &layers);
  EXPECT_EQ(layers.quality().name(), "draft");
  EXPECT_EQ(layers.quality().bin_px(), 2u);
}

TEST_F(FitCommand, TakesADraftsBlocksNoLargerThanThePatternsAllowAndSaysSo) {
  const Outcome fit = run_lamella({"fit", session().string(), "--quality", "draft"});
  EXPECT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_NE(
      fit.err.find("lamella: warning: blocks of 2 x 2 pixels would not resolve the patterns (a "
                   "period of the stripes is 1.5 pixels, a dot 3.8): fitted pixel by pixel\n"),
      std::string::npos)
      << fit.err;
  v1::Layers layers;
  read_json(session() / "fit/layers.json", &layers);
  EXPECT_EQ(layers.quality().bin_px(), 1u);
}

TEST_F(FitCommand, TrustsNoMapOfPatternsThatThePixelsAreTooCoarseFor) {
  v1::Session manifest;
  read_json(session() / "session.json", &manifest);
  manifest.mutable_patterns()->mutable_stripes()->set_period_px(6);
  write_json(session() / "session.json", manifest);
  const Outcome fit = run("fit");
  EXPECT_EQ(fit.exit_code, 1);
  EXPECT_NE(fit.err.find("below the quality asked: period of the stripes: 1.15 pixels"),
            std::string::npos)
      << fit.err;
  const LayerMaps maps = read_layer_maps(session() / "fit");
  for (const char* map : {"shallow_albedo", "deep_albedo", "deep_alpha"}) {
    EXPECT_EQ(cv::countNonZero(maps.confidence.at(map)), 0) << map;
  }
  EXPECT_GT(cv::countNonZero(maps.confidence.at("total_albedo")), 0);
}

TEST_F(FitCommand, PutsADashWhereAStepThatWasNotRunWouldHaveTold) {
  const Outcome fit = run_lamella({"fit", session().string(), "--until", "specular"});
  ASSERT_LE(fit.exit_code, 1) << fit.err;
  std::istringstream row(fit.out.substr(fit.out.find("\nskin") + 1));
  std::string name, m, ld, alpha_dot, single;
  row >> name >> m >> ld >> alpha_dot >> single;
  EXPECT_NE(m, "-") << fit.out;
  EXPECT_EQ(ld, "-") << fit.out;
  EXPECT_EQ(alpha_dot, "-") << fit.out;
  EXPECT_NE(single, "-") << fit.out;
}

TEST_F(FitCommand, LeavesNothingWhereAFileGrowsBeyondWhatIsAllowed) {
  const std::set<std::string> before = scratch_.contents();
  rlimit usual{};
  getrlimit(RLIMIT_FSIZE, &usual);
  const rlimit small{16 << 10, usual.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);  // the child's too
  const Outcome fit = run("fit");
  setrlimit(RLIMIT_FSIZE, &usual);
  EXPECT_EQ(fit.exit_code, 2);
  ASSERT_EQ(fit.complaints().size(), 1u) << fit.err;
  EXPECT_NE(fit.err.find("File too large"), std::string::npos) << fit.err;
  EXPECT_EQ(scratch_.contents(), before);
}

TEST_F(FitCommand, RefusesALabelImageThatIsNotOfThisSessionAndLeavesNothing) {
  const std::string png = (scratch_.path() / "painted.png").string();
  cv::imwrite(png, cv::Mat1b(30, 24, uchar(1)));
  const Outcome fit = run_lamella({"fit", session().string(), "--regions", png});
  EXPECT_EQ(fit.exit_code, 2);
  ASSERT_EQ(fit.complaints().size(), 1u) << fit.err;
  EXPECT_NE(fit.err.find("painted.png: 24x30"), std::string::npos) << fit.err;
  EXPECT_FALSE(fs::exists(session() / "fit"));
}

TEST_F(FitCommand, RefusesALabelImageThatIsDamagedInOneLine) {
  const fs::path png = session() / "regions.png";
  std::fstream(png, std::ios::in | std::ios::out | std::ios::binary).seekp(60).put('\x55');
  const Outcome fit = run_lamella({"fit", session().string()});
  EXPECT_EQ(fit.exit_code, 2);
  EXPECT_EQ(fit.err, "lamella: " + png.string() + ": damaged PNG image; copy it again\n");
}

TEST_F(FitCommand, RefusesAQualityThatIsNoneAndNamesThem) {
  const std::set<std::string> before = scratch_.contents();
  const Outcome fit = run_lamella({"fit", session().string(), "--quality", "best"});
  EXPECT_EQ(fit.exit_code, 2);
  ASSERT_EQ(fit.complaints().size(), 1u) << fit.err;
  EXPECT_NE(fit.err.find("draft, standard, reference"), std::string::npos) << fit.err;
  EXPECT_EQ(scratch_.contents(), before);
}

class FitOfAMesh : public FitCommand {
 protected:
  FitOfAMesh() {
    testing::leave_out(session(), [](const v1::Frame& f) {
      return f.camera() == "right" || f.role() == v1::Frame::FRINGE;
    });
  }

  fs::path mesh() const { return scratch_.path() / "face.ply"; }

  // The sphere that was photographed, as a camera in front of it would see it, in these units.
  void write_mesh(float units_a_mm) const {
    Image3 seen(kMeshSide, kMeshSide, Vec3::all(kNaN));
    for (int y = 0; y < kMeshSide; ++y) {
      for (int x = 0; x < kMeshSide; ++x) {
        const Vec2 at(float(x - kMeshSide / 2), float(kMeshSide / 2 - y));
        const float square = kSphereMm * kSphereMm - at.dot(at);
        if (square > 0) seen(y, x) = Vec3(at[0], at[1], std::sqrt(square)) * units_a_mm;
      }
    }
    testing::write_ply(mesh(), seen, 1, 20 * units_a_mm);
  }

  Outcome fit(const fs::path& mesh) const {
    return run_lamella({"fit", session().string(), "--mesh", mesh.string()});
  }

  void expect_refused(const Outcome& outcome, const std::vector<std::string>& named) const {
    EXPECT_EQ(outcome.exit_code, 2);
    ASSERT_EQ(outcome.complaints().size(), 1u) << outcome.err;
    for (const std::string& part : named) {
      EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    }
    EXPECT_FALSE(fs::exists(session() / "fit"));
  }

  static constexpr int kMeshSide = 141;
  static constexpr float kSphereMm = 60;
};

TEST_F(FitOfAMesh, NeedsNeitherFringesNorARightCameraAndSaysSoInTheReport) {
  write_mesh(1);
  const Outcome outcome = fit(mesh());
  EXPECT_LE(outcome.exit_code, 1) << outcome.err;
  EXPECT_TRUE(outcome.complaints().empty()) << outcome.err;
  v1::Layers layers;
  read_json(session() / "fit/layers.json", &layers);
  EXPECT_EQ(layers.geometry().kind(), v1::GeometrySource::MESH);
  EXPECT_EQ(layers.geometry().mesh(), mesh().string());
  EXPECT_GT(layers.geometry().triangles(), 10000u);
  EXPECT_GT(layers.geometry().covered(), 0.9);
  const Image3 position_mm = read_layer_maps(session() / "fit").position_mm;
  EXPECT_NEAR(length(position_mm(64, 48)), kSphereMm, 0.02);
}

TEST_F(FitOfAMesh, TakesWhatExportWrote) {
  write_mesh(1);
  ASSERT_LE(fit(mesh()).exit_code, 1);
  const fs::path exported = scratch_.path() / "face.glb";
  fs::copy_file(session() / "fit/model.glb", exported);
  const Outcome outcome = fit(exported);
  EXPECT_TRUE(outcome.complaints().empty()) << outcome.err;
  const Image3 position_mm = read_layer_maps(session() / "fit").position_mm;
  EXPECT_NEAR(length(position_mm(64, 48)), kSphereMm, 0.5);
}

TEST_F(FitOfAMesh, IsAskedForWhereThereAreNoFringes) {
  expect_refused(run("fit"), {"no FRINGE 0 CROSS of the left camera", "fit --mesh FILE"});
}

TEST_F(FitOfAMesh, RefusesWhatIsNoMeshOfTheSubject) {
  expect_refused(fit(mesh()), {mesh().string() + ": no such file"});
  write_whole_text(mesh(), "no mesh at all");
  expect_refused(fit(mesh()), {mesh().string() + ": no triangle in it"});
  write_mesh(1e-3f);
  expect_refused(fit(mesh()),
                 {"0.118 x 0.118 x 0.0574 mm", "the subject 1000 mm", "in millimetres"});
}

TEST_F(FitOfAMesh, DoesNotReplaceTheMesh) {
  write_mesh(1);
  ASSERT_LE(fit(mesh()).exit_code, 1);
  const Outcome outcome = fit(session() / "fit/model.glb");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("is in the folder that the fit replaces"), std::string::npos)
      << outcome.err;
  EXPECT_TRUE(fs::exists(session() / "fit/model.glb"));
}

TEST_F(FitCommand, RefusesRegionsInTheFolderThatItReplaces) {
  ASSERT_LE(run("fit").exit_code, 1);
  const fs::path painted = session() / "fit/painted.png";
  fs::copy(session() / "fit/regions.png", painted);
  const Outcome outcome = run_lamella({"fit", session().string(), "--regions", painted.string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("is in the folder that the fit replaces"), std::string::npos)
      << outcome.err;
  EXPECT_TRUE(fs::exists(painted));
}

TEST_F(FitCommand, SaysThatTheRightCameraIsNotInItsGeometry) {
  testing::leave_out(session(), [](const v1::Frame& f) { return f.camera() == "right"; });
  EXPECT_LE(run("fit").exit_code, 1);
  v1::Layers layers;
  read_json(session() / "fit/layers.json", &layers);
  EXPECT_EQ(layers.geometry().kind(), v1::GeometrySource::LEFT_PROJECTOR);
  EXPECT_NE(run("check").out.find("photographs missing of the right camera"), std::string::npos);
}

// A fit that is killed in the middle.
void be_killed_while_filling(const fs::path& place) {
  const pid_t child = fork();
  if (child == 0) {
    const WholeFolder folder(place);
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
}

TEST_F(FitCommand, RemovesWhatAKilledFitLeftAndSaysSo) {
  const auto before = scratch_.contents();
  be_killed_while_filling(session() / "fit");
  EXPECT_NE(scratch_.contents(), before);
  const Outcome fit = run_lamella({"fit", session().string(), "--until", "linearise"});
  EXPECT_NE(fit.err.find("lamella: " + session().string() +
                         ": removed 1 half-written output that a run that was killed"),
            std::string::npos)
      << fit.err;
  for (const auto& entry : fs::directory_iterator(session())) {
    EXPECT_FALSE(entry.path().filename().string().starts_with(".")) << entry.path();
  }
}

TEST_F(FitCommand, FitsAPoorSessionWithAWarningAndExitsWithOne) {
  change(Role::kBlack, 0, [](Image3* i) { *i *= 8; });
  const Outcome fit = run("fit");
  EXPECT_EQ(run("check").exit_code, 1);
  EXPECT_EQ(fit.exit_code, 1) << fit.err;
  EXPECT_NE(fit.err.find("warning: below the quality asked: projector black level: "),
            std::string::npos)
      << fit.err;
  EXPECT_TRUE(fs::exists(session() / "fit/layers.json"));
}

}  // namespace
}  // namespace lamella
