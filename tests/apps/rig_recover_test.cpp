// lamella rig recover, run as a user runs it.
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/burst_fetch.h"
#include "apps/recalibrated_source.h"
#include "apps/resumed_source.h"
#include "apps/run_lamella.h"
#include "calib/same_rig.h"
#include "io/fake_rig.h"
#include "io/fake_session.h"
#include "io/json.h"
#include "io/json_tree.h"
#include "io/session.h"
#include "io/shortfall.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::FakeRig;
using testing::Outcome;
using testing::partial_burst;
using testing::run_lamella;
using testing::whole_burst;

class RigRecover : public ::testing::Test {
 protected:
  Outcome run(std::vector<std::string> command, const FakeRig& rig) {
    command.insert(command.begin(), "rig");
    command.insert(command.end(), {"--rig", rig.address(), "--out", out.string()});
    return run_lamella(command);
  }

  testing::ScratchFolder scratch;
  fs::path out = scratch.path() / "sessions";
};

TEST_F(RigRecover, RecoverExplainsAndChangesNothing) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize, {v1::Frame::DOTS});
  rig.hold(partial_burst());
  const Outcome outcome = run({"recover"}, rig);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_NE(outcome.out.find("why          the power went"), std::string::npos) << outcome.out;
  EXPECT_TRUE(fs::exists(out / "burst-000042.partial"));
  EXPECT_TRUE(rig.holds_burst());
  EXPECT_TRUE(rig.acknowledged().empty());
}

TEST_F(RigRecover, ABurstTakenWithACalibrationOfNoUseIsRecoveredWithAnotherAndThenLeavesTheRig) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  v1::Session calibration = testing::fake_calibration(testing::kFakeSize);
  const fs::path good = scratch.path() / "good.json";
  write_json(good, calibration);
  calibration.mutable_rig()->mutable_leds(0)->set_direction(0, 7);
  rig.set_calibration(to_json(calibration));
  const Outcome refused = run({"sync"}, rig);
  EXPECT_EQ(refused.exit_code, 3);
  for (const std::string part :
       {"rig.leds[0].direction: not a unit vector", "lamella rig recover --calibration FILE"}) {
    EXPECT_NE(refused.err.find(part), std::string::npos) << refused.err;
  }
  EXPECT_TRUE(rig.acknowledged().empty());
  const Outcome recovered = run({"recover", "--calibration", good.string()}, rig);
  EXPECT_EQ(recovered.exit_code, 0) << recovered.err;
  EXPECT_NO_THROW(require_burst(read_session(out / "burst-000042")));
  EXPECT_TRUE(rig.holds_burst());
  EXPECT_EQ(run({"sync"}, rig).exit_code, 0);
  EXPECT_EQ(rig.acknowledged().size(), 40u);
}

TEST_F(RigRecover, ACalibrationOfAnotherRigThanTookTheBurstIsRefusedByItsName) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  const fs::path file = scratch.path() / "other.json";
  const auto expect_refusal = [&](const v1::Session& calibration, const std::string& says) {
    write_json(file, calibration);
    const Outcome outcome = run({"recover", "--calibration", file.string()}, rig);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find(file.string() + ": " + says), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(out / "burst-000042"));
  };
  v1::Session calibration = testing::fake_calibration(testing::kFakeSize);
  calibration.mutable_patterns()->mutable_stripes()->set_period_px(16);
  expect_refusal(calibration, "is not of the rig that took burst 42: there its projector shows");
  calibration = testing::fake_calibration(testing::kFakeSize);
  calibration.mutable_rig()->mutable_leds()->RemoveLast();
  expect_refusal(calibration, "is not of the rig that took burst 42: there it has");
  calibration = testing::fake_calibration({99, 98});
  expect_refusal(calibration, "has no left camera of ");
}

