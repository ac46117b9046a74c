// The words of a command line: which command is meant, where options stand, help and version.
#include <gtest/gtest.h>

#include <regex>

#include "apps/run_lamella.h"
#include "io/fake_session.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

void expect_refusal(const std::vector<std::string>& words, const std::string& line) {
  const Outcome outcome = run_lamella(words);
  EXPECT_EQ(outcome.exit_code, 2) << line;
  EXPECT_EQ(outcome.err, "lamella: " + line + "\n");
  EXPECT_EQ(outcome.out, "");
}

TEST(CommandLine, NamesAWordThatIsNoCommandAndTheCommandThatIsMeant) {
  expect_refusal({"bogus"}, "\"bogus\" is no command of \"lamella\"; see lamella --help");
  expect_refusal({"captrue", "--rig", "sim"},
                 "\"captrue\" is no command of \"lamella\"; lamella capture is one; "
                 "see lamella --help");
  expect_refusal({"rig", "stauts"},
                 "\"stauts\" is no command of \"lamella rig\"; lamella rig status is one; "
                 "see lamella rig --help");
  expect_refusal({"rig", ""}, "\"\" is no command of \"lamella rig\"; see lamella rig --help");
  expect_refusal({}, "needs a command; see lamella --help");
  expect_refusal({"rig"}, "lamella rig: needs a command; see lamella rig --help");
}

TEST(CommandLine, KnowsTheCommandsOfTheRigThatAreAskedForWithoutIt) {
  for (const std::string word :
       {"sync", "status", "plan", "pair", "recover", "selftest", "list", "abort"}) {
    expect_refusal({word, "--rig", "127.0.0.1:1"}, "\"" + word +
                                                       "\" is no command of \"lamella\"; lamella "
                                                       "rig " +
                                                       word + " is one; see lamella --help");
  }
}

TEST(CommandLine, SaysThatOptionsFollowTheCommand) {
  expect_refusal({"--out", "s", "capture", "--rig", "sim"},
                 "--out: options follow the command: lamella capture --out; see lamella --help");
  expect_refusal({"--json=x", "check", "s"},
                 "--json: options follow the command: lamella check --json; see lamella --help");
  expect_refusal({"rig", "--json", "status"},
                 "--json: options follow the command: lamella rig status --json; "
                 "see lamella rig --help");
  expect_refusal({"--out"},
                 "--out: options follow the command: lamella COMMAND --out; see lamella --help");
}

TEST(CommandLine, TellsWhoAsksATwinForNothingAllThatItCanBeAskedFor) {
  expect_refusal({"twin", "--subject", "sphere"},
                 "twin: nothing to do; give --out, --truth-out, --calibration-out or --serve");
}

TEST(CommandLine, NoOutputOfATwinLiesInAnother) {
  testing::ScratchFolder scratch;
  const std::string outer = scratch.path() / "outer", inner = scratch.path() / "outer" / "inner";
  const std::string line = " lies in " + outer + ", another output; name a place outside it";
  for (const auto& [holds, lies] : {std::pair("--out", "--truth-out"),
                                    {"--truth-out", "--out"},
                                    {"--out", "--calibration-out"},
                                    {"--truth-out", "--calibration-out"}}) {
    SCOPED_TRACE(lies);
    expect_refusal({"twin", "--subject", "sphere", holds, outer, lies, inner}, inner + ":" + line);
    expect_refusal({"twin", "--subject", "sphere", holds, outer, lies, outer}, outer + ":" + line);
  }
  EXPECT_TRUE(scratch.contents().empty());
}

TEST(CommandLine, ATwinIsToldToTakeNoBurstOnlyWhereItServes) {
  expect_refusal({"twin", "--no-burst"},
                 "twin: nothing to do; give --out, --truth-out, --calibration-out or --serve");
  testing::ScratchFolder scratch;
  expect_refusal({"twin", "--no-burst", "--truth-out", scratch.path() / "truth"},
                 "--no-burst: is of --serve; give --serve with it");
  EXPECT_TRUE(scratch.contents().empty());
}

TEST(CommandLine, WhatARigHoldsIsNotFetchedAndGivenUpAtOnce) {
  testing::ScratchFolder scratch;
  for (const std::string rig : {"sim", "127.0.0.1:1"}) {
    expect_refusal(
        {"capture", "--rig", rig, "--out", scratch.path() / "s", "--held", "--discard-held"},
        "--discard-held: gives up what --held fetches; give one of them");
  }
  EXPECT_TRUE(scratch.contents().empty());
}

