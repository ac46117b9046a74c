// hal_linux as a whole on a board that is played here: each call of the kernel fails once.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>

#include <cstring>
#include <string>

#include "../fake_gpio.h"
#include "../test_rig.h"
#include "fake_board.h"

extern "C" {
#include "hal_linux.h"
#include "hal_linux_time.h"
}

namespace {

struct rig board_rig() {
  struct rig rig = test_rig();
  struct rig_linux* b = &rig.board;
  b->given = true;
  b->cpu = 3;
  b->priority = 80;
  const std::pair<char*, const char*> texts[] = {{b->gpio_chip, "/dev/gpiochip0"},
                                                 {b->spi_device, "/dev/spidev0.0"},
                                                 {b->blank_line, "BLANK"},
                                                 {b->latch_line, "LATCH"},
                                                 {b->trigger_line, "TRIGGER"},
                                                 {b->lamp_line, "LAMP"},
                                                 {b->analyser_line, "ANALYSER"},
                                                 {b->heartbeat_line, "HEARTBEAT"},
                                                 {b->ready_line, "READY"},
                                                 {b->buzzer_line, "BUZZER"},
                                                 {b->start_line, "START"},
                                                 {b->estop_line, "ESTOP"},
                                                 {b->at_parallel_line, "PARALLEL"},
                                                 {b->at_crossed_line, "CROSSED"},
                                                 {b->blank_seen_line, "BLANK_IN"},
                                                 {b->trigger_seen_line, "TRIGGER_IN"},
                                                 {b->temperature_file, "/fake/temperature"}};
  for (const auto& [field, text] : texts) std::strcpy(field, text);
  return rig;
}

class Board : public testing::Test {
 protected:
  void SetUp() override { start_over(); }
  void start_over() {
    fake_gpio() = FakeGpio();
    fake_gpio().levels = {{"ESTOP", 1}, {"PARALLEL", 1}, {"CROSSED", 0}};
    fake_board = FakeBoard();
  }
  enum lam_status open() {
    const enum lam_status claimed = hal_linux_claim(&board_, &rig_);
    if (claimed != LAM_OK) return claimed;
    const enum lam_status opened = hal_linux_open(&board_);
    if (opened != LAM_OK) hal.close(&board_);
    return opened;
  }
  void expect_nothing_held() {
    EXPECT_EQ(fake_gpio().opened, fake_gpio().closed);
    EXPECT_TRUE(fake_gpio().held.empty()) << *fake_gpio().held.begin();
    EXPECT_EQ(fake_board.open_files, 0);
  }

  // Everything that a burst does once; stops at the first failure.
  enum lam_status exercise() {
    double at_us = 0;
    hal_senses senses;
    hal_seen_edge seen;
    const uint8_t stream[CHAIN_BYTES] = {1, 2, 3};
    enum lam_status status = hal.prepare(&board_, &at_us);
    for (int line = 0; line < HAL_LINES && status == LAM_OK; line++) {
      status = hal.set_line(&board_, hal_line(line), true, &at_us);
    }
    if (status == LAM_OK) status = hal.shift_leds(&board_, stream, nullptr, &at_us);
    if (status == LAM_OK) status = hal.move_analyser(&board_, true, &at_us);
    fake_gpio().levels["PARALLEL"] = 0;
    fake_gpio().edges = {{"BLANK_IN", true, at_us}, {"CROSSED", true, at_us + 1}};
    hal.next_seen(&board_, &seen);
    hal.arrived(&board_, &at_us);
    board_.thermometer.due_us = 0;
    if (status == LAM_OK) status = hal.sense(&board_, &senses);
    return status == LAM_OK ? hal.resume(&board_, &at_us) : status;
  }

  struct rig rig_ = board_rig();
  struct hal_linux board_;
  struct hal& hal = board_.hal;
};

}  // namespace

TEST_F(Board, OpensEverythingThatTheRigFileNamesAndGivesItBack) {
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  EXPECT_EQ(fake_gpio().asked.size(), 14u);
  EXPECT_EQ(fake_board.open_files, 3);
  ASSERT_EQ(exercise(), LAM_OK) << hal.error;
  EXPECT_EQ(fake_board.shifted.size(), size_t(CHAIN_BYTES));
  hal.close(&board_);
  EXPECT_EQ(fake_gpio().levels["BLANK"], 1);
  EXPECT_EQ(fake_gpio().levels["LAMP"], 0);
  expect_nothing_held();
}

TEST_F(Board, ASequencerHasAProcessorOfItsOwnAndMemoryThatStays) {
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  EXPECT_EQ(fake_board.cpu, 3);
  EXPECT_EQ(fake_board.policy & ~SCHED_RESET_ON_FORK, SCHED_FIFO);
  EXPECT_EQ(fake_board.priority, 80);
  EXPECT_EQ(fake_board.locked, MCL_CURRENT | MCL_FUTURE);
  EXPECT_EQ(fake_board.latency_us, 0);
  EXPECT_GE(board_.latency_fd, 0) << "the kernel honours it while the file is open";
  hal.close(&board_);
}

