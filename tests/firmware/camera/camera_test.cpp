// A board's camera on a kernel that is played (fake_v4l2.h): which frame becomes which shot's
// photograph, and what is said where one is missing.
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <poll.h>

#include <cstring>

#include "fake_v4l2.h"

extern "C" {
#include "hal_linux_camera.h"
}

namespace {

constexpr uint32_t kWidth = 4, kHeight = 2;

struct rig rig_of_board() {
  struct rig rig = {};
  rig.camera_start_delay_us = 50;
  rig.camera_guard_us = 300;
  rig.camera_readout_us = 6000;
  rig.projector_refresh_hz = 50;
  rig.projector_light_periods = 1;
  std::strcpy(rig.board.camera_left, "v4l2:/dev/video0");
  std::strcpy(rig.board.camera_right, "v4l2:/dev/video1");
  std::strcpy(rig.board.camera_trigger, "fixed");
  rig.sensor.width_px = kWidth;
  rig.sensor.height_px = kHeight;
  rig.sensor.format = raw_format_find("GREY");
  rig.sensor.black_level_dn = 64;
  rig.sensor.full_scale_dn = 4064;
  rig.sensor.stamp = RIG_STAMP_CLOSED;
  rig.sensor.stamp_late_us = 2000;
  return rig;
}

// Shots come every 40 ms and take 16 ms.
struct linux_shot shot(unsigned number) {
  const double trigger_us = 5e6 + number * 40e3;
  return {number, trigger_us, trigger_us + 16e3};
}

double closed_us(unsigned number) { return shot(number).untrigger_us + 50; }

FakeFrame frame(uint32_t sequence, double stamp_us, uint8_t grey) {
  return {sequence, stamp_us, std::vector<uint8_t>(kWidth * kHeight, grey)};
}

// A plug-in's opener.
enum lam_status open_nothing(struct linux_frames* frames, const struct linux_frames_wish* wish) {
  std::snprintf(frames->error, sizeof frames->error, "nothing at %s", wish->device);
  return LAM_HARDWARE;
}

class Camera : public testing::Test {
 protected:
  void SetUp() override {
    fake_v4l2 = FakeV4l2();
    fake_v4l2.buffer_bytes = kWidth * kHeight;
  }
  void TearDown() override {
    if (camera_.self) camera_.close(camera_.self);
    EXPECT_EQ(fake_v4l2.open_files, 0);
    EXPECT_EQ(fake_v4l2.mappings, 0);
  }
  enum lam_status open() { return linux_camera_open(&camera_, &rig_, 0); }
  void arm() {
    ASSERT_EQ(open(), LAM_OK) << camera_.error;
    ASSERT_EQ(camera_.arm(camera_.self), LAM_OK) << camera_.error;
  }
  enum lam_status read(unsigned number) {
    const struct linux_shot played = shot(number);
    photograph_ = {};
    photograph_.bytes = bytes_;
    photograph_.capacity = sizeof bytes_;
    return camera_.read(camera_.self, &played, &photograph_);
  }
  // The first pixel of the last photograph, as the camera gave it.
  int grey() const { return (bytes_[0] | (bytes_[1] & 15) << 8) >> 4; }
  std::string error() const { return camera_.error; }

  struct rig rig_ = rig_of_board();
  struct linux_camera camera_ = {};
  struct hal_photograph photograph_ = {};
  uint8_t bytes_[64] = {};
};

}  // namespace

TEST_F(Camera, EachShotGetsTheFrameThatIsStampedWithIt) {
  arm();
  for (unsigned i = 0; i < 20; i++) {
    fake_v4l2.frames.push_back(frame(i, closed_us(i) + 30, uint8_t(10 + i)));
    ASSERT_EQ(read(i), LAM_OK) << error();
    EXPECT_EQ(grey(), int(10 + i));
  }
  EXPECT_STREQ(photograph_.header.pixel_format, "GREY12P");
  EXPECT_EQ(photograph_.header.width, kWidth);
  EXPECT_EQ(photograph_.header.height, kHeight);
  EXPECT_EQ(photograph_.header.size_bytes, 12u);
  EXPECT_EQ(photograph_.header.black_level_dn, 64);
  EXPECT_EQ(photograph_.header.gain_per_dn, 1.0 / 4000);
}

TEST_F(Camera, AFrameFromBeforeTheBurstIsPassedOver) {
  arm();
  fake_v4l2.frames = {frame(90, 4e6, 1), frame(91, closed_us(0), 2)};
  ASSERT_EQ(read(0), LAM_OK) << error();
  EXPECT_EQ(grey(), 2);
}