// The names below "Commands:" of a help, each behind `path`.
std::vector<std::string> commands_in(const std::string& help, const std::string& path = "") {
  const std::regex line("\n  ([a-z]+) +[A-Z]");
  std::vector<std::string> names;
  for (std::sregex_iterator at(help.begin(), help.end(), line), end; at != end; ++at) {
    names.push_back(path + (*at)[1].str());
  }
  return names;
}

TEST(CommandLine, ManualNamesEveryCommand) {
  const std::string manual = read_text(LAMELLA_BOARD_DIR "/../../debian/lamella.1");
  std::vector<std::string> commands = commands_in(run_lamella({"--help"}).out);
  std::erase(commands, "rig");  // its own commands stand for it
  const auto of_rig = commands_in(run_lamella({"rig", "--help"}).out, "rig ");
  commands.insert(commands.end(), of_rig.begin(), of_rig.end());
  EXPECT_GT(commands.size(), 15u);
  for (const std::string& name : commands) {
    const std::regex entry("(\\\\fB|\n\\.B )(lamella )?" + name + "(\\\\fR|\n)");
    EXPECT_TRUE(std::regex_search(manual, entry)) << name;
  }
}

TEST(CommandLine, HelpOfACommandIsWhatItPrintsOfItself) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{}, {"fit"}, {"rig"}, {"rig", "sync"}}) {
    std::vector<std::string> asked{"help"}, itself = command;
    asked.insert(asked.end(), command.begin(), command.end());
    itself.push_back("--help");
    const Outcome help = run_lamella(asked);
    EXPECT_EQ(help.exit_code, 0) << help.err;
    EXPECT_NE(help.out.find("Usage: lamella"), std::string::npos) << help.out;
    EXPECT_EQ(help.out, run_lamella(itself).out);
  }
  expect_refusal(
      {"help", "exprot"},
      "\"exprot\" is no command of \"lamella\"; lamella export is one; see lamella --help");
}

TEST(CommandLine, HelpPutsOptionsWhereTheyAreTaken) {
  EXPECT_NE(run_lamella({"--help"}).out.find("Usage: lamella COMMAND [OPTIONS]\n"),
            std::string::npos);
  EXPECT_NE(run_lamella({"rig", "--help"}).out.find("Usage: lamella rig COMMAND [OPTIONS]\n"),
            std::string::npos);
  EXPECT_NE(run_lamella({"check", "--help"}).out.find("Usage: lamella check [OPTIONS] session\n"),
            std::string::npos);
}

TEST(CommandLine, HelpSaysWhatStandsWhereAnOptionIsNotGiven) {
  const std::string capture = run_lamella({"capture", "--help"}).out;
  for (const char* option : {"--rig TEXT=sim ", "--seed UINT=1 ", "--scale FLOAT=1 ",
                             "--clock TEXT:{virtual,real}=virtual", "--rig-file TEXT=sim "}) {
    EXPECT_NE(capture.find(option), std::string::npos) << option << capture;
  }
}

TEST(CommandLine, VersionIsOneLine) {
  const Outcome outcome = run_lamella({"--version"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, "lamella " LAMELLA_VERSION " (link protocol 1)\n");
}

TEST(CommandLine, TakesNumbersInDecimalAlone) {
  for (const std::string wrong : {"nan", "inf", "0x10", "1e999", " 3", "3 "}) {
    expect_refusal({"rig", "list", "--wait", wrong},
                   "--wait: \"" + wrong + "\" is no decimal number; see lamella rig list --help");
  }
  expect_refusal({"capture", "--out", "s", "--scale", "nan"},
                 "--scale: \"nan\" is no decimal number; see lamella capture --help");
}

TEST(CommandLine, RefusesAnOptionThatIsGivenTwice) {
  expect_refusal({"fit", "s", "--out", "a", "--out", "b"},
                 "--out: given 2 times; see lamella fit --help");
  expect_refusal({"capture", "--out", "s", "--seed", "1", "--seed", "1", "--seed", "1"},
                 "--seed: given 3 times; see lamella capture --help");
  expect_refusal({"rig", "status", "--rig", "127.0.0.1:1", "--rig=127.0.0.1:2"},
                 "--rig: given 2 times; see lamella rig status --help");
}

TEST(CommandLine, RefusesANameThatIsEmptyAndSaysWhichItIs) {
  expect_refusal({"check", ""}, "session: \"\" is no name; see lamella check --help");
  expect_refusal({"fit", "s", "--out", ""}, "--out: \"\" is no name; see lamella fit --help");
  expect_refusal({"capture", "--out", ""}, "--out: \"\" is no name; see lamella capture --help");
  expect_refusal({"render", "s", "--view", ""},
                 "--view: \"\" is no name; see lamella render --help");
  expect_refusal({"twin", "--out", ""}, "--out: \"\" is no name; see lamella twin --help");
}

}  // namespace
}  // namespace lamella
