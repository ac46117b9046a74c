// The bench: what every setting of a knob costs and brings, as table, document and page.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "apps/bench_chart.h"
#include "apps/bench_figures.h"
#include "apps/run_lamella.h"
#include "io/fake_session.h"
#include "io/json_tree.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using apps::Bench;
using apps::BenchPoint;
using testing::Outcome;
using testing::run_lamella;

class BenchCommand : public ::testing::Test {
 protected:
  BenchCommand() { testing::write_fake_session(session(), kSize); }

  fs::path session() const { return scratch_.path() / "session"; }
  fs::path out() const { return scratch_.path() / "bench"; }

  Outcome bench(const std::string& knob) const {
    return run_lamella(
        {"bench", session().string(), "--knob", knob, "--rounds", "1", "--out", out().string()});
  }

  void refused(const std::string& knob, const std::string& named) const {
    const std::set<std::string> before = scratch_.contents();
    const Outcome outcome = bench(knob);
    EXPECT_EQ(outcome.exit_code, 2);
    ASSERT_EQ(outcome.complaints().size(), 1u) << outcome.err;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
    EXPECT_EQ(scratch_.contents(), before);
  }

  const cv::Size kSize{96, 128};
  testing::ScratchFolder scratch_;
};

// What stands in place of a truth here is the default's own fit.
TEST_F(BenchCommand, WritesALineAPointAndARowForEverySettingOfAKnob) {
  run_lamella({"fit", session().string(), "--out", (session() / "truth").string()});
  const Outcome outcome = bench("bin_px");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto report = json_tree(read_text(out() / "bench.json"));
  ASSERT_EQ(report["points"].size(), 4u);
  for (const auto& point : report["points"]) {
    EXPECT_EQ(point["default"], point["value"] == "1");
    EXPECT_EQ(point["figures"]["diffuse_normal_median_deg"] == 0.0, point["value"] == "1");
    EXPECT_GT(point["of_default"], 0);
  }
  std::istringstream table(read_text(out() / "bench.csv"));
  int lines = 0;
  for (std::string line; std::getline(table, line); ++lines) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 5 + long(apps::bench_figures().size()));
  }
  EXPECT_EQ(lines, 5);
  EXPECT_TRUE(read_text(out() / "bench.svg").ends_with("</svg>\n"));
  EXPECT_FALSE(fs::exists(out() / "fit"));
}

TEST_F(BenchCommand, RefusesASessionWithoutItsTruth) { refused("bin_px", "no truth"); }

TEST_F(BenchCommand, RefusesAKnobThatIsNoneAndNamesThem) {
  refused("bins", "bin_px, occlusion_rounds");
}

Bench two_points() {
  Bench bench;
  bench.default_seconds = {4, 2, 3};
  bench.default_figures = std::vector<double>(apps::bench_figures().size(), 0.5);
  fit::Quality half;
  half.bin_px = 2;
  bench.points = {{"bin_px", "1", {}, bench.default_seconds, bench.default_figures},
                  {"bin_px", "2", half, {5, 1, 2}, bench.default_figures}};
  bench.points[1].figures[1] = std::numeric_limits<double>::quiet_NaN();
  return bench;
}

TEST(Bench, TellsSecondsOfTheRoundThatWasDisturbedLeast) {
  const Bench bench = two_points();
  EXPECT_DOUBLE_EQ(bench.relative_seconds(bench.points[1]), 0.5);
}

TEST(Bench, LeavesAFigureThatAFitDoesNotHaveEmptyInItsTableAndOutOfItsPage) {
  const Bench bench = two_points();
  EXPECT_NE(apps::bench_csv(bench).find("bin_px,2,0,1,2,0.5,0.5,,0.5"), std::string::npos)
      << apps::bench_csv(bench);
  const std::string page = apps::bench_chart(
      bench, {{"bin_px", "pixels", {{"1", {}}, {"2", bench.points[1].quality}}}}, "a < b");
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_NE(page.find("a &lt; b"), std::string::npos);
}

// Each knob has its default, and no setting twice: else a page marks none, or two.
TEST(Bench, HasTheDefaultOnceAmongTheSettingsOfEveryKnob) {
  for (const apps::Knob& knob : apps::bench_knobs()) {
    const auto defaults =
        std::count_if(knob.settings.begin(), knob.settings.end(),
                      [](const apps::BenchSetting& s) { return apps::is_default(s.quality); });
    EXPECT_EQ(defaults, 1) << knob.name;
  }
}

}  // namespace
}  // namespace lamella
