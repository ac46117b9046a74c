// lamella rig plan, as a rig builder runs it.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "apps/counted.h"
#include "apps/run_lamella.h"
#include "io/fake_session.h"
#include "io/json_tree.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

TEST(RigPlan, TellsOrderWaitsAndBudgetOfEveryRigThatShips) {
  for (const std::string name : {"sim", "slr", "machine_vision"}) {
    const Outcome outcome = run_lamella({"rig", "plan", "--rig-file", name, "--json"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto report = json_tree(outcome.out);
    EXPECT_EQ(report["steps"].size(), 20u);
    double sum_us = 0;
    for (const auto& [term, us] : report["terms_us"].items()) sum_us += us.get<double>();
    EXPECT_NEAR(sum_us, report["duration_us"].get<double>(), 1) << name;
    EXPECT_LE(report["least_duration_us"], report["duration_us"]) << name;
    EXPECT_LE(report["least_cost_us"], report["cost_us"]) << name;
    EXPECT_GT(report["least_cost_us"], report["least_duration_us"]) << name;
    for (const char* source : {"leds_dose", "projector_dose"}) {
      const auto& dose = report["budget"][source];
      const double bursts = std::floor(1e6 / dose["blue_j_per_m2_sr"].get<double>());
      EXPECT_EQ(dose["bursts_per_day"], bursts) << name << " " << source;
      EXPECT_LT(dose["thermal_share"], 1) << name << " " << source;
    }
  }
}

TEST(RigPlan, WritesAChartAndEdgesForALogicAnalyser) {
  const testing::ScratchFolder folder;
  const std::string svg = folder.path() / "plan.svg", vcd = folder.path() / "plan.vcd";
  ASSERT_EQ(run_lamella({"rig", "plan", "--svg", svg, "--vcd", vcd}).exit_code, 0);
  EXPECT_NE(read_text(svg).find("STRIPES 3"), std::string::npos);
  EXPECT_NE(read_text(vcd).find(" BLANK $end"), std::string::npos);
}

TEST(RigPlan, DrawsATriggerThatIsActiveLowAsAProbeSeesIt) {
  const testing::ScratchFolder folder;
  const fs::path file = folder.path() / "low.rig", vcd = folder.path() / "low.vcd";
  fs::copy_file(fs::path(LAMELLA_BOARD_DIR) / "dome150.leds", folder.path() / "dome150.leds");
  std::ofstream(file) << read_text(fs::path(LAMELLA_BOARD_DIR) / "sim.rig")
                      << "camera.trigger_active = low\n";
  const Outcome outcome = run_lamella({"rig", "plan", "--rig-file", file, "--vcd", vcd});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("TRIGGER's line is 0 while the cameras expose"), std::string::npos);
  const std::string text = read_text(vcd);
  const size_t name = text.find(" TRIGGER $end");
  ASSERT_NE(name, std::string::npos);
  const std::string rest = std::string("\n1") + text[name - 1] + "\n";
  EXPECT_LT(text.find(rest), text.find("$end", text.find("$dumpvars"))) << "it rests at 1";
}

TEST(RigPlan, ListsTheRigsThatShipWhereThereIsNoneOfThatName) {
  for (const std::string name : {"nosuch", "/nowhere/my.rig"}) {
    const Outcome outcome = run_lamella({"rig", "plan", "--rig-file", name});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("--rig-file: \"" + name + "\": no such file; rigs that ship: "),
              std::string::npos)
        << outcome.err;
    EXPECT_NE(outcome.err.find("machine_vision, pi4, pi5, sim, slr"), std::string::npos)
        << outcome.err;
  }
}

TEST(RigPlan, HelpNamesEveryRigThatShipsAndNoOther) {
  const Outcome wrong = run_lamella({"rig", "plan", "--rig-file", "nosuch"});
  const std::string before = "rigs that ship: ";
  const size_t at = wrong.err.find(before) + before.size();
  std::string list = wrong.err.substr(at, wrong.err.find('\n') - at), help;
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"rig", "plan", "--help"}, {"capture", "--help"}}) {
    help = std::regex_replace(run_lamella(command).out, std::regex("\\s+"), " ");
    EXPECT_NE(help.find(list), std::string::npos) << list << "\n" << help;
  }
  for (const auto& entry : fs::directory_iterator(LAMELLA_BOARD_DIR)) {
    const std::string name = entry.path().stem().string();
    const bool is_named = (", " + list + ",").find(", " + name + ",") != std::string::npos;
    EXPECT_EQ(is_named, entry.path().extension() == ".rig") << entry.path();
  }
}