TEST_F(Camera, AFrameThatNeverComesIsATimeOut) {
  arm();
  EXPECT_EQ(read(3), LAM_DROPPED);
  EXPECT_EQ(error(),
            "left camera: no frame of shot 3: it was dropped, or the trigger did not reach the "
            "camera");
  EXPECT_EQ(error(), photograph_.error);
}

TEST_F(Camera, AFrameOfALaterShotIsKeptForItAndTheLostOneIsToldByBoth) {
  arm();
  fake_v4l2.frames = {frame(0, closed_us(0), 1), frame(2, closed_us(2), 3)};
  ASSERT_EQ(read(0), LAM_OK) << error();
  EXPECT_EQ(read(1), LAM_DROPPED);
  EXPECT_EQ(error(),
            "left camera: the frame of shot 1 was dropped, a gap of 1 in the sequence: the next, "
            "number 2, is stamped 38000 us too late");
  ASSERT_EQ(read(2), LAM_OK) << error();
  EXPECT_EQ(grey(), 3);
}

TEST_F(Camera, AFrameThatComesAfterItsShotWasGivenUpIsNotTheNextOnes) {
  arm();
  fake_v4l2.frames = {frame(0, closed_us(0), 1)};
  ASSERT_EQ(read(0), LAM_OK);
  ASSERT_EQ(read(1), LAM_DROPPED);
  fake_v4l2.frames = {frame(1, closed_us(1), 2), frame(2, closed_us(2), 3)};
  ASSERT_EQ(read(2), LAM_OK) << error();
  EXPECT_EQ(grey(), 3);
}

TEST_F(Camera, AGapThatNoLostShotExplainsIsToldOnce) {
  arm();
  fake_v4l2.frames = {frame(7, closed_us(0), 1), frame(10, closed_us(1), 2),
                      frame(11, closed_us(2), 3)};
  ASSERT_EQ(read(0), LAM_OK);
  EXPECT_EQ(read(1), LAM_DROPPED);
  EXPECT_EQ(error(),
            "left camera: a gap of 2 in the sequence before shot 1: dropped, or not triggered");
  EXPECT_EQ(read(2), LAM_OK) << error();
  EXPECT_EQ(grey(), 3);
}

TEST_F(Camera, ADropWithoutAGapIsToldByTheStampAlone) {
  arm();
  fake_v4l2.frames = {frame(0, closed_us(0), 1), frame(1, closed_us(2), 3)};
  ASSERT_EQ(read(0), LAM_OK) << error();
  EXPECT_EQ(read(1), LAM_DROPPED);
  EXPECT_EQ(error(),
            "left camera: the frame of shot 1 was dropped: the next, number 1, is stamped 38000 us "
            "too late");
}

// Stamps that come late by more than a shot fit the frame of the next one as well: only its number
// tells them apart, and no shot may get another's light.
TEST_F(Camera, WhereStampsComeLateAGapKeepsTheFrameForTheShotOfItsNumber) {
  rig_.sensor.stamp_late_us = 100e3;
  arm();
  fake_v4l2.frames = {frame(0, closed_us(0), 1), frame(3, closed_us(3), 4),
                      frame(4, closed_us(4), 5)};
  ASSERT_EQ(read(0), LAM_OK) << error();
  EXPECT_EQ(read(1), LAM_DROPPED);
  EXPECT_EQ(error(),
            "left camera: a gap of 2 in the sequence before shot 1: dropped, or not triggered");
  EXPECT_EQ(read(2), LAM_DROPPED);
  ASSERT_EQ(read(3), LAM_OK) << error();
  EXPECT_EQ(grey(), 4);
  ASSERT_EQ(read(4), LAM_OK) << error();
  EXPECT_EQ(grey(), 5);
}

TEST_F(Camera, ADamagedFrameAndAShortOneAreNoPhotographs) {
  arm();
  fake_v4l2.frames = {frame(0, closed_us(0), 1), frame(1, closed_us(1), 2)};
  fake_v4l2.frames[0].flags = V4L2_BUF_FLAG_ERROR;
  fake_v4l2.frames[1].bytes.pop_back();
  for (unsigned i = 0; i < 2; i++) {
    EXPECT_EQ(read(i), LAM_DROPPED);
    EXPECT_NE(error().find("damaged or too short"), std::string::npos) << error();
  }
  EXPECT_EQ(fake_v4l2.queued.size(), 8u) << "both buffers went back";
}

