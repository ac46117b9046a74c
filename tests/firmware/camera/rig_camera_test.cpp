#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "../test_rig.h"

namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

const Pairs kCameras = {{"linux.camera_left", "v4l2:/dev/video0"},
                        {"linux.camera_right", "v4l2:/dev/video1"},
                        {"linux.camera_trigger", "fixed"},
                        {"camera.sensor", "other"},
                        {"camera.width_px", "1456"},
                        {"camera.height_px", "1088"},
                        {"camera.format", "Y10P"},
                        {"camera.black_level_dn", "240"},
                        {"camera.full_scale_dn", "4092"},
                        {"camera.trigger", "level"},
                        {"camera.trigger_active", "high"},
                        {"camera.stamp", "closed"},
                        {"camera.stamp_late_us", "2000"}};
const char kBoard[] = R"(
linux.gpio_chip = /dev/gpiochip0
linux.spi_device = /dev/spidev0.0
linux.blank_line = BLANK
linux.latch_line = LATCH
linux.trigger_line = TRIGGER
linux.lamp_line = LAMP
linux.analyser_line = ANALYSER
linux.cpu = 3
linux.priority = 80
linux.spin_us = 200
)";
const double kFrameBytes = 1456 * 1088 / 2 * 3;

struct Answer {
  std::string says, blamed;  // the first complaint, and the line that it is of; "" where none is
};

// What the whole rig file says to these cameras: "" where it is right.
Answer answer_with_line(const Pairs& pairs, double frame_bytes = kFrameBytes) {
  const std::string text = rig_file_text();
  std::string kept = kBoard;
  for (size_t at = 0, end; at < text.size(); at = end + 1) {
    end = text.find('\n', at);
    const std::string line = text.substr(at, end - at);
    const std::string key = line.substr(0, line.find_first_of(" ="));
    bool ours = key == "camera.frame_bytes";
    for (const auto& pair : kCameras) ours = ours || key == pair.first;
    if (!ours) kept += line + "\n";
  }
  kept += "camera.frame_bytes = " + std::to_string(long(frame_bytes)) + "\n";
  for (const auto& [key, value] : pairs) kept += key + " = " + value + "\n";
  struct rig rig;
  struct rig_errors errors;
  if (rig_parse(kept.data(), kept.size(), &rig, &errors) == LAM_OK) return {};
  std::istringstream lines(kept);
  std::string blamed;
  for (int i = 0; i < errors.list[0].line; i++) std::getline(lines, blamed);
  return {errors.list[0].text, blamed};
}

std::string answer(const Pairs& pairs, double frame_bytes = kFrameBytes) {
  return answer_with_line(pairs, frame_bytes).says;
}

Pairs with(const std::string& key, const std::string& value, Pairs pairs = kCameras) {
  for (auto& pair : pairs) {
    if (pair.first == key) pair.second = value;
  }
  return pairs;
}

Pairs without(const std::string& key) {
  Pairs pairs;
  for (const auto& pair : kCameras) {
    if (pair.first != key) pairs.push_back(pair);
  }
  return pairs;
}

// As cameras.md has them.
Pairs imx296() {
  return with("linux.camera_trigger", "module:imx296/parameters/trigger_mode=1",
              with("camera.sensor", "imx296"));
}

Pairs ov9281() {
  Pairs pairs = with("camera.sensor", "ov9281");
  for (const auto& [key, value] : Pairs{{"camera.width_px", "1280"},
                                        {"camera.height_px", "800"},
                                        {"camera.format", "GREY"},
                                        {"camera.trigger", "edge"},
                                        {"linux.camera_trigger", "control:Trigger Mode=1"}}) {
    pairs = with(key, value, pairs);
  }
  return pairs;
}
const double kOv9281Bytes = 1280 * 800 / 2 * 3;

}  // namespace

TEST(RigCamera, AWholeDescriptionIsTaken) { EXPECT_EQ(answer(kCameras), ""); }

TEST(RigCamera, EveryKeyIsMissedWhereACameraIsGiven) {
  for (const auto& [key, value] : kCameras) {
    EXPECT_NE(answer(without(key)).find(key), std::string::npos) << answer(without(key));
  }
}

TEST(RigCamera, AWrongValueIsNamedByItsKey) {
  const Pairs wrong = {{"camera.width_px", "1456.5"},    {"camera.height_px", "0"},
                       {"camera.format", "YUYV"},        {"camera.black_level_dn", "-1"},
                       {"camera.full_scale_dn", "4096"}, {"camera.trigger", "both"},
                       {"camera.stamp", "now"},          {"camera.stamp_late_us", "soon"},
                       {"camera.sensor", "imx219"},      {"camera.trigger_active", "1"}};
  for (const auto& [key, value] : wrong) {
    EXPECT_NE(answer(with(key, value)).find(key), std::string::npos) << key;
  }
}

TEST(RigCamera, FullScaleIsAboveBlack) {
  EXPECT_EQ(answer(with("camera.full_scale_dn", "240")),
            "'camera.full_scale_dn' must be above camera.black_level_dn");
}

TEST(RigCamera, ThePlannersFrameIsTheCamerasFrame) {
  EXPECT_EQ(answer(kCameras, 1000000),
            "'camera.frame_bytes' must be 2376192, which width_px x height_px take");
}

