#include "calib/receive.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "base/error.h"
#include "io/fake_rig.h"
#include "io/fake_session.h"
#include "io/json.h"
#include "io/session.h"
#include "io/shortfall.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::FakeRig;
using testing::FakeRigFaults;
using testing::load_burst;

const cv::Size kSize(24, 32);

class Receive : public ::testing::Test {
 protected:
  Receive() : folder_(fs::temp_directory_path() / ("receive-" + std::to_string(getpid()))) {}

  LinkOptions quick() const {
    LinkOptions options;
    options.reply_s = 1;
    options.backoff_s = 0.002;
    return options;
  }

  Reception receive(const FakeRig& rig) {
    LinkClient client(rig.address(), quick());
    const Burst burst = client.run_burst("fake");
    return receive_session(&client, burst, folder_, [](int) {});
  }

  std::string failure(const FakeRig& rig) {
    try {
      receive(rig);
    } catch (const Error& e) {
      EXPECT_EQ(e.fault(), Fault::kRig);
      return e.what();
    }
    return "nothing failed";
  }

  WholeFolder folder_;
};

TEST_F(Receive, MakesASessionThatCanBeFitted) {
  FakeRig rig;
  load_burst(&rig, kSize);
  const Reception reception = receive(rig);
  EXPECT_EQ(reception.offers.size(), 40u);
  EXPECT_EQ(reception.raw_bytes, 40 * rgb12p_bytes(24, 32));
  const Session session = read_session(folder_.path());
  EXPECT_NO_THROW(require_burst(session));
  EXPECT_EQ(session.frames.size(), 40u);
  const Frame* frame = session.find("left", Role::kStripes, 2, Analyser::kCross);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->file, "frames/left/18_stripes_2_cross.exr");
}

TEST_F(Receive, StoresDevelopedValuesToTheQuantumOfTheSensor) {
  FakeRig rig;
  load_burst(&rig, kSize);
  const Reception reception = receive(rig);
  const Session session = read_session(folder_.path());
  const v1::FrameOffer& offer = reception.offers.front();
  const Photograph photograph = read_photograph(
      session, *session.find(offer.frame().camera(), Role::kGradientFull, 0, Analyser::kParallel));
  const RawImage raw = testing::fake_raw(offer.frame_id(), kSize);
  const v1::Frame& f = offer.frame();
  for (const cv::Point at : {cv::Point(0, 0), cv::Point(7, 11), cv::Point(23, 31)}) {
    for (int c = 0; c < 3; ++c) {
      const double stored = (raw(at)[c] - f.black_level_dn()) * f.gain_per_dn();
      EXPECT_NEAR(photograph.radiance(at)[c], stored, f.gain_per_dn());
    }
  }
}

TEST_F(Receive, MarksThePhotographsThatAnEdgeCameTooLateFor) {
  FakeRig rig;
  load_burst(&rig, kSize);
  testing::FakePhotograph late = testing::fake_photograph(99, kSize);
  late.offer.mutable_frame()->set_role(v1::Frame::AMBIENT);
  late.offer.set_marked(true);
  rig.add(late);
  EXPECT_EQ(receive(rig).marked.size(), 1u);
}

TEST_F(Receive, KeepsWhatTheRigTookAgainBesideTheFrames) {
  FakeRig rig;
  load_burst(&rig, kSize);
  testing::FakePhotograph late = testing::fake_photograph(99, kSize);
  late.offer.mutable_frame()->set_step(18);
  late.offer.mutable_frame()->set_index(2);
  late.offer.mutable_frame()->set_shot(5);
  late.offer.mutable_frame()->set_replaced_by(20);
  late.offer.set_marked(true);
  rig.add(late);
  const Reception reception = receive(rig);
  EXPECT_TRUE(reception.marked.empty());
  EXPECT_EQ(reception.retaken.size(), 1u);
  const Session session = read_session(folder_.path());
  EXPECT_EQ(session.frames.size(), 40u);
  ASSERT_EQ(session.retaken.size(), 1u);
  EXPECT_EQ(session.retaken[0].file, "frames/retaken/left/18_stripes_2_cross_shot_5.exr");
  EXPECT_TRUE(fs::exists(folder_.path() / session.retaken[0].file));
}

TEST_F(Receive, RefusesAPhotographOfAnotherSizeThanTheCalibrationSays) {
  FakeRig rig;
  load_burst(&rig, kSize);
  rig.add(testing::fake_photograph(99, {25, 32}));
  EXPECT_NE(failure(rig).find("frame 99 (left STRIPES 99 CROSS): 25x32 pixels disagree"),
            std::string::npos);
}

TEST_F(Receive, RefusesABurstThatLacksARole) {
  FakeRig rig;
  load_burst(&rig, kSize, {v1::Frame::DOTS});
  EXPECT_NE(failure(rig).find("no DOTS CROSS of the left camera"), std::string::npos);
}

