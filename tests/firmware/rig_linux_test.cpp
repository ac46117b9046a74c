#include <gtest/gtest.h>

#include "test_rig.h"

namespace {

const char kBoard[] =
    "\nlinux.gpio_chip = /dev/gpiochip0\nlinux.spi_device = /dev/spidev0.0\n"
    "linux.blank_line = GPIO17\nlinux.latch_line = GPIO27\nlinux.trigger_line = GPIO22\n"
    "linux.lamp_line = GPIO23\nlinux.analyser_line = GPIO24\nlinux.cpu = 3\nlinux.priority = "
    "80\nlinux.spin_us = 150\n";

enum lam_status parse(const std::string& text, struct rig* rig, std::string* says) {
  struct rig_errors errors;
  const enum lam_status status = rig_parse(text.data(), text.size(), rig, &errors);
  *says = errors.list[0].text;
  return status;
}

void expect_refusal(const std::string& from, const std::string& to, const std::string& why) {
  std::string board = kBoard, says;
  board.replace(board.find(from), from.size(), to);
  struct rig rig;
  EXPECT_EQ(parse(rig_file_text() + board, &rig, &says), LAM_BAD_INPUT);
  EXPECT_NE(says.find(why), std::string::npos) << says;
}

}  // namespace

TEST(RigLinux, KeysSayWhereTheBoardIsWired) {
  struct rig rig;
  std::string says;
  ASSERT_EQ(parse(rig_file_text() + kBoard, &rig, &says), LAM_OK) << says;
  EXPECT_TRUE(rig.board.given);
  EXPECT_STREQ(rig.board.gpio_chip, "/dev/gpiochip0");
  EXPECT_STREQ(rig.board.blank_line, "GPIO17");
  EXPECT_STREQ(rig.board.lamp_line, "GPIO23");
  EXPECT_STREQ(rig.board.buzzer_line, "") << "optional, and left out";
  EXPECT_EQ(rig.board.spin_us, 150);
}

TEST(RigLinux, AFileWithoutTheKeysIsOfASimulatedRig) {
  struct rig rig;
  std::string says;
  ASSERT_EQ(parse(rig_file_text(), &rig, &says), LAM_OK);
  EXPECT_FALSE(rig.board.given);
}

TEST(RigLinux, HalfASectionIsRefused) {
  expect_refusal("linux.cpu = 3\n", "", "missing key 'linux.cpu'");
}

TEST(RigLinux, TwoKeysWithOneLineAreRefused) {
  expect_refusal("linux.latch_line = GPIO27", "linux.latch_line = GPIO17",
                 "is the line that 'linux.blank_line' has");
}

TEST(RigLinux, WrongValuesAreRefusedWithTheReason) {
  expect_refusal("linux.cpu = 3", "linux.cpu = 2.5", "whole number");
  expect_refusal("linux.priority = 80", "linux.priority = 100", "between 1 and 99");
  expect_refusal("linux.spin_us = 150", "linux.spin_us = soon", "needs one decimal number");
  expect_refusal("linux.gpio_chip = /dev/gpiochip0", "linux.gpio_chip =", "is empty");
  expect_refusal("linux.lamp_line", "linux.lamp", "unknown key");
  expect_refusal("linux.cpu = 3", "linux.spin_us = 3", "twice");
}
