// What every rig command leaves where it fails: one JSON document on standard output or nothing,
// one line on standard error that says what, where and what to do, and the exit code.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/run_lamella.h"
#include "firmware/test_calibration.h"
#include "io/fake_rig.h"
#include "io/fake_session.h"
#include "io/json_tree.h"
#include "io/known_rigs.h"
#include "link/rig_process.h"

namespace lamella {
namespace {

using nlohmann::json;
using testing::FakeRig;
using testing::FakeRigFaults;
using testing::Outcome;
using testing::RigUnderTest;
using testing::run_lamella;

class RigReport : public ::testing::Test {
 protected:
  void SetUp() override { setenv("XDG_CONFIG_HOME", (scratch.path() / "config").c_str(), 1); }
  void TearDown() override { unsetenv("XDG_CONFIG_HOME"); }

  // Every command that talks to a rig, as a program runs it; a rig is paired with another way.
  std::vector<std::vector<std::string>> all_of(const std::string& rig) const {
    return {{"rig", "status", "--rig", rig, "--json"},
            {"rig", "abort", "--rig", rig, "--json"},
            {"rig", "selftest", "--rig", rig, "--only", "chain", "--json"},
            {"rig", "recover", "--rig", rig, "--json"},
            {"rig", "sync", "--rig", rig, "--out", out.string(), "--json"}};
  }

  static void expect_one_line(const Outcome& outcome, int exit_code,
                              const std::vector<std::string>& named) {
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    ASSERT_EQ(outcome.complaints().size(), 1u) << outcome.err;
    for (const std::string& part : named) {
      EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err << "lacks " << part;
    }
  }

  static void expect_nothing_but_a_line(const Outcome& outcome, int exit_code,
                                        const std::vector<std::string>& named) {
    expect_one_line(outcome, exit_code, named);
    EXPECT_EQ(outcome.out, "");
  }