TEST_F(Camera, AStampOfTheOpeningFitsAtTheOpeningAlone) {
  rig_.sensor.stamp = RIG_STAMP_OPENED;
  arm();
  fake_v4l2.frames = {frame(0, shot(0).trigger_us + 80, 1), frame(1, closed_us(1), 2)};
  EXPECT_EQ(read(0), LAM_OK) << error();
  EXPECT_EQ(read(1), LAM_DROPPED);
}

TEST_F(Camera, AStampAfterTheReadoutFitsThere) {
  rig_.sensor.stamp = RIG_STAMP_READ_OUT;
  arm();
  fake_v4l2.frames = {frame(0, closed_us(0) + 6000, 1)};
  EXPECT_EQ(read(0), LAM_OK) << error();
}

TEST_F(Camera, AStampOfAnotherClockFitsNoShot) {
  arm();
  fake_v4l2.frames = {frame(0, 1.7e15 + closed_us(0), 1)};
  EXPECT_EQ(read(0), LAM_DROPPED);
  EXPECT_NE(error().find("too late"), std::string::npos) << error();
}

TEST_F(Camera, ACameraThatIsPulledOutIsAnError) {
  arm();
  fake_v4l2.poll_events = POLLERR;
  EXPECT_EQ(read(0), LAM_HARDWARE);
  EXPECT_NE(error().find("is gone"), std::string::npos) << error();
}

TEST_F(Camera, APhotographWithoutRoomIsNotWritten) {
  arm();
  fake_v4l2.frames = {frame(0, closed_us(0), 1)};
  const struct linux_shot played = shot(0);
  uint8_t guard[11] = {};
  photograph_.bytes = guard;
  photograph_.capacity = sizeof guard;
  EXPECT_EQ(camera_.read(camera_.self, &played, &photograph_), LAM_HARDWARE);
  EXPECT_EQ(guard[0], 0);
}

TEST_F(Camera, ArmingAgainForgetsTheLastBurst) {
  arm();
  fake_v4l2.frames = {frame(50, closed_us(0), 1), frame(60, closed_us(5), 2)};
  ASSERT_EQ(read(0), LAM_OK);
  ASSERT_EQ(read(1), LAM_DROPPED);
  camera_.disarm(camera_.self);
  EXPECT_FALSE(fake_v4l2.streams);
  ASSERT_EQ(camera_.arm(camera_.self), LAM_OK);
  fake_v4l2.frames = {frame(0, closed_us(9), 7)};
  EXPECT_EQ(read(9), LAM_OK) << error();
  EXPECT_EQ(grey(), 7);
}

TEST_F(Camera, ACameraThatGivesAnotherFormatOrSizeIsRefused) {
  fake_v4l2.fourcc = V4L2_PIX_FMT_YUYV;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_EQ(error(),
            "left camera: /dev/video0: gives 4x2 YUYV where camera.format asks for 4x2 GREY");
  fake_v4l2.fourcc = 0;
  fake_v4l2.width = 640;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("gives 640x2 GREY"), std::string::npos) << error();
}

TEST_F(Camera, RowsWithPaddingAreRead) {
  fake_v4l2.stride = 8;
  fake_v4l2.buffer_bytes = 16;
  arm();
  fake_v4l2.frames = {{0, closed_us(0), {1, 2, 3, 4, 99, 99, 99, 99, 5, 6, 7, 8}}};
  ASSERT_EQ(read(0), LAM_OK) << error();
  EXPECT_EQ(bytes_[6], 0x50);
  EXPECT_EQ(bytes_[7] & 15, 0);
}

TEST_F(Camera, RowsShorterThanTheirPixelsAreRefused) {
  fake_v4l2.stride = kWidth - 1;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("its rows are shorter than its pixels"), std::string::npos) << error();
}

TEST_F(Camera, AWakeUpWithoutAFrameIsNoFrame) {
  arm();
  fake_v4l2.poll_events = POLLIN;
  EXPECT_EQ(read(0), LAM_DROPPED);
  EXPECT_NE(error().find("no frame of shot 0"), std::string::npos) << error();
}

TEST_F(Camera, WithoutMemoryThereIsNoCamera) {
  fake_v4l2.no_memory = true;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_EQ(error(), "no memory for a camera");
}

TEST_F(Camera, ANodeThatCapturesNothingIsRefused) {
  fake_v4l2.capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("use libcamera"), std::string::npos);
}

TEST_F(Camera, OneBufferIsTooFew) {
  fake_v4l2.most_buffers = 1;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("fewer than two buffers"), std::string::npos);
}

