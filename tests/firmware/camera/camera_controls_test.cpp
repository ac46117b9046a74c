// What a board's camera is told before a burst: its trigger's mode and its exposure.
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cstring>
#include <string>

#include "camera_bench.h"

namespace {

class CameraControls : public Camera {};

}  // namespace

TEST_F(CameraControls, ATriggerModeIsSetByTheNameOfItsControl) {
  std::strcpy(rig_.board.camera_trigger, "control:Trigger Mode=1");
  fake_v4l2.controls = {{"Gain", {1, 0}}, {"Trigger Mode", {V4L2_CID_PRIVATE_BASE, 0}}};
  EXPECT_EQ(open(), LAM_OK) << error();
  EXPECT_EQ(fake_v4l2.controls["Trigger Mode"].value, 1);
  EXPECT_EQ(fake_v4l2.controls["Gain"].value, 0);
}

TEST_F(CameraControls, AControlThatIsNotThereOrDoesNotTakeIsTold) {
  std::strcpy(rig_.board.camera_trigger, "control:Trigger Mode=1");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("/dev/video0 has no control 'Trigger Mode'"), std::string::npos);
  fake_v4l2.controls = {{"trigger mode", {V4L2_CID_PRIVATE_BASE, 0, true}}};
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("stays 0, not 1"), std::string::npos) << error();
}

TEST_F(CameraControls, AModulesParameterIsCheckedAndTheLineThatSetsItIsTold) {
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

TEST_F(CameraControls, AHookThatCannotBeReadIsABadInput) {
  for (const char* hook :
       {"control:Trigger Mode", "control:=1", "control:X=one", "module:imx296=1",
        "module:../parameters/x=1", "maybe", "control:X=99999999999", "module:a/parameters/b="}) {
    std::strcpy(rig_.board.camera_trigger, hook);
    EXPECT_EQ(open(), LAM_BAD_INPUT) << hook;
  }
}

// The exposure of a camera that an edge triggers.

TEST_F(CameraControls, AnEdgeTriggeredCameraIsToldItsExposureAndAskedForIt) {
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 9.1;
  fake_v4l2.controls = {{"Exposure", {V4L2_CID_EXPOSURE, 0}},
                        {"Auto Exposure", {V4L2_CID_EXPOSURE_AUTO, 0}}};
  EXPECT_EQ(open(), LAM_OK) << error();
  EXPECT_EQ(fake_v4l2.controls["Exposure"].value, 2198);  // 20 ms
  EXPECT_EQ(fake_v4l2.controls["Auto Exposure"].value, V4L2_EXPOSURE_MANUAL);
  EXPECT_NEAR(camera_.exposure_us, 2198 * 9.1, 1e-9);
}

TEST_F(CameraControls, AnExposureThatTheCameraDoesNotTakeIsToldInMicroseconds) {
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 10;
  fake_v4l2.controls = {{"Exposure", {V4L2_CID_EXPOSURE, 500, true}}};
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("exposes for 5000.0 us where 20000.0 us were asked"), std::string::npos);
}

TEST_F(CameraControls, AUsbCameraIsToldItsExposureInTheUnitsThatV4l2Gives) {
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

TEST_F(CameraControls, AnEdgeTriggeredCameraWithoutAStepOfExposureIsABadInput) {
  rig_.sensor.edge_triggered = true;
  rig_.sensor.exposure_step_us = 0;
  EXPECT_EQ(open(), LAM_BAD_INPUT);
  EXPECT_NE(error().find("camera.exposure_step_us"), std::string::npos) << error();
}

TEST_F(CameraControls, TheStampOfAnEdgeTriggeredFrameCountsFromItsEdge) {
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

TEST_F(CameraControls, ControlsMayLiveInAnotherDevice) {
  std::strcpy(rig_.board.camera_left_controls, "/dev/v4l-subdev2");
  std::strcpy(rig_.board.camera_trigger, "control:Trigger Mode=1");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(error().find("/dev/v4l-subdev2 has no control"), std::string::npos) << error();
}
