// hal_linux_gpio and what hal_linux makes of lines, on a chip that is played here.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "fake_gpio.h"
#include "test_rig.h"

extern "C" {
#include "hal_linux.h"
#include "hal_linux_time.h"
}

namespace {

using Driven = std::vector<std::pair<std::string, int>>;

class LinuxLines : public testing::Test {
 protected:
  void SetUp() override { fake_gpio() = FakeGpio(); }
  enum lam_status open(const char* chip = "/dev/gpiochip0") {
    static const char* const kNames[] = {"BLANK", "LATCH", ""};
    static const int kLevels[] = {1, 0, 0};
    return linux_outputs_open(&lines_, chip, kNames, kLevels, 3);
  }
  struct linux_lines lines_;
  double at_us_ = 0;
};

class LinuxBoard : public testing::Test {
 protected:
  LinuxBoard() : rig_(test_rig()) {
    struct rig_linux* b = &rig_.board;
    b->given = true;
    std::strcpy(b->gpio_chip, "/dev/gpiochip0");
    std::strcpy(b->blank_line, "BLANK");
    std::strcpy(b->latch_line, "LATCH");
    std::strcpy(b->trigger_line, "TRIGGER");
    std::strcpy(b->lamp_line, "LAMP");
    std::strcpy(b->analyser_line, "ANALYSER");
    std::strcpy(b->at_parallel_line, "AT_PARALLEL");
    std::strcpy(b->at_crossed_line, "AT_CROSSED");
    std::strcpy(b->estop_line, "ESTOP");
    std::strcpy(b->start_line, "START");
    fake_gpio() = FakeGpio();
    fake_gpio().levels = {{"ESTOP", 1}, {"AT_PARALLEL", 1}};
  }
  void claim() {
    ASSERT_EQ(hal_linux_claim(&board_, &rig_), LAM_OK) << board_.hal.error;
    ASSERT_EQ(linux_inputs_open(&board_.inputs, "/dev/gpiochip0", board_.input_names, LINUX_INPUTS),
              LAM_OK);
  }
  void set(enum hal_line line, bool level) {
    double at_us = 0;
    ASSERT_EQ(board_.hal.set_line(&board_, line, level, &at_us), LAM_OK);
  }
  enum lam_status sense() { return board_.hal.sense(&board_, &senses_); }

  struct rig rig_;
  struct hal_linux board_;
  struct hal_senses senses_;
};

}  // namespace

TEST_F(LinuxLines, AreRequestedWithTheirLevelsSoThatNoLightFlashes) {
  ASSERT_EQ(open(), LAM_OK);
  EXPECT_EQ(fake_gpio().driven, Driven({{"BLANK", 1}, {"LATCH", 0}}));
  EXPECT_EQ(fake_gpio().asked, std::vector<std::string>({"BLANK", "LATCH"}));
}

TEST_F(LinuxLines, SettingOneMovesNoOther) {
  ASSERT_EQ(open(), LAM_OK);
  ASSERT_EQ(linux_outputs_set(&lines_, 1, true, &at_us_), LAM_OK);
  ASSERT_EQ(linux_outputs_set(&lines_, 0, false, &at_us_), LAM_OK);
  EXPECT_EQ(fake_gpio().driven, Driven({{"BLANK", 1}, {"LATCH", 0}, {"LATCH", 1}, {"BLANK", 0}}));
  EXPECT_GT(at_us_, 0);
}

TEST_F(LinuxLines, ALineThatTheRigHasNotIsSetWithoutAnEffect) {
  ASSERT_EQ(open(), LAM_OK);
  ASSERT_EQ(linux_outputs_set(&lines_, 2, true, &at_us_), LAM_OK);
  EXPECT_EQ(fake_gpio().driven.size(), 2u);
}

TEST_F(LinuxLines, AMissingChipIsNamed) {
  EXPECT_EQ(open("/dev/gpiochip9"), LAM_HARDWARE);
  EXPECT_STREQ(lines_.error, "cannot open /dev/gpiochip9: No such file or directory");
}

TEST_F(LinuxLines, AMissingLineIsNamedAndNothingIsHeld) {
  fake_gpio().unknown_line = "LATCH";
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_STREQ(lines_.error, "no GPIO line LATCH: No such file or directory");
  EXPECT_TRUE(fake_gpio().driven.empty());
  EXPECT_EQ(fake_gpio().closed, 1);
}

