// hal_linux_display on a display that is played (fake_drm).
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "fake_drm.h"
#include "test_rig.h"

extern "C" {
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "hal_linux_display.h"
}

namespace {

FakeDrm& kernel = fake_drm();

class LinuxDisplay : public testing::Test {
 protected:
  void SetUp() override {
    reset_fake_drm();
    rig_ = test_rig();
    rig_.projector_refresh_hz = 1e6 / kFakeRefreshUs;
    std::snprintf(path_, sizeof path_, "%s", "/tmp/lamella_display_XXXXXX");
    const int fd = mkstemp(path_);
    ASSERT_GE(fd, 0);
    ASSERT_EQ(ftruncate(fd, kFakeBufferBytes * PATTERN_IMAGES), 0);
    ::close(fd);
    std::snprintf(rig_.board.display_device, sizeof rig_.board.display_device, "%s", path_);
    std::snprintf(rig_.board.display_connector, sizeof rig_.board.display_connector, "HDMI-A-1");
  }
  void TearDown() override {
    linux_display_close(&display_);
    unlink(path_);
  }
  enum lam_status open() { return linux_display_open(&display_, &rig_); }
  std::string refusal() {
    EXPECT_EQ(open(), LAM_HARDWARE);
    expect_nothing_left();
    return display_.error;
  }
  // The device's name is another in each run.
  std::string refusal_of_device() {
    const std::string text = refusal();
    EXPECT_EQ(text.rfind(path_, 0), 0u) << text;
    return text.substr(std::strlen(path_));
  }
  void expect_nothing_left() {
    EXPECT_EQ(kernel.objects, 0);
    EXPECT_EQ(kernel.buffers.size(), 0u);
    EXPECT_EQ(kernel.framebuffers, std::set<uint32_t>({kFakeConsole}));
    EXPECT_EQ(display_.fd, -1);
  }
  void open_and_count() {
    ASSERT_EQ(open(), LAM_OK) << display_.error;
    ASSERT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_OK);
  }
  enum lam_status commit(lamella_v1_PatternSpan_Kind kind, uint8_t index = 0) {
    return linux_display_commit(&display_, {kind, index}, &at_us_);
  }

  struct rig rig_;
  struct linux_display display_ = {};
  char path_[64];
  double at_us_ = 0;
};

}  // namespace

TEST_F(LinuxDisplay, HoldsEveryImageOfTheBurstInABufferOfItsOwn) {
  ASSERT_EQ(open(), LAM_OK) << display_.error;
  EXPECT_EQ(kernel.buffers.size(), size_t(PATTERN_IMAGES));
  EXPECT_EQ(display_.bytes, kFakeBufferBytes * PATTERN_IMAGES);
  const int fd = ::open(path_, O_RDONLY);
  void* held = mmap(nullptr, display_.bytes, PROT_READ, MAP_SHARED, fd, 0);
  std::vector<uint32_t> drawn(kFakeBufferBytes / 4);
  for (size_t image = 0; image < PATTERN_IMAGES; image++) {
    pattern_draw(&rig_, image, drawn.data(), 1280);
    EXPECT_EQ(std::memcmp(static_cast<char*>(held) + image * kFakeBufferBytes, drawn.data(),
                          kFakeBufferBytes),
              0)
        << image;
  }
  munmap(held, display_.bytes);
  ::close(fd);
}

TEST_F(LinuxDisplay, IsSetWholeUnscaledAndFullRangeWithNothingOverIt) {
  ASSERT_EQ(open(), LAM_OK) << display_.error;
  EXPECT_EQ(kernel.property(kFakeConnector, "max bpc").value, 8u);
  EXPECT_EQ(kernel.property(kFakeConnector, "Broadcast RGB").value, 1u);
  EXPECT_EQ(kernel.property(kFakeCrtc, "ACTIVE").value, 1u);
  EXPECT_EQ(kernel.property(kFakePlane, "SRC_X").value, 0u);
  EXPECT_EQ(kernel.property(kFakePlane, "SRC_W").value, uint64_t{1280} << 16);
  EXPECT_EQ(kernel.property(kFakePlane, "CRTC_W").value, 1280u);
  EXPECT_EQ(kernel.property(kFakePlane, "CRTC_H").value, 800u);
  EXPECT_EQ(kernel.property(kFakeCursor, "FB_ID").value, 0u);
  EXPECT_EQ(kernel.property(kFakeCursor, "CRTC_ID").value, 0u);
}

