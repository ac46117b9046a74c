// The bench: what every setting of a knob costs and brings, as table, document and page.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "apps/bench_chart.h"
#include "apps/bench_choice.h"
#include "apps/bench_figures.h"
#include "apps/bench_knee.h"
#include "apps/run_lamella.h"
#include "base/error.h"
#include "io/fake_session.h"
#include "io/json.h"
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
  testing::write_fake_session(session(), cv::Size(320, 424));  // resolves blocks of 2
  run_lamella({"fit", session().string(), "--out", (session() / "truth").string()});
  const Outcome outcome = bench("bin_px");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  v1::Bench report;
  read_json(out() / "bench.json", &report);
  ASSERT_EQ(report.points_size(), 2);
  for (const v1::BenchPoint& point : report.points()) {
    const auto error_deg = point.figures().find("diffuse_normal_median_deg");
    const bool is_exact = error_deg != point.figures().end() && error_deg->second == 0;
    EXPECT_EQ(is_exact, point.value() == "1");
    EXPECT_EQ(point.is_default(), point.value() == "1");
    EXPECT_GT(point.of_default(), 0);
  }
  std::istringstream table(read_text(out() / "bench.csv"));
  int lines = 0;
  for (std::string line; std::getline(table, line); ++lines) {
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 5 + long(apps::bench_figures().size()));
  }
  EXPECT_EQ(lines, 3);
  const auto position =
      std::find_if(report.confidence().begin(), report.confidence().end(),
                   [](const v1::BenchConfidence& c) { return c.map() == "position"; });
  ASSERT_NE(position, report.confidence().end());
  EXPECT_EQ(position->error_unit(), "mm");
  ASSERT_GT(position->bins_size(), 1);
  EXPECT_EQ(position->bins(0).error_p95(), 0);
  EXPECT_GT(position->bins(1).confidence_least(), position->bins(0).confidence_mean());
  const std::string page = read_text(out() / "bench.svg");
  EXPECT_TRUE(page.ends_with("</svg>\n"));
  EXPECT_NE(page.find(">position, mm"), std::string::npos);
  EXPECT_FALSE(fs::exists(out() / "fit"));
  const std::string table_file = (out() / "bench.json").string();
  const Outcome fit = run_lamella(
      {"fit", session().string(), "--bench", table_file, "--max-error", "position_rms_mm<=0"});
  EXPECT_LE(fit.exit_code, 1) << fit.err;
  EXPECT_NE(fit.err.find("fitting with standard"), std::string::npos) << fit.err;
}

TEST_F(BenchCommand, LeavesOutBlocksThatDoNotResolveThePatterns) {
  run_lamella({"fit", session().string(), "--out", (session() / "truth").string()});
  const Outcome outcome = bench("bin_px");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("bin_px 2 is left out"), std::string::npos) << outcome.err;
  v1::Bench report;
  read_json(out() / "bench.json", &report);
  ASSERT_EQ(report.points_size(), 1);
  EXPECT_EQ(report.points(0).value(), "1");
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
      bench, {{"bin_px", "pixels", {{"1", {}}, {"2", bench.points[1].quality}}}}, {}, "a < b");
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_NE(page.find("a &lt; b"), std::string::npos);
}

std::string page_of(const Bench& bench) {
  return apps::bench_chart(bench, {{"bin_px", "pixels", {{"1", {}}}}}, {}, "a face");
}

// Middles of the labels of that size that stand alone.
double label_x(const std::string& page, const std::string& words) {
  const size_t end = page.find(">" + words + "</text>");
  const size_t begin = page.rfind("<text x=\"", end);
  EXPECT_NE(end, std::string::npos) << words;
  return std::stod(page.substr(begin + 9));
}

TEST(Bench, KeepsTheValuesOfAKnobApartWhereOneStallsAndTheRestAreAllAsQuick) {
  Bench bench = two_points();
  bench.points.resize(1);
  const std::vector<std::string> values{"1500", "3000", "6000", "12000", "24000", "48000"};
  for (const std::string& value : values) {
    fit::Quality quality;
    quality.lobe_samples = std::stoi(value) + 1;
    const double seconds = value == "48000" ? 60 : 2;
    bench.points.push_back(
        {"bin_px", value, quality, std::vector<double>(3, seconds), bench.default_figures});
  }
  const std::string page = page_of(bench);
  for (size_t i = 1; i < values.size(); ++i) {
    EXPECT_GT(label_x(page, values[i]) - label_x(page, values[i - 1]), 24) << values[i];
  }
}