TEST_F(RigRecover, ACalibrationOfTheRigAsItWasThenOrAsItIsNowIsTaken) {
  const v1::Session took = testing::fake_calibration(testing::kFakeSize);
  v1::Session now = took;
  now.mutable_patterns()->mutable_stripes()->set_period_px(16);
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  rig.set_welcome(rig_of(now));
  const fs::path file = scratch.path() / "given.json";
  for (const v1::Session& given : {took, now}) {
    write_json(file, given);
    const Outcome outcome = run({"recover", "--calibration", file.string()}, rig);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    fs::remove_all(out);
  }
}

// A disk that was taken out of a rig, with a burst whose own calibration is spoilt.
class SpoiltDisk : public apps::ResumedSource {
 public:
  using ResumedSource::ResumedSource;
  const v1::Welcome* answering() const override { return nullptr; }
  std::string calibration(const Burst&) override { return "{"; }
};

TEST_F(RigRecover, WhereNothingSaysWhatRigTookABurstTheCalibrationThatIsGivenIsTaken) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  const fs::path file = scratch.path() / "given.json";
  write_json(file, testing::fake_calibration(testing::kFakeSize));
  LinkClient client(rig.address());
  apps::RecalibratedSource source(std::make_unique<SpoiltDisk>(&client, out / ".fetching"), file);
  const auto fetched = apps::fetch_burst(&source, client.held().at(0), out);
  EXPECT_NO_THROW(require_burst(read_session(fetched.folder)));
}

TEST_F(RigRecover, AnotherCalibrationThanASessionHasThatIsThereIsRefused) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  const v1::Session calibration = testing::fake_calibration(testing::kFakeSize);
  const fs::path first = scratch.path() / "first.json", second = scratch.path() / "second.json";
  write_json(first, calibration);
  v1::Session of_other_camera = calibration, of_other_patterns = calibration;
  of_other_camera.mutable_rig()->mutable_cameras(0)->set_fx(1234);
  of_other_patterns.mutable_patterns()->mutable_stripes()->set_period_px(16);
  EXPECT_EQ(run({"recover", "--calibration", first.string()}, rig).exit_code, 0);
  EXPECT_EQ(run({"recover", "--calibration", first.string()}, rig).exit_code, 0);
  for (const v1::Session& other : {of_other_camera, of_other_patterns}) {
    write_json(second, other);
    const Outcome outcome = run({"recover", "--calibration", second.string()}, rig);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("burst-000042: holds this burst with another calibration than"),
              std::string::npos)
        << outcome.err;
  }
  EXPECT_FALSE(
      json_tree(read_text(out / "burst-000042" / "burst.json"))["own_calibration"].get<bool>());
}

TEST_F(RigRecover, ASessionIsOfTheSubjectThatTheBurstWasAskedForAndOfNobodyElse) {
  for (const std::string command : {"recover", "sync"}) {
    for (const std::string subject : {"Ada", ""}) {  // the calibration's is "fake"
      SCOPED_TRACE(command + " " + subject);
      FakeRig rig;
      load_burst(&rig, testing::kFakeSize);
      v1::HeldBurst held = whole_burst();
      held.set_subject(subject);
      rig.hold(held);
      fs::remove_all(out);
      const Outcome outcome = run({command}, rig);
      EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
      EXPECT_EQ(read_session(out / "burst-000042").subject, subject);
    }
  }
}

TEST_F(RigRecover, RecoverTakesNoFileThatIsNoCalibrationAndNoneWithoutAPlaceForSessions) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  const fs::path wrong = scratch.path() / "wrong.json";
  std::ofstream(wrong) << "{}";
  const Outcome outcome = run({"recover", "--calibration", wrong.string()}, rig);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("wrong.json: format: \"\""), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(out));
  const Outcome nowhere =
      run_lamella({"rig", "recover", "--rig", rig.address(), "--calibration", wrong.string()});
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_NE(nowhere.err.find("nothing is fetched without --out"), std::string::npos) << nowhere.err;
}

TEST_F(RigRecover, RecoverWithoutAPlaceToLookIsBadInput) {
  EXPECT_EQ(run_lamella({"rig", "recover"}).exit_code, 2);
  const Outcome outcome = run_lamella({"rig", "recover", "--store", scratch.path().string()});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("holds no bursts of a rig"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace lamella