TEST_F(Camera, ANameOfNoSourceIsABadInput) {
  std::strcpy(rig_.board.camera_left, "/dev/video0");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_EQ(error(), "left camera: is neither v4l2:DEVICE nor libcamera:ID");
}

TEST_F(Camera, WithoutThePluginALibcameraCameraSaysWhatIsMissing) {
  std::strcpy(rig_.board.camera_left, "libcamera:/base/imx296");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("lamella-libcamera.so"), std::string::npos) << error();
}

TEST_F(Camera, APluginOfAnotherVersionIsRefusedAndOneOfThisIsAsked) {
  std::strcpy(rig_.board.camera_left, "libcamera:/base/imx296");
  fake_v4l2.plugin = {LINUX_FRAMES_ABI + 1, open_nothing};
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("of another version"), std::string::npos) << error();
  fake_v4l2.plugin.abi = LINUX_FRAMES_ABI;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_EQ(error(), "left camera: nothing at /base/imx296");
}

// The trigger's mode.

TEST_F(Camera, ATriggerModeIsSetByTheNameOfItsControl) {
  std::strcpy(rig_.board.camera_trigger, "control:Trigger Mode=1");
  fake_v4l2.controls = {{"Gain", {1, 0}}, {"Trigger Mode", {V4L2_CID_PRIVATE_BASE, 0}}};
  EXPECT_EQ(open(), LAM_OK) << error();
  EXPECT_EQ(fake_v4l2.controls["Trigger Mode"].value, 1);
  EXPECT_EQ(fake_v4l2.controls["Gain"].value, 0);
}

TEST_F(Camera, AControlThatIsNotThereOrDoesNotTakeIsTold) {
  std::strcpy(rig_.board.camera_trigger, "control:Trigger Mode=1");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("/dev/video0 has no control 'Trigger Mode'"), std::string::npos);
  fake_v4l2.controls = {{"trigger mode", {V4L2_CID_PRIVATE_BASE, 0, true}}};
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("stays 0, not 1"), std::string::npos) << error();
}

TEST_F(Camera, AModulesParameterIsCheckedAndTheLineThatSetsItIsTold) {
  const std::string file = "/sys/module/imx296/parameters/trigger_mode";
  std::strcpy(rig_.board.camera_trigger, "module:imx296/parameters/trigger_mode=1");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("module is not there: " + file.substr(0, 20)), std::string::npos)
      << error();
  fake_v4l2.files[file] = "0\n";
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("write 'options imx296 trigger_mode=1' into /etc/modprobe.d/lamella.conf"),
            std::string::npos)
      << error();
  fake_v4l2.files[file] = "1\n";
  EXPECT_EQ(open(), LAM_OK) << error();
}

TEST_F(Camera, AHookThatCannotBeReadIsABadInput) {
  for (const char* hook :
       {"control:Trigger Mode", "control:=1", "control:X=one", "module:imx296=1",
        "module:../parameters/x=1", "maybe", "control:X=99999999999", "module:a/parameters/b="}) {
    std::strcpy(rig_.board.camera_trigger, hook);
    EXPECT_EQ(open(), LAM_BAD_INPUT) << hook;
  }
}

// The exposure of a camera that an edge triggers.

TEST_F(Camera, AnEdgeTriggeredCameraIsToldItsExposureAndAskedForIt) {
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 9.1;
  fake_v4l2.controls = {{"Exposure", {V4L2_CID_EXPOSURE, 0}},
                        {"Auto Exposure", {V4L2_CID_EXPOSURE_AUTO, 0}}};
  EXPECT_EQ(open(), LAM_OK) << error();
  EXPECT_EQ(fake_v4l2.controls["Exposure"].value, 2198);  // 20 ms
  EXPECT_EQ(fake_v4l2.controls["Auto Exposure"].value, V4L2_EXPOSURE_MANUAL);
  EXPECT_NEAR(camera_.exposure_us, 2198 * 9.1, 1e-9);
}

TEST_F(Camera, AnExposureThatTheCameraDoesNotTakeIsToldInMicroseconds) {
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 10;
  fake_v4l2.controls = {{"Exposure", {V4L2_CID_EXPOSURE, 500, true}}};
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("exposes for 5000.0 us where 20000.0 us were asked"), std::string::npos);
}

