// lamella rig selftest on the simulated rig: a table for people, JSON for programs, an exit code.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/run_lamella.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

TEST(RigSelftest, OfAGoodRigEndsWithZeroAndATable) {
  const Outcome run = run_lamella({"rig", "selftest", "--rig", "sim", "--only", "chain", "--only",
                                   "actuator", "--only", "estop"});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("sim: good"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("chips in the chain"), std::string::npos) << run.out;
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