TEST_F(Receive, ABurstThatTheRigItselfSaysLacksAPhotographArrivesWithThatReason) {
  FakeRigFaults faults;
  faults.lacks = true;
  FakeRig rig(faults);
  load_burst(&rig, kSize, {v1::Frame::DOTS});
  const Reception reception = receive(rig);
  EXPECT_NE(reception.unfit.find("no DOTS CROSS of the left camera"), std::string::npos);
  const Session session = read_session(folder_.path());
  EXPECT_EQ(read_shortfall(folder_.path()), "MARKED: step 7 dropped by a camera");
  EXPECT_EQ(session.frames.size(), 38u);
  try {
    require_burst(session);
    FAIL() << "it was called a whole burst";
  } catch (const Error& e) {
    EXPECT_NE(
        std::string(e.what()).find(
            "step 7 dropped by a camera; if no other folder has the burst whole, take it again"),
        std::string::npos)
        << e.what();
  }
}

TEST_F(Receive, RefusesACalibrationOfOtherPatternsThanTheRigShows) {
  FakeRig rig;
  load_burst(&rig, kSize);
  v1::Session calibration = testing::fake_calibration(kSize);
  calibration.mutable_patterns()->mutable_stripes()->set_period_px(16);
  rig.set_calibration(to_json(calibration));
  EXPECT_NE(failure(rig).find("shows patterns.stripes.period_px 8, its calibration says 16"),
            std::string::npos);
}

TEST_F(Receive, RefusesACalibrationOfAnotherNumberOfLedsThanTheRigHas) {
  FakeRig rig;
  load_burst(&rig, kSize);
  v1::Session calibration = testing::fake_calibration(kSize);
  const v1::Led led = calibration.rig().leds(0);
  const int leds = calibration.rig().leds_size();
  *calibration.mutable_rig()->add_leds() = led;
  rig.set_calibration(to_json(calibration));
  const std::string says = failure(rig);
  EXPECT_NE(says.find("it has " + std::to_string(leds) + " LEDs, its calibration (rig.leds) " +
                      std::to_string(leds + 1)),
            std::string::npos)
      << says;
}

TEST_F(Receive, NamesTheRigAndTheBurstInEveryRefusal) {
  const auto named = [](const FakeRig& rig) { return "rig " + rig.address() + ": burst 42: "; };
  FakeRig sends_twice;
  load_burst(&sends_twice, kSize);
  testing::FakePhotograph twice = testing::fake_photograph(99, kSize);
  twice.offer.mutable_frame()->set_step(18);
  twice.offer.mutable_frame()->set_index(2);
  sends_twice.add(twice);
  FakeRig of_another_size;
  load_burst(&of_another_size, kSize);
  of_another_size.add(testing::fake_photograph(99, {25, 32}));
  FakeRig without_json, of_other_patterns;
  load_burst(&without_json, kSize);
  without_json.set_calibration("{");
  load_burst(&of_other_patterns, kSize);
  v1::Session calibration = testing::fake_calibration(kSize);
  calibration.mutable_patterns()->mutable_stripes()->set_period_px(16);
  of_other_patterns.set_calibration(to_json(calibration));
  for (const FakeRig* rig : {&sends_twice, &of_another_size, &without_json, &of_other_patterns}) {
    const std::string line = failure(*rig);
    EXPECT_EQ(line.find(named(*rig)), 0u) << line;
  }
}

TEST_F(Receive, BlamesTheRigForACalibrationThatIsNotJson) {
  FakeRig rig;
  load_burst(&rig, kSize);
  rig.set_calibration("{");
  EXPECT_NE(failure(rig).find("calibration"), std::string::npos);
}

TEST_F(Receive, WritesOutsideItsFolderForNoCamera) {
  FakeRig rig;
  load_burst(&rig, kSize);
  v1::Session calibration = testing::fake_calibration(kSize);
  v1::Camera* outside = calibration.mutable_rig()->add_cameras();
  *outside = calibration.rig().cameras(0);
  const std::string name = folder_.path().filename().string() + "-outside";
  outside->set_id("../../" + name);
  rig.set_calibration(to_json(calibration));
  testing::FakePhotograph photograph = testing::fake_photograph(99, kSize);
  photograph.offer.mutable_frame()->set_camera(outside->id());
  rig.add(photograph);
  EXPECT_NE(failure(rig).find("rig.cameras[2].id"), std::string::npos);
  EXPECT_EQ(fs::remove_all(folder_.path() / ".." / name), 0u);
}

TEST_F(Receive, WritesNothingAfterALinkThatStaysCut) {
  FakeRigFaults faults;
  faults.cut_frame = 5;
  faults.cut_at_byte = 700;
  faults.cut_times = 1000;
  FakeRig rig(faults);
  load_burst(&rig, kSize);
  EXPECT_NE(failure(rig).find("at byte 700 of"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_.path() / "session.json"));
  EXPECT_TRUE(rig.acknowledged().empty());
}

}  // namespace
}  // namespace lamella