TEST(RigCamera, AKeyMayNotComeTwice) {
  Pairs twice = kCameras;
  twice.emplace_back("camera.stamp", "opened");
  EXPECT_EQ(answer(twice), "'camera.stamp' is given twice");
}

TEST(RigCamera, ATriggerIsActiveHighOrLow) {
  EXPECT_EQ(answer(with("camera.trigger_active", "low")), "");
  EXPECT_EQ(answer(with("camera.trigger_active", "falling")),
            "'camera.trigger_active' is high or low");
}

TEST(RigCamera, TheNamedSensorsAreTakenAsTheirPageHasThem) {
  EXPECT_EQ(answer(imx296()), "");
  EXPECT_EQ(answer(ov9281(), kOv9281Bytes), "");
}

TEST(RigCamera, AnImx296WithoutItsTriggerModeIsToldWhichLineIsMissing) {
  const std::string wanted =
      "an imx296 wants 'linux.camera_trigger = module:imx296/parameters/trigger_mode=1'";
  for (const char* hook :
       {"fixed", "control:Trigger Mode=1", "module:imx296/parameters/trigger_mode=0",
        "module:imx477/parameters/trigger_mode=1"}) {
    EXPECT_EQ(answer(with("linux.camera_trigger", hook, imx296())), wanted) << hook;
  }
}

TEST(RigCamera, AnOv9281NeedsAControlThatMakesItWaitForTriggers) {
  for (const char* hook : {"fixed", "module:ov9282/parameters/trigger_mode=1"}) {
    const std::string told = answer(with("linux.camera_trigger", hook, ov9281()), kOv9281Bytes);
    EXPECT_NE(told.find("an ov9281 wants 'linux.camera_trigger = control:NAME=VALUE'"),
              std::string::npos)
        << told;
  }
}

TEST(RigCamera, WhatContradictsTheSensorIsNamed) {
  EXPECT_EQ(answer(with("camera.trigger", "edge", imx296())),
            "an imx296 wants 'camera.trigger = level'");
  EXPECT_EQ(answer(with("camera.trigger", "level", ov9281()), kOv9281Bytes),
            "an ov9281 wants 'camera.trigger = edge'");
  EXPECT_EQ(answer(with("camera.format", "SRGGB10P", imx296())),
            "an imx296 does not give 'camera.format = SRGGB10P'");
  EXPECT_EQ(answer(with("camera.width_px", "1288", ov9281()), 1288 * 800 / 2 * 3),
            "an ov9281 has no more than 1280 x 800 pixels: 'camera.width_px', 'height_px'");
}

TEST(RigCamera, AHookOfNoKindIsToldBeforeAnyCameraIsOpened) {
  for (const char* hook : {"maybe", "control:Trigger Mode", "control:X=one", "control:X=0x1",
                           "control:X=01", "control:X= 1", "module:imx296=1"}) {
    const std::string told = answer(with("linux.camera_trigger", hook));
    EXPECT_NE(told.find("'linux.camera_trigger' is '" + std::string(hook) + "', which is no"),
              std::string::npos)
        << told;
  }
}

TEST(RigCamera, ADeviceThatTheDaemonCouldNotOpenIsRefusedByTheFile) {
  for (const char* key : {"linux.camera_left", "linux.camera_right"}) {
    for (const char* device : {"/dev/video7", "v4l2:", "libcamera:", "usb:1"}) {
      const Answer answer = answer_with_line(with(key, device), kFrameBytes);
      EXPECT_EQ(answer.says, std::string("'") + key + "' is '" + device +
                                 "': it must be v4l2:DEVICE or libcamera:ID");
      EXPECT_EQ(answer.blamed, std::string(key) + " = " + device);
    }
  }
}

TEST(RigCamera, BothCamerasOnOneDeviceAreRefused) {
  const Answer answer =
      answer_with_line(with("linux.camera_right", "v4l2:/dev/video0"), kFrameBytes);
  EXPECT_EQ(answer.says, "'linux.camera_right' is the device that 'linux.camera_left' has");
  EXPECT_EQ(answer.blamed, "linux.camera_right = v4l2:/dev/video0");
}

TEST(RigCamera, WhatDoesNotFitTogetherIsToldWithTheLineOfTheKeyAtFault) {
  const std::vector<std::pair<Pairs, std::string>> wrong = {
      {with("linux.camera_trigger", "bogus"), "linux.camera_trigger = bogus"},
      {with("camera.trigger", "edge", imx296()), "camera.trigger = edge"},
      {with("linux.camera_trigger", "fixed", imx296()), "linux.camera_trigger = fixed"},
      {with("camera.format", "SRGGB12", imx296()), "camera.format = SRGGB12"},
      {with("camera.full_scale_dn", "100"), "camera.full_scale_dn = 100"},
      {without("linux.camera_right"), "linux.camera_left = v4l2:/dev/video0"},
      {without("camera.stamp"), "linux.camera_left = v4l2:/dev/video0"}};
  for (const auto& [pairs, blamed] : wrong) {
    const Answer answer = answer_with_line(pairs, kFrameBytes);
    EXPECT_NE(answer.says, "") << blamed;
    EXPECT_EQ(answer.blamed, blamed) << answer.says;
  }
  EXPECT_EQ(answer_with_line(kCameras, 100).blamed, "camera.frame_bytes = 100");
}