TEST_F(LinuxDisplay, TakesTheModeThatRefreshesAsTheRigFileSays) {
  ASSERT_EQ(open(), LAM_OK);
  EXPECT_NEAR(display_.output.refresh_us, kFakeRefreshUs, 1e-6);
}

TEST_F(LinuxDisplay, GoesBackToTheConsoleItCameFrom) {
  ASSERT_EQ(open(), LAM_OK);
  linux_display_close(&display_);
  EXPECT_EQ(kernel.property(kFakeConnector, "max bpc").value, 12u);
  EXPECT_EQ(kernel.property(kFakeConnector, "Broadcast RGB").value, 0u);
  EXPECT_EQ(kernel.property(kFakePlane, "FB_ID").value, uint64_t{kFakeConsole});
  EXPECT_EQ(kernel.property(kFakePlane, "SRC_W").value, 77u);
  EXPECT_EQ(kernel.property(kFakeCursor, "CRTC_ID").value, uint64_t{kFakeCrtc});
  EXPECT_NE(kernel.property(kFakeCrtc, "MODE_ID").value, 0u);  // a copy of the mode that it had
  expect_nothing_left();
  EXPECT_EQ(kernel.blobs.size(), 0u);
}

TEST_F(LinuxDisplay, FlipsAtTheNextVblankAndSaysWhenOnce) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_FRINGE, 2), LAM_OK) << display_.error;
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  kernel.vblank();
  ASSERT_TRUE(linux_display_flipped(&display_, &at_us_));
  EXPECT_DOUBLE_EQ(at_us_, static_cast<double>(kernel.now_us));
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  const size_t image = pattern_image({lamella_v1_PatternSpan_Kind_FRINGE, 2});
  EXPECT_EQ(kernel.shown, display_.framebuffers[image]);
  EXPECT_STREQ(display_.error, "");
}

TEST_F(LinuxDisplay, AFlipThatMissesItsVblankTellsTheLaterOne) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_STRIPES, 1), LAM_OK);
  kernel.vblank(2, 2);
  ASSERT_TRUE(linux_display_flipped(&display_, &at_us_));
  EXPECT_DOUBLE_EQ(at_us_, static_cast<double>(kernel.now_us));
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_OK);
}

TEST_F(LinuxDisplay, AGapInTheVblanksIsAFaultUntilTheyAreCountedAnew) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_DOTS), LAM_OK);
  kernel.vblank(2, 1);
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_HARDWARE);
  EXPECT_STREQ(display_.error,
               "the flip to dots: 1 vblanks counted in 33439 us, 16720 us each: some were lost");
  ASSERT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_OK);
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_OK);
}

TEST_F(LinuxDisplay, ASecondFlipBeforeTheFirstIsRefused) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_DOTS), LAM_OK);
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "white: the flip before has not happened yet");
}

TEST_F(LinuxDisplay, APatternThatIsNotThereIsRefused) {
  open_and_count();
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_FRINGE, 4), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "fringe 4: the projector has no such pattern");
}

TEST_F(LinuxDisplay, AFlipOfABurstThatWasGivenUpIsForgottenBeforeTheNext) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_DOTS), LAM_OK);
  ASSERT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_OK);
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_OK);
}

TEST_F(LinuxDisplay, AFlipThatNeverHappensIsAFault) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_DOTS), LAM_OK);
  kernel.waiting = nullptr;
  EXPECT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "the projector: a flip never happened");
}

TEST_F(LinuxDisplay, EveryCallThatFailsDuringABurstSaysWhat) {
  open_and_count();
  kernel.failing = {"flip"};
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "white: Invalid argument");
  kernel.failing = {"wait"};
  EXPECT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "waiting for the projector's vblank: Invalid argument");
  kernel.failing = {};
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_OK);
  kernel.failing = {"event"};
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  EXPECT_STREQ(display_.error, "the projector's events: Invalid argument");
  EXPECT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_HARDWARE);
}