TEST_F(LinuxLines, ThoseThatAnotherProgramHasAreAnError) {
  fake_gpio().busy = true;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_EQ(fake_gpio().closed, 1);
  EXPECT_NE(std::string(lines_.error).find("busy"), std::string::npos) << lines_.error;
}

TEST_F(LinuxLines, OneThatDoesNotMoveIsAnError) {
  ASSERT_EQ(open(), LAM_OK);
  fake_gpio().broken = true;
  EXPECT_EQ(linux_outputs_set(&lines_, 1, true, &at_us_), LAM_HARDWARE);
}

TEST_F(LinuxBoard, ClaimsTheLightsDark) {
  claim();
  EXPECT_EQ(fake_gpio().driven,
            Driven({{"BLANK", 1}, {"LATCH", 0}, {"TRIGGER", 0}, {"LAMP", 0}, {"ANALYSER", 0}}));
}

TEST_F(LinuxBoard, ARigFileOfASimulatedRigIsRefused) {
  rig_.board.given = false;
  EXPECT_EQ(hal_linux_claim(&board_, &rig_), LAM_BAD_INPUT);
  EXPECT_TRUE(fake_gpio().driven.empty());
}

TEST_F(LinuxBoard, ASupervisorDarkensTheLightsShutsTheCamerasAndMovesNothingElse) {
  claim();
  fake_gpio().driven.clear();
  ASSERT_EQ(hal_linux_darken(&board_), LAM_OK);
  EXPECT_EQ(fake_gpio().driven, Driven({{"BLANK", 1}, {"LAMP", 0}, {"TRIGGER", 0}}));
}

TEST_F(LinuxBoard, ALampIsDarkenedWhereBlankCannotBeSet) {
  claim();
  set(HAL_LAMP, true);
  fake_gpio().failing_call = fake_gpio().calls;
  EXPECT_EQ(hal_linux_darken(&board_), LAM_HARDWARE);
  EXPECT_EQ(fake_gpio().levels["LAMP"], 0);
}

TEST_F(LinuxBoard, ALightIsOnAsTheLinesSayOrWhereTheyCannotBeRead) {
  claim();
  EXPECT_FALSE(hal_linux_is_lit(&board_));
  set(HAL_BLANK, false);
  EXPECT_TRUE(hal_linux_is_lit(&board_));
  set(HAL_BLANK, true);
  set(HAL_LAMP, true);
  EXPECT_TRUE(hal_linux_is_lit(&board_));
  set(HAL_LAMP, false);
  EXPECT_FALSE(hal_linux_is_lit(&board_));
  fake_gpio().deaf = true;
  EXPECT_TRUE(hal_linux_is_lit(&board_));
}

TEST_F(LinuxBoard, ABrokenWireToTheEmergencyStopStops) {
  claim();
  ASSERT_EQ(sense(), LAM_OK);
  EXPECT_FALSE(senses_.estopped);
  fake_gpio().levels["ESTOP"] = 0;
  ASSERT_EQ(sense(), LAM_OK);
  EXPECT_TRUE(senses_.estopped);
}

TEST_F(LinuxBoard, ARigWithoutAnEmergencyStopInputIsNotStopped) {
  rig_.board.estop_line[0] = '\0';
  claim();
  ASSERT_EQ(sense(), LAM_OK);
  EXPECT_FALSE(senses_.estopped);
}

TEST_F(LinuxBoard, TheAnalyserArrivesWhenItsEndStopSays) {
  claim();
  double at_us = 0;
  ASSERT_EQ(board_.hal.move_analyser(&board_, true, &at_us), LAM_OK);
  EXPECT_FALSE(board_.hal.arrived(&board_, &at_us));
  const double stop_us = std::ceil(at_us) + 10;  // whole: the kernel cuts off parts of nanoseconds
  fake_gpio().edges.push_back({"AT_CROSSED", true, stop_us});
  ASSERT_TRUE(board_.hal.arrived(&board_, &at_us));
  EXPECT_DOUBLE_EQ(at_us, stop_us);
  EXPECT_FALSE(board_.hal.arrived(&board_, &at_us)) << "it is told once";
}