TEST(Bench, TellsWhetherADefaultSitsAtTheKneeAndWhatTheOthersWouldCost) {
  Bench bench = two_points();
  apps::Knee knee = apps::knee_of(bench, "bin_px");
  EXPECT_FALSE(knee.is_there);
  EXPECT_EQ(knee.words, "2: 50 % quicker, the same error");
  EXPECT_NE(page_of(bench).find(">1 is not at the knee<"), std::string::npos);
  EXPECT_NE(page_of(bench).find("not: bin_px<"), std::string::npos);
  for (double& figure : bench.points[1].figures) figure *= 3;
  knee = apps::knee_of(bench, "bin_px");
  EXPECT_TRUE(knee.is_there);
  EXPECT_EQ(knee.words, "2: 50 % quicker, 3.0 times the error");
  EXPECT_NE(page_of(bench).find(">1 is at the knee<"), std::string::npos);
}

TEST(Bench, TakesNoDifferenceOfRoundsForAGain) {
  Bench bench = two_points();
  bench.points[1].seconds = {1.7};
  for (double& figure : bench.points[1].figures) figure *= 0.99;
  EXPECT_TRUE(apps::knee_of(bench, "bin_px").is_there);  // rounds took 2 to 4 s
  bench.default_seconds = {2, 2, 2};
  EXPECT_FALSE(apps::knee_of(bench, "bin_px").is_there);
}

TEST(Bench, MarksACurveThatLeavesThePageWithAnArrowAndItsValue) {
  Bench bench = two_points();
  const std::string arrow = "l4 8h-8z";
  EXPECT_EQ(page_of(bench).find(arrow), std::string::npos);
  bench.points[1].figures[9] = 12.5 * bench.default_figures[9];
  bench.points[1].figures[10] = 9 * bench.default_figures[10];
  const std::string page = page_of(bench);
  EXPECT_NE(page.find(arrow), page.rfind(arrow));
  EXPECT_NE(page.find(">shallow albedo 12.5, 1 more above 8<"), std::string::npos);
}

TEST(Bench, PraisesNoDefaultThatNothingWasHeldAgainst) {
  Bench bench = two_points();
  bench.points.pop_back();
  const std::string page = page_of(bench);
  EXPECT_NE(page.find(">No setting but the defaults was fitted"), std::string::npos);
  EXPECT_EQ(page.find("at the knee<"), std::string::npos);
}

TEST(Bench, SpeaksOfTheLeastOfSeveralRoundsAlone) {
  Bench bench = two_points();
  EXPECT_NE(page_of(bench).find("2.00 s, the least of 3 rounds<"), std::string::npos);
  bench.default_seconds = {4};
  EXPECT_NE(page_of(bench).find("4.00 s, one round: other work on the machine may be in it<"),
            std::string::npos);
}

apps::ConfidenceCurve curve_of(const char* map, const char* label, std::vector<double> errors) {
  apps::ConfidenceCurve curve{map, label, "percent", true, {}};
  for (size_t i = 0; i < errors.size(); ++i) {
    curve.bins.push_back({0.1 * double(i), 0.1 * double(i) + 0.05, 50, errors[i], 2 * errors[i]});
  }
  return curve;
}

// Where "words" stand on the page.
double y_of(const std::string& page, const std::string& words) {
  const size_t end = page.find(">" + words + "<");
  if (end == std::string::npos) return std::numeric_limits<double>::quiet_NaN();
  return std::stod(page.substr(page.rfind(" y=\"", end) + 4));
}

