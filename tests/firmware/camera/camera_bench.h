// A board's left camera, on a kernel that is played (fake_v4l2.h).
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "fake_v4l2.h"

extern "C" {
#include "hal_linux_camera.h"
}

inline constexpr uint32_t kWidth = 4, kHeight = 2;

inline struct rig rig_of_board() {
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
inline struct linux_shot shot(unsigned number) {
  const double trigger_us = 5e6 + number * 40e3;
  return {number, trigger_us, trigger_us + 16e3};
}

inline double closed_us(unsigned number) { return shot(number).untrigger_us + 50; }

inline FakeFrame frame(uint32_t sequence, double stamp_us, uint8_t grey) {
  return {sequence, stamp_us, std::vector<uint8_t>(kWidth * kHeight, grey)};
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