  std::vector<std::string> arguments_of_rigd(const std::vector<std::string>& more = {}) const {
    std::ofstream(scratch.path() / "calibration.json") << calibration_text();
    std::vector<std::string> all{"--twin",        twin.path(),
                                 "--calibration", scratch.path() / "calibration.json",
                                 "--listen",      "127.0.0.1:0"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  testing::ScratchFolder scratch;
  fs::path out = scratch.path() / "sessions";
  testing::TestTwin twin{20};
};

TEST_F(RigReport, OfNoRigIsALineThatNamesTheAddressAndLeavesStandardOutputEmpty) {
  std::string address;
  { address = FakeRig().address(); }
  for (const auto& command : all_of(address)) {
    SCOPED_TRACE(command[1]);
    expect_nothing_but_a_line(run_lamella(command), 3,
                              {address, "no rig answers", "is lamella-rigd running there?"});
  }
  expect_nothing_but_a_line(run_lamella({"rig", "pair", "--rig", address, "--json"}), 3,
                            {address, "cannot be paired with", "is lamella-rigd running there"});
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(RigReport, OfABusyRigSaysThatAnotherHostHasItAndWhenToTryAgain) {
  FakeRigFaults faults;
  faults.is_busy = true;
  FakeRig rig(faults);
  for (const auto& command : all_of(rig.address())) {
    SCOPED_TRACE(command[1]);
    expect_nothing_but_a_line(run_lamella(command), 3,
                              {rig.address(), "busy with another host", "try again when"});
  }
}

TEST_F(RigReport, OfARigThatThisHostIsNotPairedWithSaysHowToPair) {
  fs::create_directory(scratch.path() / "state");
  fs::permissions(scratch.path() / "state", fs::perms::owner_all);
  RigUnderTest rig(arguments_of_rigd({"--state", scratch.path() / "state"}));
  const std::string pair = "hold its START button and run: lamella rig pair --rig " + rig.address();
  for (const auto& command : all_of(rig.address())) {
    SCOPED_TRACE(command[1]);
    expect_nothing_but_a_line(run_lamella(command), 3, {rig.address(), pair});
  }
  const Outcome refused =
      run_lamella({"rig", "pair", "--rig", rig.address(), "--wait", "0.1", "--json"});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_EQ(refused.out, "");
  EXPECT_NE(refused.err.find("BUTTON"), std::string::npos) << refused.err;
  const Outcome forgotten =
      run_lamella({"rig", "pair", "--rig", rig.address(), "--forget", "--json"});
  expect_nothing_but_a_line(forgotten, 2, {"is not paired with this host"});
}

TEST_F(RigReport, OfARigWithoutPairingSaysSoBeforeItAsksForTheButton) {
  RigUnderTest rig(arguments_of_rigd());
  expect_nothing_but_a_line(run_lamella({"rig", "pair", "--rig", rig.address(), "--json"}), 3,
                            {rig.address(), "in the clear", "with --state"});
}

TEST_F(RigReport, OfARigThatIsWellIsOneDocumentAndNothingElse) {
  fs::create_directory(scratch.path() / "store");
  RigUnderTest rig(arguments_of_rigd({"--store", scratch.path() / "store"}));
  for (const auto& command : all_of(rig.address())) {
    SCOPED_TRACE(command[1]);
    const Outcome outcome = run_lamella(command);
    if (command[1] == "abort") {
      expect_nothing_but_a_line(outcome, 3, {rig.address(), "there is no burst to abort"});
      continue;
    }
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_TRUE(json_tree(outcome.out).is_object()) << outcome.out;
  }
}

TEST_F(RigReport, OfARigInFaultIsItsStateAndALineThatSaysHowToClearIt) {
  FakeRigFaults faults;
  faults.stands_in_fault = true;
  FakeRig rig(faults);
  const Outcome status = run_lamella({"rig", "status", "--rig", rig.address(), "--json"});
  expect_one_line(status, 1,
                  {rig.address(), "a camera missed a trigger", "lamella rig abort --rig"});
  EXPECT_EQ(json_tree(status.out)["state"], "FAULT");
  const Outcome abort = run_lamella({"rig", "abort", "--rig", rig.address(), "--json"});
  EXPECT_EQ(abort.exit_code, 0) << abort.err;
  EXPECT_EQ(json_tree(abort.out)["state"], "IDLE");
}

TEST_F(RigReport, OfABadRigFileIsItsLineAndOfARefusedPlanThePlanAndTheRule) {
  const fs::path bad = scratch.path() / "bad.rig", refused = scratch.path() / "refused.rig";
  std::ofstream(bad) << "leds = many\n";
  expect_nothing_but_a_line(run_lamella({"rig", "plan", "--rig-file", bad, "--json"}), 2,
                            {"bad.rig:1", "--check"});
  fs::copy_file(fs::path(LAMELLA_BOARD_DIR) / "dome150.leds", scratch.path() / "dome150.leds");
  std::ifstream sim(fs::path(LAMELLA_BOARD_DIR) / "sim.rig");
  std::string text{std::istreambuf_iterator<char>(sim), {}};
  const size_t key = text.find("leds.highest_duty"), value = text.find('=', key) + 1;
  std::ofstream(refused) << text.replace(value, text.find('\n', key) - value, " 0.01");
  const Outcome plan = run_lamella({"rig", "plan", "--rig-file", refused, "--json"});
  expect_one_line(plan, 2, {"refused.rig", "the rig would not play this", "leds.highest_duty"});
  EXPECT_NE(json_tree(plan.out)["refusal"], "");
}

TEST_F(RigReport, OfAnOutputThatCannotBeWrittenIsALineWithItsName) {
  std::ofstream(scratch.path() / "file") << "mine";
  const std::string inside = scratch.path() / "file" / "out";
  for (const char* option : {"--svg", "--vcd"}) {
    expect_nothing_but_a_line(run_lamella({"rig", "plan", option, inside, "--json"}), 2, {inside});
  }
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  v1::HeldBurst held;
  held.set_whole(true);
  rig.hold(held);
  for (const char* command : {"sync", "recover"}) {
    SCOPED_TRACE(command);
    expect_nothing_but_a_line(
        run_lamella({"rig", command, "--rig", rig.address(), "--out", inside, "--json"}), 2,
        {inside});
  }
  EXPECT_TRUE(rig.holds_burst());
  EXPECT_TRUE(rig.acknowledged().empty());
}

TEST_F(RigReport, ThatCannotBeWrittenItselfIsNeverADoneCommand) {
  FakeRig rig;
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"rig", "status", "--rig", rig.address(), "--json"},
        {"rig", "plan", "--json"},
        {"rig", "plan"}}) {
    const Outcome outcome = run_lamella(command, "/dev/full");
    expect_nothing_but_a_line(outcome, 2, {"standard output", "No space left on device"});
  }
}

TEST_F(RigReport, OfASyncThatBreaksOffTellsTheBurstsBeforeItInOneDocument) {
  FakeRigFaults faults;
  faults.holds_damaged = true;
  FakeRig rig(faults);
  load_burst(&rig, testing::kFakeSize);
  v1::HeldBurst held;
  held.set_whole(true);
  rig.hold(held);
  fs::create_directories(out);
  std::ofstream(out / ".fetching") << "in the way of burst 42";
  const Outcome outcome =
      run_lamella({"rig", "sync", "--rig", rig.address(), "--out", out.string(), "--json"});
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err << outcome.out;
  ASSERT_EQ(outcome.complaints().size(), 2u) << outcome.err;
  EXPECT_NE(outcome.complaints()[0].find("burst 41 was not fetched and stays where it is"),
            std::string::npos);
  EXPECT_NE(outcome.complaints()[1].find(".fetching"), std::string::npos);
  const json report = json_tree(outcome.out);
  ASSERT_EQ(report["bursts"].size(), 1u);
  EXPECT_EQ(report["bursts"][0]["burst"], 41);
}

TEST_F(RigReport, OfABurstThatWasHeldKnowsNoPlanAndDoesNotSayZero) {
  for (const bool as_json : {true, false}) {
    FakeRig rig;
    load_burst(&rig, testing::kFakeSize);
    rig.hold(testing::whole_burst());
    const fs::path session = out / (as_json ? "first" : "second");
    std::vector<std::string> command{"capture", "--rig", rig.address(), "--held", "--out", session};
    if (as_json) command.push_back("--json");
    const Outcome outcome = run_lamella(command);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    if (as_json) {
      EXPECT_TRUE(json_tree(outcome.out)["burst_planned_s"].is_null()) << outcome.out;
    } else {
      EXPECT_NE(outcome.out.find("s played"), std::string::npos) << outcome.out;
      EXPECT_EQ(outcome.out.find("planned"), std::string::npos) << outcome.out;
    }
  }
}

TEST_F(RigReport, OfAConfigurationThatOthersMayReadNamesTheFile) {
  KnownRigs(scratch.path() / "config" / "lamella").add({{}, "192.0.2.1:7420", "far"});
  const fs::path known = scratch.path() / "config" / "lamella" / "known_rigs";
  fs::permissions(known, fs::perms(0644));
  auto commands = all_of("192.0.2.1:7420");
  commands.push_back({"rig", "list", "--wait", "0.1", "--json"});
  for (const auto& command : commands) {
    SCOPED_TRACE(command[1]);
    expect_nothing_but_a_line(run_lamella(command), 2, {known.string(), "chmod 600"});
  }
}

TEST_F(RigReport, OfANetworkNobodyListensToSaysWhatToStart) {
  setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere", 1);
  const Outcome list = run_lamella({"rig", "list", "--wait", "0.1", "--json"});
  const Outcome status = run_lamella({"rig", "status", "--json"});
  unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
  expect_nothing_but_a_line(list, 3, {"mDNS", "is avahi-daemon running?"});
  expect_nothing_but_a_line(status, 3, {"mDNS", "--rig HOST:PORT"});
}

TEST_F(RigReport, FaultsAreInjectedIntoTheSimulatedRigAlone) {
  const Outcome outcome = run_lamella(
      {"rig", "selftest", "--rig", "127.0.0.1:7420", "--inject", "dead-led:3", "--json"});
  expect_nothing_but_a_line(outcome, 2, {"--inject", "simulated rig alone"});
}

}  // namespace
}  // namespace lamella