TEST_F(Camera, AUsbCameraIsToldItsExposureInTheUnitsThatV4l2Gives) {
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 100;
  fake_v4l2.controls = {{"Exposure Time, Absolute", {V4L2_CID_EXPOSURE_ABSOLUTE, 0}},
                        {"Auto Exposure", {V4L2_CID_EXPOSURE_AUTO, 0}}};
  EXPECT_EQ(open(), LAM_OK) << error();
  EXPECT_EQ(fake_v4l2.controls["Exposure Time, Absolute"].value, 200);  // 20 ms
  EXPECT_NEAR(camera_.exposure_us, 20000, 1e-9);
  camera_.close(camera_.self);
  camera_.self = nullptr;
  rig_.sensor.exposure_step_us = 9.1;
  EXPECT_EQ(open(), LAM_BAD_INPUT);
  EXPECT_NE(error().find("'camera.exposure_step_us = 100'"), std::string::npos) << error();
}

TEST_F(Camera, AnEdgeTriggeredCameraWithoutAStepOfExposureIsABadInput) {
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 0;
  EXPECT_EQ(open(), LAM_BAD_INPUT);
  EXPECT_NE(error().find("camera.exposure_step_us"), std::string::npos) << error();
}

TEST_F(Camera, TheStampOfAnEdgeTriggeredFrameCountsFromItsEdge) {
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 10;
  fake_v4l2.controls = {{"Exposure", {V4L2_CID_EXPOSURE, 0}}};
  arm();
  fake_v4l2.frames = {frame(0, shot(0).trigger_us + 50 + 20000, 1), frame(1, closed_us(1), 2),
                      frame(2, shot(2).trigger_us + 50 + 20000, 3)};
  EXPECT_EQ(read(0), LAM_OK) << error();
  EXPECT_EQ(read(1), LAM_DROPPED) << "stamped when the pulse ended, which means nothing here";
  EXPECT_EQ(read(2), LAM_OK) << error();
}

TEST_F(Camera, ControlsMayLiveInAnotherDevice) {
  std::strcpy(rig_.board.camera_left_controls, "/dev/v4l-subdev2");
  std::strcpy(rig_.board.camera_trigger, "control:Trigger Mode=1");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("/dev/v4l-subdev2 has no control"), std::string::npos) << error();
}

// Every system call of a whole burst fails once, in turn.
TEST_F(Camera, NoFailedCallGoesUnnoticedOrLeavesAnythingOpen) {
  std::strcpy(rig_.board.camera_trigger, "control:Trigger Mode=1");
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 10;
  const auto burst = [&] {
    SetUp();
    fake_v4l2.controls = {{"Exposure", {V4L2_CID_EXPOSURE, 0}},
                          {"Auto Exposure", {V4L2_CID_EXPOSURE_AUTO, 0}},
                          {"Trigger Mode", {V4L2_CID_PRIVATE_BASE, 0}}};
    fake_v4l2.frames = {frame(0, shot(0).trigger_us + 50 + 20000, 1)};
  };
  const auto play = [&]() -> enum lam_status {
    enum lam_status status = open(); if (status != LAM_OK) return status;
    status = camera_.arm(camera_.self);
    if (status == LAM_OK) status = read(0);
    camera_.disarm(camera_.self);
    camera_.close(camera_.self);
    camera_.self = nullptr;
    return status;
  };
  burst();
  ASSERT_EQ(play(), LAM_OK) << error();
  const std::vector<std::string> calls = fake_v4l2.called;
  ASSERT_GT(calls.size(), 30u);
  for (size_t i = 0; i < calls.size(); i++) {
    burst();
    fake_v4l2.failing_call = int(i);
    const enum lam_status status = play();
    EXPECT_EQ(status, calls[i] == "STREAMOFF" ? LAM_OK : LAM_HARDWARE) << i << " " << calls[i];
    if (status != LAM_OK) {
      EXPECT_GT(error().size(), 20u) << calls[i];
    }
    EXPECT_EQ(fake_v4l2.open_files, 0) << calls[i];
    EXPECT_EQ(fake_v4l2.mappings, 0) << calls[i];
  }
}

TEST_F(Camera, ASignalDuringACallIsNoFailure) {
  for (int i = 0; i < 3; i++) {  // poll, DQBUF, QBUF
    SetUp();
    fake_v4l2.failing_errno = EINTR;
    arm();
    fake_v4l2.failing_call = fake_v4l2.calls + i;
    fake_v4l2.frames = {frame(0, closed_us(0), 1)};
    EXPECT_EQ(read(0), LAM_OK) << error();
    camera_.close(camera_.self);
    camera_.self = nullptr;
  }
}
