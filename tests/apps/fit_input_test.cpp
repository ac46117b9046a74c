// What render, export and review say to a fit that is not whole: one line, exit 2, nothing written.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/run_lamella.h"
#include "io/fake_fit.h"
#include "io/fake_session.h"
#include "io/json_tree.h"
#include "io/rig_message.h"
#include "io/view.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

const cv::Size kSize(48, 64);

class FittedSession : public ::testing::Test {
 protected:
  FittedSession() {
    testing::write_fake_session(session(), kSize);
    testing::write_fake_fit(session() / "fit", kSize);
    View view;
    view.camera = camera_from_message(testing::fake_calibration(kSize).rig().cameras(0), "fake");
    view.lights.push_back({Light::Kind::kProjector});
    write_view(at("view.json"), view);
  }

  fs::path at(const std::string& name) const { return scratch_.path() / name; }
  fs::path session() const { return at("session"); }

  std::vector<std::vector<std::string>> commands() const {
    const std::string s = session().string();
    return {{"render", s, "--view", at("view.json"), "--out", at("out/image.exr")},
            {"export", s, "--out", at("out/face.glb")},
            {"review", s, "--size", "200x200", "--screenshot", at("out/face.png")}};
  }

  void refused(const std::string& named) const {
    const std::set<std::string> before = scratch_.contents();
    for (const auto& command : commands()) {
      SCOPED_TRACE(command[0]);
      const Outcome outcome = run_lamella(command);
      EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
      ASSERT_EQ(outcome.complaints().size(), 1u) << outcome.err;
      EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
      EXPECT_EQ(scratch_.contents(), before);
    }
  }

  testing::ScratchFolder scratch_;
};

TEST_F(FittedSession, IsRenderedAndExported) {
  for (size_t i = 0; i < 2; ++i) {
    const Outcome outcome = run_lamella(commands()[i]);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_TRUE(fs::exists(commands()[i].back()));
  }
}

TEST_F(FittedSession, IsReportedAsJsonToAProgram) {
  for (size_t i = 0; i < 2; ++i) {
    std::vector<std::string> command = commands()[i];
    command.push_back("--json");
    const Outcome outcome = run_lamella(command);
    const auto report = json_tree(outcome.out);
    EXPECT_EQ(report["file"], commands()[i].back());
    EXPECT_GT(report["seconds"], 0);
    EXPECT_EQ(outcome.err, "");
  }
}

TEST_F(FittedSession, IsExportedUnderANameThatIsNoText) {
  const fs::path named = at("b\xff");
  fs::rename(session(), named);
  const Outcome outcome = run_lamella({"export", named, "--out", at("face.glb"), "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(at("face.glb")));
}

TEST_F(FittedSession, IsNotRenderedOntoAFolder) {
  const Outcome outcome = run_lamella(
      {"render", session(), "--view", at("view.json"), "--out", scratch_.path().string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("is a folder"), std::string::npos) << outcome.err;
}

TEST_F(FittedSession, IsNotRenderedExportedOrShownOverWhatIsRead) {
  std::vector<std::vector<std::string>> all = commands();
  all[1].insert(all[1].end() - 2, {"--for", at("view.json")});
  fs::create_symlink(session() / "fit" / "layers.json", at("link"));
  for (std::vector<std::string>& command : all) {
    SCOPED_TRACE(command[0]);
    std::vector<fs::path> read{session() / "session.json", at("link")};
    if (command[0] != "review") read.push_back(at("view.json"));
    for (const fs::path& file : read) {
      const std::string before = read_text(file);
      command.back() = file;
      const Outcome outcome = run_lamella(command);
      EXPECT_EQ(outcome.exit_code, 2);
      EXPECT_NE(outcome.err.find(file.string() + ": is read by this command"), std::string::npos)
          << outcome.err;
      EXPECT_EQ(read_text(file), before);
    }
  }
}

TEST_F(FittedSession, IsNotRenderedOrExportedOverAPhotograph) {
  const fs::path photograph = session() / read_session(session()).frames.front().file;
  const std::string before = read_text(photograph);
  for (const fs::path& out :
       {photograph, session() / "frames/left/new.exr", session() / "timing.json"}) {
    for (size_t i = 0; i < 2; ++i) {
      std::vector<std::string> command = commands()[i];
      command.back() = out.string();
      const Outcome outcome = run_lamella(command);
      EXPECT_EQ(outcome.exit_code, 2);
      EXPECT_NE(outcome.err.find("belongs to what the rig took"), std::string::npos) << outcome.err;
    }
  }
  EXPECT_EQ(read_text(photograph), before);
}

TEST_F(FittedSession, IsRenderedWhereTheSessionNamesNoRegions) {
  v1::Session manifest;
  read_json(session() / "session.json", &manifest);
  manifest.clear_regions();
  write_json(session() / "session.json", manifest);
  const Outcome outcome = run_lamella(commands()[0]);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(FittedSession, IsRenderedAndExportedWithoutALayerThatWasDropped) {
  v1::Layers layers = testing::fake_layers();
  for (v1::Region& region : *layers.mutable_regions()) {
    region.clear_specular();
    region.mutable_layers()->set_specular(false);
    (*region.mutable_layers()->mutable_why())["specular"] = "within the noise";
  }
  write_json(session() / "fit/layers.json", layers);
  fs::remove(session() / "fit/specular_intensity.exr");
  for (size_t i = 0; i < 2; ++i) {
    const Outcome outcome = run_lamella(commands()[i]);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }
}

TEST_F(FittedSession, IsRefusedWhereARegionLacksALayer) {
  v1::Layers layers = testing::fake_layers();
  layers.mutable_regions(1)->clear_deep();
  write_json(session() / "fit/layers.json", layers);
  refused("layers.json: regions[1].deep: missing");
}

TEST_F(FittedSession, IsRefusedWhereAMapKnowsNothing) {
  write_exr_rgb(session() / "fit/shallow_albedo.exr", Image3(kSize, Vec3::all(kNaN)));
  refused("shallow_albedo.exr: no labelled pixel has a number");
}

TEST_F(FittedSession, IsRefusedWhereTheFitWasNotRunToItsEnd) {
  fs::remove(session() / "fit/total_albedo.exr");
  refused("total_albedo.exr: missing; run fit to its end");
}

TEST_F(FittedSession, IsRefusedWhereTheLabelsAreNoImage) {
  write_whole_text(session() / "fit/regions.png", "not an image");
  refused("regions.png: not a PNG image");
}

TEST_F(FittedSession, IsNotRenderedInASessionOfAnotherSize) {
  testing::write_fake_fit(session() / "fit", cv::Size(40, 64));
  const Outcome outcome = run_lamella(commands()[0]);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("40x64"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace lamella