TEST_F(Board, EachCallThatOpensItFailsOnceAndNothingStaysHeld) {
  int settings = 0, failures = 0;
  for (int call = 0;; call++) {
    start_over();
    fake_gpio().failing_call = call;
    testing::internal::CaptureStderr();
    const enum lam_status status = open();
    const std::string told = testing::internal::GetCapturedStderr();
    if (fake_gpio().calls <= call) break;
    if (status == LAM_OK) {  // a setting that cannot be had is told, and the rig works without
      settings++;
      EXPECT_NE(told.find("cannot be had: Input/output error"), std::string::npos) << call << told;
      hal.close(&board_);
    } else {
      failures++;
      EXPECT_EQ(status, LAM_HARDWARE) << call;
      EXPECT_STRNE(hal.error, "") << call;
    }
    expect_nothing_held();
  }
  EXPECT_EQ(settings, 4) << "processor, SCHED_FIFO, opening and writing the latency's file";
  EXPECT_GE(failures, 20);
}

TEST_F(Board, EachCallOfABurstFailsOnceAndIsToldInOneLine) {
  int failures = 0;
  for (int call = 0;; call++) {
    start_over();
    ASSERT_EQ(open(), LAM_OK) << hal.error;
    fake_gpio().failing_call = fake_gpio().calls + call;
    const enum lam_status status = exercise();
    if (fake_gpio().calls <= fake_gpio().failing_call) break;
    failures++;
    hal.lights_off(&board_);
    EXPECT_EQ(fake_gpio().levels["BLANK"], 1) << call;
    EXPECT_EQ(fake_gpio().levels["LAMP"], 0) << call;
    EXPECT_TRUE(status == LAM_HARDWARE || hal.error[0] != '\0') << call;
    EXPECT_EQ(std::string(hal.error).find('\n'), std::string::npos) << hal.error;
    hal.close(&board_);
    expect_nothing_held();
  }
  EXPECT_GE(failures, 20);
}

TEST_F(Board, MemoryThatMayNotBeLockedIsARefusalThatSaysWhatToDo) {
  fake_board.may_lock = false;
  EXPECT_EQ(open(), LAM_HARDWARE);
  const std::string error = hal.error;
  EXPECT_NE(error.find("Cannot allocate memory"), std::string::npos) << error;
  EXPECT_NE(error.find("ulimit -l unlimited"), std::string::npos) << error;
  expect_nothing_held();
}

TEST_F(Board, ATemperatureThatIsNoNumberIsAnError) {
  fake_board.temperature = "warm\n";
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(std::string(hal.error).find("/fake/temperature"), std::string::npos) << hal.error;
}

TEST_F(Board, ADisplayOrACameraThatIsNotThereIsNamedAndNothingStaysHeld) {
  struct rig_linux* board = &rig_.board;
  std::strcpy(board->display_device, "/dev/dri/none");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(std::string(hal.error).find("/dev/dri/none"), std::string::npos) << hal.error;
  expect_nothing_held();
  board->display_device[0] = '\0';
  std::strcpy(board->camera_left, "v4l2:/dev/none");
  std::strcpy(board->camera_trigger, "fixed");
  rig_.sensor.format = raw_format_find("GREY");
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_NE(std::string(hal.error).find("/dev/none"), std::string::npos) << hal.error;
  expect_nothing_held();
}

TEST_F(Board, WhatADisplayThatIsGoneSaysIsTheBoardsError) {
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  double at_us = 0;
  board_.has_display = true;
  board_.display.fd = -1;
  EXPECT_EQ(hal.prepare(&board_, &at_us), LAM_HARDWARE);
  EXPECT_NE(std::string(hal.error).find("vblank"), std::string::npos) << hal.error;
  hal.error[0] = '\0';
  EXPECT_EQ(hal.commit_pattern(&board_, {lamella_v1_PatternSpan_Kind_BLACK, 0}, &at_us),
            LAM_HARDWARE);
  EXPECT_STRNE(hal.error, "");
  EXPECT_FALSE(hal.flipped(&board_, &at_us));
  hal.close(&board_);
}

TEST_F(Board, ACameraThatCannotBeArmedIsToldBeforeABurstBegins) {
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  struct linux_camera* camera = &board_.cameras[1];
  *camera = {};
  camera->self = camera;
  camera->arm = [](void* self) {
    std::strcpy(static_cast<linux_camera*>(self)->error, "right camera: it sleeps");
    return LAM_HARDWARE;
  };
  camera->disarm = camera->close = [](void*) {};
  board_.has_camera[1] = true;
  double at_us = 0;
  EXPECT_EQ(hal.prepare(&board_, &at_us), LAM_HARDWARE);
  EXPECT_STREQ(hal.error, "right camera: it sleeps");
  hal.close(&board_);
}

