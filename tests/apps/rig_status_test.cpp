// lamella rig status of a rig that found parts of itself bad.
#include <gtest/gtest.h>

#include <fstream>

#include "apps/run_lamella.h"
#include "firmware/test_calibration.h"
#include "io/fake_session.h"
#include "io/json_tree.h"
#include "link/rig_process.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

TEST(RigStatus, NamesThePartsThatTheRigFoundBadAndEndsWithZero) {
  const testing::ScratchFolder scratch;
  const testing::TestTwin twin(20);
  const std::string calibration = scratch.path() / "calibration.json";
  std::ofstream(calibration) << calibration_text();
  testing::RigUnderTest rig({"--twin", twin.path(), "--calibration", calibration, "--listen",
                             "127.0.0.1:0", "--inject", "estop"});
  const std::string part =
      "estop: pressed: release the emergency stop; a broken wire reads the same";
  const Outcome text = run_lamella({"rig", "status", "--rig", rig.address()});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("\n  unfit: " + part + "\n"), std::string::npos) << text.out;
  const Outcome json = run_lamella({"rig", "status", "--rig", rig.address(), "--json"});
  EXPECT_EQ(json.exit_code, 0) << json.err;
  ASSERT_EQ(json_tree(json.out)["unfit"].size(), 1u) << json.out;
  EXPECT_EQ(json_tree(json.out)["unfit"][0], part);
}

}  // namespace
}  // namespace lamella
