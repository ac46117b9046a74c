#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "../test_rig.h"

namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;

const Pairs kCameras = {{"linux.camera_left", "v4l2:/dev/video0"},
                        {"linux.camera_right", "v4l2:/dev/video1"},
                        {"linux.camera_trigger", "fixed"},
                        {"camera.width_px", "1456"},
                        {"camera.height_px", "1088"},
                        {"camera.format", "Y10P"},
                        {"camera.black_level_dn", "240"},
                        {"camera.full_scale_dn", "4092"},
                        {"camera.trigger", "level"},
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

// What the whole rig file says to these cameras: "" where it is right.
std::string answer(const Pairs& pairs, double frame_bytes = kFrameBytes) {
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
  return rig_parse(kept.data(), kept.size(), &rig, &errors) == LAM_OK ? "" : errors.list[0].text;
}

Pairs with(const std::string& key, const std::string& value) {
  Pairs pairs = kCameras;
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
                       {"camera.stamp", "now"},          {"camera.stamp_late_us", "soon"}};
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