// Each call to the kernel in turn: opening fails with a reason and leaves nothing behind, or does
// without what was asked.
TEST_F(LinuxDisplay, EveryCallThatFailsWhileItIsOpenedIsToldAndLeavesNothingBehind) {
  int failures = 0;
  for (int call = 0;; call++) {
    reset_fake_drm();
    kernel.failing_call = call;
    if (open() == LAM_OK) {
      const bool through = kernel.calls <= call;
      linux_display_close(&display_);
      expect_nothing_left();
      if (through) break;
      continue;
    }
    failures++;
    EXPECT_STRNE(display_.error, "") << call;
    expect_nothing_left();
    EXPECT_LE(kernel.blobs.size(), 1u) << call;
    EXPECT_EQ(kernel.property(kFakePlane, "FB_ID").value, uint64_t{kFakeConsole})
        << call << ": " << display_.error;
  }
  EXPECT_GT(failures, 100);
}

TEST_F(LinuxDisplay, MemoryThatCannotBeHadIsNamedWithItsSize) {
  for (const char* what : {"buffer", "map", "offset"}) {
    kernel.failing = {what};
    EXPECT_EQ(refusal(),
              "image 1 of 11 of the projector, 4096000 bytes each: Invalid argument (on a board: "
              "cma= of the kernel)");
  }
}

TEST_F(LinuxDisplay, AProjectorThatIsNotAsTheRigFileSaysIsRefusedWithBothNumbers) {
  kernel.native_width = 1920;
  EXPECT_EQ(refusal(),
            "HDMI-A-1 has 1920 x 800 pixels, projector.width_px x height_px are 1280 x 800");
  kernel.native_width = 1280;
  rig_.projector_refresh_hz = 60;
  EXPECT_EQ(refusal(), "HDMI-A-1 refreshes at 59.8103 Hz, projector.refresh_hz is 60");
  kernel.interlaced = true;
  EXPECT_EQ(refusal(), "HDMI-A-1: only interlaced modes have the projector's pixels");
}

TEST_F(LinuxDisplay, AProjectorThatPrefersNothingIsTakenAtItsFirstMode) {
  kernel.preferred = false;
  EXPECT_EQ(open(), LAM_OK) << display_.error;
}

TEST_F(LinuxDisplay, WhatIsMissingIsNamed) {
  kernel.connected = false;
  EXPECT_EQ(refusal(), "HDMI-A-1: no projector answers: is it switched on?");
  kernel.connected = true;
  kernel.plane_format = DRM_FORMAT_NV12;
  EXPECT_EQ(refusal(), "HDMI-A-1: no primary plane shows XRGB8888 on its CRTC");
  kernel.plane_format = DRM_FORMAT_XRGB8888;
  kernel.failing = {"encoder"};
  EXPECT_EQ(refusal(), "HDMI-A-1: no CRTC can feed this connector");
  kernel.failing = {};
  kernel.property(kFakePlane, "CRTC_W").name = "other";
  EXPECT_EQ(refusal(), "CRTC_W: the display has no such property");
  std::snprintf(rig_.board.display_connector, sizeof rig_.board.display_connector, "DP-2");
  EXPECT_EQ(refusal(), "DP-2: the display device has no such connector (linux.display_connector)");
}

TEST_F(LinuxDisplay, ADeviceThatWillNotDoIsRefused) {
  kernel.failing = {"atomic"};
  EXPECT_EQ(refusal_of_device(), ": has no atomic mode setting");
  kernel.failing = {};
  kernel.monotonic = 0;
  EXPECT_EQ(refusal_of_device(), ": tells no monotonic time of its vblanks");
  kernel.monotonic = 1;
  kernel.master = false;
  EXPECT_EQ(refusal_of_device(), ": another program has the display: stop its desktop");
  std::snprintf(rig_.board.display_device, sizeof rig_.board.display_device, "/dev/dri/card77");
  EXPECT_EQ(refusal(), "/dev/dri/card77: No such file or directory");
}