TEST_F(Board, APhotographThatIsNotTakenYetIsRefused) {
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  struct linux_camera* camera = &board_.cameras[0];
  *camera = {};
  camera->read = [](void*, const linux_shot*, hal_photograph*) { return LAM_OK; };
  camera->close = [](void*) {};
  board_.has_camera[0] = true;
  hal_photograph photograph = {};
  double at_us = 0;
  EXPECT_EQ(hal.read_photograph(&board_, 0, 0, &photograph), LAM_HARDWARE);
  EXPECT_STREQ(photograph.error, "a photograph was asked for before it was taken");
  hal.set_line(&board_, HAL_TRIGGER, true, &at_us);
  hal.set_line(&board_, HAL_TRIGGER, false, &at_us);
  EXPECT_EQ(hal.read_photograph(&board_, 0, 0, &photograph), LAM_OK);
  hal.close(&board_);
}

TEST_F(Board, WithoutADisplayAPatternIsRefusedWithTheKeyThatIsMissing) {
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  double at_us = 0;
  EXPECT_EQ(hal.commit_pattern(&board_, {lamella_v1_PatternSpan_Kind_BLACK, 0}, &at_us),
            LAM_HARDWARE);
  EXPECT_NE(std::string(hal.error).find("linux.display_device"), std::string::npos) << hal.error;
  hal.close(&board_);
}

// TRIGGER's line, whichever level triggers the cameras.

TEST_F(Board, ATriggerThatIsActiveLowRestsHighAndIsLowForTheExposure) {
  double at_us = 0;
  rig_.sensor.trigger_active_low = true;
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 1) << "the cameras must not expose from the start";
  ASSERT_EQ(hal.prepare(&board_, &at_us), LAM_OK) << hal.error;
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 1);
  ASSERT_EQ(hal.set_line(&board_, HAL_TRIGGER, true, &at_us), LAM_OK);
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 0);
  ASSERT_EQ(hal.set_line(&board_, HAL_TRIGGER, false, &at_us), LAM_OK);
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 1);
  EXPECT_EQ(board_.shot_count, 1u);
  hal.close(&board_);
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 1) << "as long as the board holds it";
}

TEST_F(Board, ATriggerThatIsActiveHighRestsLow) {
  double at_us = 0;
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 0);
  ASSERT_EQ(hal.set_line(&board_, HAL_TRIGGER, true, &at_us), LAM_OK);
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 1);
  hal.close(&board_);
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 0);
}

TEST_F(Board, LightsOffEndsAnExposureWhicheverLevelItHas) {
  for (const bool low : {false, true}) {
    double at_us = 0;
    start_over();
    rig_.sensor.trigger_active_low = low;
    ASSERT_EQ(open(), LAM_OK) << hal.error;
    hal.set_line(&board_, HAL_TRIGGER, true, &at_us);
    hal.set_line(&board_, HAL_BLANK, false, &at_us);
    hal.lights_off(&board_);
    EXPECT_EQ(fake_gpio().levels["TRIGGER"], low) << low;
    EXPECT_EQ(fake_gpio().levels["BLANK"], 1);
    EXPECT_EQ(board_.shot_count, 0u) << "an exposure that was cut short is no shot";
    hal.close(&board_);
  }
}

TEST_F(Board, ASupervisorPutsAnActiveLowTriggerAtRestToo) {
  double at_us = 0;
  rig_.sensor.trigger_active_low = true;
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  hal.set_line(&board_, HAL_TRIGGER, true, &at_us);
  hal.set_line(&board_, HAL_BLANK, false, &at_us);
  ASSERT_EQ(hal_linux_darken(&board_), LAM_OK);
  EXPECT_EQ(fake_gpio().levels["TRIGGER"], 1);
  EXPECT_EQ(fake_gpio().levels["BLANK"], 1);
  hal.close(&board_);
}

TEST_F(Board, ALoopBackOfAnActiveLowTriggerIsToldAsTheExposureThatItIs) {
  rig_.sensor.trigger_active_low = true;
  ASSERT_EQ(open(), LAM_OK) << hal.error;
  fake_gpio().edges = {{"TRIGGER_IN", false, 7}, {"BLANK_IN", false, 8}};
  struct hal_seen_edge seen;
  ASSERT_TRUE(hal.next_seen(&board_, &seen));
  EXPECT_EQ(seen.line, HAL_TRIGGER);
  EXPECT_TRUE(seen.level) << "the line fell: the cameras are triggered";
  ASSERT_TRUE(hal.next_seen(&board_, &seen));
  EXPECT_EQ(seen.line, HAL_BLANK);
  EXPECT_FALSE(seen.level);
  hal.close(&board_);
}