TEST(RigPlan, NumbersHaveNoBinaryNoiseAndOneOfAThingIsNoPlural) {
  const Outcome json = run_lamella({"rig", "plan", "--rig-file", "sim", "--json"});
  std::smatch noisy;
  const std::regex noise("[.][0-9]*(0000000|9999999)[0-9]");
  EXPECT_FALSE(std::regex_search(json.out, noisy, noise)) << noisy.str();
  EXPECT_EQ(apps::counted(1, "burst") + ", " + apps::counted(2, "burst"), "1 burst, 2 bursts");
}

TEST(RigPlan, WaitsForNoPipeInPlaceOfARigFile) {
  const testing::ScratchFolder folder;
  const fs::path pipe = folder.path() / "pipe.rig";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const Outcome outcome = run_lamella({"rig", "plan", "--rig-file", pipe});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("not a plain file"), std::string::npos) << outcome.err;
}

TEST(RigPlan, NamesFileLineAndKeyOfAWrongRigFile) {
  const testing::ScratchFolder folder;
  const fs::path file = folder.path() / "wrong.rig";
  std::ofstream(file) << "# mine\nleds.spi_mhz = 10\n";
  const Outcome outcome = run_lamella({"rig", "plan", "--rig-file", file});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("wrong.rig:2: unknown key 'leds.spi_mhz'"), std::string::npos)
      << outcome.err;
}

TEST(RigPlan, WritesNoOutputOverTheRigFileThatItPlansWhateverItIsCalled) {
  const testing::ScratchFolder folder;
  const fs::path mine = folder.path() / "mine.rig", link = folder.path() / "link.rig";
  fs::copy_file(fs::path(LAMELLA_BOARD_DIR) / "dome150.leds", folder.path() / "dome150.leds");
  fs::copy_file(fs::path(LAMELLA_BOARD_DIR) / "sim.rig", mine);
  fs::create_symlink("mine.rig", link);
  const std::string text = read_text(mine);
  for (const fs::path& out : {mine, folder.path() / "." / "mine.rig", link}) {
    for (const char* option : {"--svg", "--vcd"}) {
      const Outcome outcome = run_lamella({"rig", "plan", "--rig-file", mine, option, out});
      EXPECT_EQ(outcome.exit_code, 2);
      EXPECT_NE(outcome.err.find(out.string() + ": is the rig file"), std::string::npos)
          << outcome.err;
      EXPECT_EQ(read_text(mine), text);
    }
  }
}

TEST(RigPlan, WritesNoOutputOverTheListOfLedsThatItsRigFileNames) {
  const testing::ScratchFolder folder;
  const fs::path mine = folder.path() / "mine.rig", leds = folder.path() / "dome150.leds";
  fs::copy_file(fs::path(LAMELLA_BOARD_DIR) / "dome150.leds", leds);
  fs::copy_file(fs::path(LAMELLA_BOARD_DIR) / "sim.rig", mine);
  fs::create_symlink("dome150.leds", folder.path() / "link");
  const std::string text = read_text(leds);
  for (const fs::path& out : {leds, folder.path() / "link"}) {
    for (const char* option : {"--svg", "--vcd"}) {
      const Outcome outcome = run_lamella({"rig", "plan", "--rig-file", mine, option, out});
      EXPECT_EQ(outcome.exit_code, 2);
      EXPECT_NE(outcome.err.find("is the rig's list of LEDs"), std::string::npos) << outcome.err;
      EXPECT_EQ(read_text(leds), text);
    }
  }
}

TEST(RigPlan, WritesNoTwoOutputsIntoOneFile) {
  const testing::ScratchFolder folder;
  const std::string file = folder.path() / "same";
  const Outcome outcome = run_lamella({"rig", "plan", "--svg", file, "--vcd", file});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("name two files"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(file));
  fs::create_symlink("same", folder.path() / "link");
  const std::string link = folder.path() / "link";
  EXPECT_EQ(run_lamella({"rig", "plan", "--svg", file, "--vcd", link}).exit_code, 2);
  EXPECT_FALSE(fs::exists(file));
}

}  // namespace
}  // namespace lamella
