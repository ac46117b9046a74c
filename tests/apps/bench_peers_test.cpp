// Peers of the bench: what is told of one that ran, and of one that this machine does not have.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <memory>

#include "apps/bench_chart.h"
#include "apps/bench_figures.h"
#include "apps/run_lamella.h"
#include "fit/exponential_mixture.h"
#include "fit/layer_profile.h"
#include "io/fake_session.h"
#include "io/json.h"
#include "io/layer_maps.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using apps::Json;
using apps::Peer;
using testing::Outcome;
using testing::run_lamella;

std::vector<double> all_figures(double value) {
  return std::vector<double>(apps::bench_figures().size(), value);
}

// One that took 8 and 6 s against our 3 and 2 s, with four times our error.
Peer slow_peer() {
  Peer peer{"NumPy", "the whole fit", "", {{8, 6}, {5, 4}}, {{3, 2}, {1.5, 1}}, {}, {}};
  peer.figures = all_figures(0.4);
  peer.our_figures = all_figures(0.1);
  return peer;
}

Peer missing_peer() { return {"SciPy", "profiles", "no module <scipy>", {}, {}, {}, {}}; }

TEST(Peers, StandBesideOursWithTheLeastSecondsOfTheRounds) {
  const std::string table = apps::peer_csv({slow_peer(), missing_peer()});
  EXPECT_NE(table.find("\nNumPy,seconds,s,6,2,3\n"), std::string::npos) << table;
  EXPECT_NE(table.find("\nNumPy,seconds_without_files,s,4,1,4\n"), std::string::npos) << table;
  EXPECT_NE(table.find("\nNumPy,ld_rel_error,,0.4,0.1,4\n"), std::string::npos) << table;
  EXPECT_EQ(table.find("SciPy"), std::string::npos);
}

TEST(Peers, ThatDidNotRunAreNamedWithTheReason) {
  const std::string table = apps::peer_table({slow_peer(), missing_peer()});
  EXPECT_NE(table.find("SciPy: did not run: no module <scipy>"), std::string::npos) << table;
  EXPECT_EQ(apps::message_from_peer(missing_peer()).missing(), "no module <scipy>");
}

TEST(Peers, AreMarkedOnThePageWhereTheirErrorIsKnown) {
  Peer peer = slow_peer();
  peer.figures[8] = std::numeric_limits<double>::quiet_NaN();
  apps::Bench bench{{2}, all_figures(0.1), {}, {peer, missing_peer()}, {}};
  const std::string page = apps::bench_chart(bench, {}, {}, "head");
  EXPECT_NE(page.find("deep albedo 40 %"), std::string::npos);
  EXPECT_EQ(page.find("l_d 40 %"), std::string::npos);
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_NE(page.find("SciPy did not run: no module &lt;scipy"), std::string::npos);
}

class PeerCommand : public ::testing::Test {
 protected:
  // What stands in place of a truth is the default's own fit.
  static void SetUpTestSuite() {
    shared_ = std::make_unique<testing::ScratchFolder>();
    testing::write_fake_session(session(), {96, 128});
    run_lamella({"fit", session().string(), "--out", truth().string()});
  }
  static void TearDownTestSuite() { shared_.reset(); }

  static fs::path session() { return shared_->path() / "session"; }
  static fs::path truth() { return session() / "truth"; }

  // With `python3` a script of these lines, or whatever the machine has.
  v1::Bench bench_with(const std::string& python) const {
    const std::string path = getenv("PATH");
    if (!python.empty()) {
      fs::create_directory(scratch_.path() / "bin");
      const fs::path file = scratch_.path() / "bin" / "python3";
      std::ofstream(file) << "#!/bin/sh\n" << python << "\n";
      fs::permissions(file, fs::perms::owner_all);
      setenv("PATH", (file.parent_path().string() + ":" + path).c_str(), 1);
    }
    const fs::path out = scratch_.path() / "bench";
    const Outcome outcome = run_lamella(
        {"bench", session().string(), "--peers", "--rounds", "1", "--out", out.string()});
    setenv("PATH", path.c_str(), 1);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_FALSE(fs::exists(out / "peers"));
    EXPECT_TRUE(fs::exists(out / "bench.svg"));
    v1::Bench report;
    read_json(out / "bench.json", &report);
    EXPECT_EQ(report.peers_size(), 2);
    return report;
  }