TEST_F(LinuxBoard, AnAnalyserThatDoesNotArriveIsStuck) {
  rig_.analyser_move_us = 1000;
  claim();
  double at_us = 0;
  ASSERT_EQ(board_.hal.move_analyser(&board_, true, &at_us), LAM_OK);
  EXPECT_EQ(sense(), LAM_OK);
  EXPECT_FALSE(senses_.stuck);
  linux_wait_until_us(linux_now_us() + 2000, 0);
  EXPECT_EQ(sense(), LAM_OK) << "the other inputs are read all the same";
  EXPECT_TRUE(senses_.stuck);
  EXPECT_EQ(board_.hal.prepare(&board_, &at_us), LAM_HARDWARE);
  EXPECT_STREQ(board_.hal.error, HAL_STUCK);
  EXPECT_EQ(board_.hal.arm(&board_), LAM_OK) << "what needs no analyser can be tested";
}

// A broken wire to a line that is pulled up.
TEST_F(LinuxBoard, AnEndStopThatSaysSoAllTheTimeIsNoArrival) {
  rig_.analyser_move_us = 1000;
  claim();
  fake_gpio().levels["AT_CROSSED"] = 1;
  double at_us = 0;
  ASSERT_EQ(board_.hal.move_analyser(&board_, true, &at_us), LAM_OK);
  linux_wait_until_us(linux_now_us() + 2000, 0);
  EXPECT_FALSE(board_.hal.arrived(&board_, &at_us));
  EXPECT_EQ(sense(), LAM_OK);
  EXPECT_TRUE(senses_.stuck);
}

TEST_F(LinuxBoard, WithoutEndStopsTheAnalyserArrivesWhenTheRigFileSays) {
  rig_.board.at_crossed_line[0] = rig_.board.at_parallel_line[0] = '\0';
  rig_.analyser_move_us = 1000;
  claim();
  const double before_us = linux_now_us();
  double set_us = 0, at_us = 0;
  ASSERT_EQ(board_.hal.move_analyser(&board_, true, &set_us), LAM_OK);
  linux_wait_until_us(linux_now_us() + 1500, 0);
  ASSERT_TRUE(board_.hal.arrived(&board_, &at_us));
  EXPECT_GE(at_us, before_us + 1000);
  EXPECT_LE(at_us, set_us + 1000);
}

TEST_F(LinuxBoard, ABurstDoesNotBeginWithTheAnalyserBetweenItsStops) {
  claim();
  fake_gpio().levels["AT_PARALLEL"] = 0;
  double zero_us = 0;
  EXPECT_EQ(board_.hal.prepare(&board_, &zero_us), LAM_HARDWARE);
  EXPECT_STREQ(board_.hal.error, "the analyser is not at its parallel end stop");
}

TEST_F(LinuxBoard, BothEndStopsAtOnceAreABrokenWireAndNoBurst) {
  claim();
  fake_gpio().levels["AT_PARALLEL"] = fake_gpio().levels["AT_CROSSED"] = 1;
  double zero_us = 0;
  EXPECT_EQ(board_.hal.prepare(&board_, &zero_us), LAM_HARDWARE);
  EXPECT_STREQ(board_.hal.error,
               "both end stops say that the analyser is there: is a wire of theirs broken?");
}

TEST_F(LinuxBoard, InputsThatCannotBeHeardAreAnError) {
  claim();
  fake_gpio().deaf = true;
  EXPECT_EQ(sense(), LAM_HARDWARE);
}

TEST_F(LinuxBoard, APhotographThatNobodyTookIsRefusedWithTheReason) {
  claim();
  struct hal_photograph photograph = {};
  EXPECT_EQ(board_.hal.read_photograph(&board_, 0, 1, &photograph), LAM_HARDWARE);
  EXPECT_STREQ(photograph.error, "the rig file names no linux.camera_right");
}

TEST_F(LinuxBoard, AShotIsTheTimeBetweenTwoEdgesOfTheTrigger) {
  claim();
  set(HAL_TRIGGER, true);
  EXPECT_EQ(board_.shot_count, 0u) << "it is not over";
  set(HAL_TRIGGER, false);
  ASSERT_EQ(board_.shot_count, 1u);
  EXPECT_GE(board_.shots[0].untrigger_us, board_.shots[0].trigger_us);
}
