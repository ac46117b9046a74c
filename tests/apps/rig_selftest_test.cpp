// lamella rig selftest on the simulated rig: a table for people, JSON for programs, an exit code.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "apps/run_lamella.h"

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
  const auto report = nlohmann::json::parse(run.out);
  EXPECT_GE(report.at("bad").get<int>(), 1);
  EXPECT_EQ(report.at("readings")[0].at("part"), "chain");
  EXPECT_EQ(report.at("readings")[0].at("value"), 6);
  EXPECT_EQ(report.at("readings")[0].at("verdict"), "BAD");
}

TEST(RigSelftest, PartsThatAreNoneAreRefusedAtOnce) {
  const Outcome run = run_lamella({"rig", "selftest", "--rig", "sim", "--only", "engine"});
  EXPECT_EQ(run.exit_code, 2);
}

}  // namespace
}  // namespace lamella