  static std::unique_ptr<testing::ScratchFolder> shared_;
  testing::ScratchFolder scratch_;
};

std::unique_ptr<testing::ScratchFolder> PeerCommand::shared_;

// Here the peer's fit is the truth itself.
TEST_F(PeerCommand, CountsAPeersSecondsByItsOwnReportAndItsErrorsByTheFiguresOfOurs) {
  const v1::Bench report = bench_with("cp \"" + truth().string() + "\"/* \"$4\"");
  double all = 0, files = 0;
  const v1::Layers fit = read_layers(truth() / "layers.json");
  for (const auto& [step, seconds] : fit.timings_s()) {
    all += seconds;
    if (step == "write") files += seconds;
  }
  for (const v1::BenchPeer& peer : report.peers()) {
    SCOPED_TRACE(peer.name());
    EXPECT_EQ(peer.missing(), "");
    EXPECT_EQ(peer.its().figures().at("ld_rel_error"), 0);
    EXPECT_GT(peer.ours().without_files_s(0), 0);
  }
  EXPECT_NEAR(report.peers(0).its().seconds_s(0), all, 1e-9);
  EXPECT_NEAR(report.peers(0).its().without_files_s(0), all - files, 1e-9);
  EXPECT_GT(report.peers(0).ours().seconds_s(0), report.peers(0).ours().without_files_s(0));
}

TEST_F(PeerCommand, GoesOnWithoutAPeerThatFailsAndTellsItsLastWords) {
  const v1::Bench report = bench_with("echo first >&2; echo out of memory >&2; exit 1");
  EXPECT_EQ(report.peers(0).missing(), "out of memory");
  EXPECT_EQ(report.peers(1).missing(), "out of memory");
}

TEST_F(PeerCommand, InNumPyFindsTheShape) {
  const v1::BenchPeer numpy = bench_with("").peers(0);
  if (!numpy.missing().empty()) GTEST_SKIP() << "NumPy: " << numpy.missing();
  EXPECT_LT(numpy.its().figures().at("position_median_mm"), 0.5);
  EXPECT_LT(numpy.its().figures().at("diffuse_normal_median_deg"), 15);
}

// A program whose solution is known: x'x - 2w'x is least at w.
Json program_of(const std::string& region, const fit::ExponentialMixture& kernel) {
  constexpr size_t kSize = fit::ExponentialMixture::kSize;
  Json a = Json::array();
  for (size_t i = 0; i < kSize; ++i) {
    std::vector<double> row(kSize, 0.0);
    row[i] = 1;
    a.push_back(row);
  }
  return {{"region", region}, {"a", a}, {"b", kernel.weight}};
}

TEST(Peers, SciPyFindsTheLengthsThatOurSolversFind) {
  testing::ScratchFolder scratch;
  Json document{{"length_mm", Json::array()}, {"programs", Json::array()}};
  for (int k = 0; k < fit::ExponentialMixture::kSize; ++k) {
    document["length_mm"].push_back(fit::ExponentialMixture::length_mm(k));
  }
  std::vector<double> expected_mm;
  for (const size_t length : {20u, 23u, 26u}) {
    fit::ExponentialMixture kernel;
    kernel.weight[length - 8] = 0.4;
    kernel.weight[length] = 0.6;
    document["programs"].push_back(program_of("skin", kernel));
    expected_mm.push_back(fit::fit_deep_profile(kernel, {}).ld_mm);
  }
  write_whole_text(scratch.path() / "programs.json", document.dump());
  const std::string arguments = " \"" LAMELLA_PEERS_DIR "/scipy_profiles.py\" \"" +
                                (scratch.path() / "programs.json").string() + "\" --out \"" +
                                scratch.path().string() + "\"";
  if (std::system(("python3" + arguments).c_str()) != 0 &&
      std::system(("/usr/bin/python3" + arguments).c_str()) != 0) {
    GTEST_SKIP() << "no python3 has SciPy";
  }
  const v1::Layers layers = read_layers(scratch.path() / "layers.json");
  ASSERT_EQ(layers.regions_size(), 1);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(layers.regions(0).deep().ld_mm(i) / expected_mm[size_t(i)], 1, 5e-4);
  }
}

}  // namespace
}  // namespace lamella
