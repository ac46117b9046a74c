// lamella rig selftest on the simulated rig: a table for people, JSON for programs, an exit code.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "apps/run_lamella.h"
#include "io/fake_session.h"
#include "io/json_tree.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

TEST(RigSelftest, OfAGoodRigEndsWithZeroAndATableInWhichEveryNumberHasItsUnit) {
  const Outcome run = run_lamella({"rig", "selftest", "--rig", "sim", "--only", "chain", "--only",
                                   "actuator", "--only", "estop", "--only", "cameras"});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("sim: good"), std::string::npos) << run.out;
  for (const char* row :
       {"chips in the chain +7 chips +7 chips +good", "pressed +no +no +good",
        "at crossed +yes +yes +good", "left, dark above black .* dn +-24 to 24 dn"}) {
    EXPECT_TRUE(std::regex_search(run.out, std::regex(row))) << row << "\n" << run.out;
  }
}

TEST(RigSelftest, AnInjectedFaultIsNamedAndEndsWithOne) {
  const Outcome run = run_lamella({"rig", "selftest", "--rig", "sim", "--only", "chain", "--inject",
                                   "missing-chip:2", "--json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  const auto report = json_tree(run.out);
  EXPECT_GE(report.at("bad").get<int>(), 1);
  EXPECT_EQ(report.at("readings")[0].at("part"), "chain");
  EXPECT_EQ(report.at("readings")[0].at("value"), 6);
  EXPECT_EQ(report.at("readings")[0].at("verdict"), "BAD");
}

TEST(RigSelftest, AFaultThatCannotBeInjectedIsBadInputBeforeAnythingIsStarted) {
  for (const auto& [fault, says] :
       {std::pair("dead-led:xyz", "--inject dead-led:xyz: \"xyz\" is no argument of dead-led:N"),
        {"dead-led:150", "--inject dead-led:150: LEDs are 0 to 149"},
        {"dead-cat", "--inject dead-cat: no such fault"}}) {
    const Outcome run =
        run_lamella({"rig", "selftest", "--rig", "sim", "--only", "chain", "--inject", fault});
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(says), std::string::npos) << run.err;
    EXPECT_EQ(run.err.find("--rig-file"), std::string::npos) << run.err;
  }
}

TEST(RigSelftest, WhatTheDaemonAloneFindsToBeBadInputIsSoHereToo) {
  testing::ScratchFolder scratch;
  const fs::path reference = scratch.path() / "leds.reference";
  std::ofstream(reference) << "no reference";
  const Outcome run = run_lamella({"rig", "selftest", "--rig", "sim", "--only", "chain",
                                   "--led-reference", reference.string()});
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_EQ(run.out, "");
  ASSERT_EQ(run.complaints().size(), 1u) << run.err;
  EXPECT_NE(run.err.find("lamella-rigd: ended before it was ready: "), std::string::npos)
      << run.err;
  EXPECT_NE(run.err.find(reference.string()), std::string::npos) << run.err;
}

// All that a program writes to a terminal that is its standard error. It is interrupted, as by ^C,
// where that has `last` in it.
std::string shown_on_terminal(std::vector<const char*> arguments, const std::string& last = "\a") {
  const int master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  grantpt(master);
  unlockpt(master);
  const std::string name = ptsname(master);
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    dup2(open("/dev/null", O_WRONLY), 1);
    dup2(open(name.c_str(), O_RDWR | O_NOCTTY), 2);
    execv(LAMELLA_BINARY, const_cast<char* const*>(arguments.data()));
    _exit(127);
  }
  std::string shown;
  char bytes[1024];
  pollfd waiting{master, POLLIN, 0};
  while (true) {
    const bool ended = waitpid(child, nullptr, WNOHANG) == child;
    while (poll(&waiting, 1, 20) > 0 && (waiting.revents & POLLIN)) {
      const ssize_t n = read(master, bytes, sizeof bytes);
      if (n <= 0) break;
      const bool was_there = shown.find(last) != std::string::npos;
      shown.append(bytes, size_t(n));
      if (!was_there && shown.find(last) != std::string::npos) kill(child, SIGINT);
    }
    if (ended) break;
  }
  close(master);
  return shown;
}

TEST(RigSelftest, ShowsOnATerminalHowLongItWaitsAndHowManyPartsAreRead) {
  const std::string shown = shown_on_terminal(
      {"lamella", "rig", "selftest", "--rig", "sim", "--only", "chain", "--only", "latency"});
  EXPECT_NE(shown.find("starting the simulated rig, seconds of at most 0/180"), std::string::npos)
      << shown;
  EXPECT_NE(shown.find("self-test, parts read 0/2"), std::string::npos) << shown;
}

TEST(RigSelftest, DoesNotLearnTheLedsFromPartsThatLeaveThemOut) {
  const Outcome outcome =
      run_lamella({"rig", "selftest", "--rig", "sim", "--learn", "--only", "chain"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("--learn: learns how the LEDs"), std::string::npos) << outcome.err;
}

TEST(RigSelftest, PartsThatAreNoneAreRefusedAtOnce) {
  const Outcome run = run_lamella({"rig", "selftest", "--rig", "sim", "--only", "engine"});
  EXPECT_EQ(run.exit_code, 2);
}

TEST(RigSelftest, OfASimulatedRigThatIsInterruptedAdvisesNobodyToFetchAnything) {
  const std::string shown =
      shown_on_terminal({"lamella", "rig", "selftest", "--rig", "sim"}, "self-test, parts read");
  EXPECT_NE(shown.find("interrupted, nothing was kept"), std::string::npos) << shown;
  EXPECT_EQ(shown.find("rig sync"), std::string::npos) << shown;
}

}  // namespace
}  // namespace lamella