TEST(Bench, DrawsErrorAgainstConfidenceWithUnitsAndNoWordsUponOthers) {
  Bench bench = two_points();
  const std::string without = page_of(bench);
  EXPECT_EQ(without.find("confidence"), std::string::npos);
  bench.confidence = {curve_of("deep_albedo", "deep albedo", {8, 4, 2.01}),
                      curve_of("shallow_albedo", "shallow albedo", {8, 4, 2}),
                      curve_of("deep_alpha", "deep alpha", {1, 0, 2})};
  bench.confidence[2].falls = false;
  const std::string page = page_of(bench);
  EXPECT_EQ(page.find("nan"), std::string::npos);
  EXPECT_EQ(page.find("inf"), std::string::npos);
  const double deep = y_of(page, "deep albedo, %"), shallow = y_of(page, "shallow albedo, %"),
               alpha = y_of(page, "deep alpha, %: not ordered");
  EXPECT_GE(std::abs(deep - shallow), 14);
  EXPECT_GE(std::abs(deep - alpha), 14);
  EXPECT_GE(std::abs(shallow - alpha), 14);
  // Its own and that in the legend.
  EXPECT_NE(page.find("stroke-dasharray"), page.rfind("stroke-dasharray"));
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

// A default of 2 s and 0.1 mm, a draft of 1 s and 0.3 mm, a reference of 4 s and 0.08 mm.
v1::Bench table_of_three() {
  v1::Bench table;
  table.set_format("lamella.bench.v1");
  table.set_pixels(1000);
  const auto add = [&](const char* name, double seconds, double error_mm) {
    v1::BenchPoint* point = table.add_points();
    point->set_value(name);
    *point->mutable_quality() = fit::message_from_quality(fit::quality_from_name(name));
    point->set_is_default(std::string(name) == "standard");
    point->add_seconds_s(seconds + 1);
    point->add_seconds_s(seconds);
    (*point->mutable_figures())["position_rms_mm"] = error_mm;
  };
  add("draft", 1, 0.3);
  add("standard", 2, 0.1);
  add("reference", 4, 0.08);
  return table;
}

std::string chosen(uint32_t pixels, std::optional<double> budget_s,
                   const std::optional<apps::FigureLimit>& limit) {
  return apps::choose_setting(table_of_three(), "table", pixels, budget_s, limit).quality.name;
}

std::string refusal(const v1::Bench& table, std::optional<double> budget_s) {
  try {
    apps::choose_setting(table, "table", 1000, budget_s, {});
  } catch (const Error& why) {
    return why.what();
  }
  return "none";
}

TEST(BenchChoice, OfABudgetIsTheLeastErrorWithinIt) {
  EXPECT_EQ(chosen(1000, 1.5, {}), "draft");
  EXPECT_EQ(chosen(1000, 3, {}), "standard");
  EXPECT_EQ(chosen(1000, 60, {}), "reference");
}

TEST(BenchChoice, CountsThePixelsOfTheSessionAtHand) {
  EXPECT_EQ(chosen(2000, 3, {}), "draft");
  EXPECT_EQ(chosen(500, 1, {}), "standard");
}

TEST(BenchChoice, OfALargestErrorIsTheQuickestBelowIt) {
  EXPECT_EQ(chosen(1000, {}, apps::error_limit_from("position_rms_mm<=0.5")), "draft");
  EXPECT_EQ(chosen(1000, {}, apps::error_limit_from("position_rms_mm<=0.1")), "standard");
  EXPECT_EQ(chosen(1000, {}, apps::error_limit_from("position_rms_mm<=0.09")), "reference");
}

TEST(BenchChoice, IsRefusedWhereNothingIsWithinWhatIsAskedAndSaysWhatThereIs) {
  EXPECT_NE(refusal(table_of_three(), 0.5).find("no setting is within 0.5 s; the quickest takes"),
            std::string::npos)
      << refusal(table_of_three(), 0.5);
  EXPECT_THROW(chosen(1000, {}, apps::error_limit_from("position_rms_mm<=0.01")), Error);
  EXPECT_THROW(chosen(1000, 1.5, apps::error_limit_from("position_rms_mm<=0.1")), Error);
  EXPECT_THROW(apps::error_limit_from("beauty<=1"), Error);
  EXPECT_THROW(apps::error_limit_from("position_rms_mm<0.1"), Error);
}

TEST(BenchChoice, IsRefusedFromATableThatIsNoneOrThatNoFitCanBeRunBy) {
  v1::Bench table = table_of_three();
  table.mutable_points(2)->mutable_quality()->set_bin_px(0);
  EXPECT_NE(refusal(table, 60).find("quality.bin_px: 0"), std::string::npos);
  table.mutable_points(0)->clear_seconds_s();
  EXPECT_NE(refusal(table, 60).find("without seconds"), std::string::npos);
  EXPECT_NE(refusal(v1::Bench(), 60).find("is no bench"), std::string::npos);
}

}  // namespace
}  // namespace lamella
