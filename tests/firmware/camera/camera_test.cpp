// A board's camera: which frame becomes which shot's photograph, and what is said where one is
// missing.
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <poll.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "camera_bench.h"

namespace {

// A plug-in's opener.
enum lam_status open_nothing(struct linux_frames* frames, const struct linux_frames_wish* wish) {
  std::snprintf(frames->error, sizeof frames->error, "nothing at %s", wish->device);
  return LAM_HARDWARE;
}

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
