// hal_linux_gpio on a libgpiod 1.6 that is played here and remembers what it was told.
#include <gtest/gtest.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

extern "C" {
#include "hal_linux_gpio.h"
}

namespace {

using Levels = std::array<int, LINUX_GPIO_LINES>;

struct Kernel {
  std::vector<std::string> found;
  std::vector<Levels> driven;  // the first is what the lines were requested with
  int released = 0, closed = 0;
  std::string unknown_line;
  bool busy = false, broken = false;
};
Kernel kernel;

Levels levels_of(const int* values) {
  Levels levels;
  std::copy(values, values + levels.size(), levels.begin());
  return levels;
}

struct rig_linux board_of(const char* chip) {
  struct rig_linux board = {};
  std::strcpy(board.gpio_chip, chip);
  std::strcpy(board.blank_line, "GPIO17");
  std::strcpy(board.latch_line, "GPIO27");
  std::strcpy(board.trigger_line, "GPIO22");
  std::strcpy(board.lamp_line, "GPIO23");
  return board;
}

class LinuxGpio : public testing::Test {
 protected:
  void SetUp() override { kernel = Kernel(); }
  enum lam_status open(const char* chip = "/dev/gpiochip0") {
    const struct rig_linux board = board_of(chip);
    return linux_gpio_open(&gpio_, &board);
  }
  struct linux_gpio gpio_;
  double at_us_ = 0;
};

}  // namespace

extern "C" {
struct gpiod_chip* gpiod_chip_open(const char* path) {
  errno = ENOENT;
  return std::strcmp(path, "/dev/gpiochip0") == 0 ? reinterpret_cast<gpiod_chip*>(&kernel)
                                                  : nullptr;
}
void gpiod_chip_close(struct gpiod_chip*) { kernel.closed++; }
struct gpiod_line* gpiod_chip_find_line(struct gpiod_chip*, const char* name) {
  if (name == kernel.unknown_line) return nullptr;
  kernel.found.emplace_back(name);
  return reinterpret_cast<gpiod_line*>(&kernel);
}
int gpiod_line_request_bulk_output(struct gpiod_line_bulk* bulk, const char*, const int* values) {
  EXPECT_EQ(gpiod_line_bulk_num_lines(bulk), LINUX_GPIO_LINES);
  errno = EBUSY;
  if (kernel.busy) return -1;
  kernel.driven.push_back(levels_of(values));
  return 0;
}
int gpiod_line_set_value_bulk(struct gpiod_line_bulk* bulk, const int* values) {
  EXPECT_EQ(gpiod_line_bulk_num_lines(bulk), LINUX_GPIO_LINES);
  errno = EIO;
  if (kernel.broken) return -1;
  kernel.driven.push_back(levels_of(values));
  return 0;
}
void gpiod_line_release_bulk(struct gpiod_line_bulk*) { kernel.released++; }
}

TEST_F(LinuxGpio, BlankIsRequestedHighSoThatNoLightFlashes) {
  ASSERT_EQ(open(), LAM_OK);
  EXPECT_EQ(kernel.driven, std::vector<Levels>({{1, 0, 0, 0}}));
  EXPECT_EQ(kernel.found, std::vector<std::string>({"GPIO17", "GPIO27", "GPIO22", "GPIO23"}));
}

TEST_F(LinuxGpio, SettingOneLineLeavesTheOthersAsTheyWere) {
  ASSERT_EQ(open(), LAM_OK);
  ASSERT_EQ(linux_gpio_set(&gpio_, HAL_TRIGGER, true, &at_us_), LAM_OK);
  ASSERT_EQ(linux_gpio_set(&gpio_, HAL_BLANK, false, &at_us_), LAM_OK);
  ASSERT_EQ(linux_gpio_set(&gpio_, HAL_BLANK, true, &at_us_), LAM_OK);
  EXPECT_EQ(kernel.driven,
            std::vector<Levels>({{1, 0, 0, 0}, {1, 0, 1, 0}, {0, 0, 1, 0}, {1, 0, 1, 0}}));
  EXPECT_GT(at_us_, 0);
}

TEST_F(LinuxGpio, ClosingPutsTheLightOutBeforeItLetsTheLinesGo) {
  ASSERT_EQ(open(), LAM_OK);
  ASSERT_EQ(linux_gpio_set(&gpio_, HAL_BLANK, false, &at_us_), LAM_OK);
  linux_gpio_close(&gpio_);
  EXPECT_EQ(kernel.driven.back()[HAL_BLANK], 1);
  EXPECT_EQ(kernel.released, 1);
  EXPECT_EQ(kernel.closed, 1);
}

TEST_F(LinuxGpio, AMissingChipIsNamed) {
  EXPECT_EQ(open("/dev/gpiochip9"), LAM_HARDWARE);
  EXPECT_STREQ(gpio_.error, "cannot open /dev/gpiochip9: No such file or directory");
}

TEST_F(LinuxGpio, AMissingLineIsNamedAndNothingIsHeld) {
  kernel.unknown_line = "GPIO22";
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_STREQ(gpio_.error, "no GPIO line GPIO22: No such file or directory");
  EXPECT_TRUE(kernel.driven.empty());
  EXPECT_EQ(kernel.closed, 1);
}

TEST_F(LinuxGpio, LinesThatAnotherProgramHasAreAnError) {
  kernel.busy = true;
  EXPECT_EQ(open(), LAM_HARDWARE);
  EXPECT_EQ(kernel.closed, 1);
  EXPECT_NE(std::string(gpio_.error).find("busy"), std::string::npos) << gpio_.error;
}

TEST_F(LinuxGpio, ALineThatDoesNotMoveIsAnError) {
  ASSERT_EQ(open(), LAM_OK);
  kernel.broken = true;
  EXPECT_EQ(linux_gpio_set(&gpio_, HAL_LATCH, true, &at_us_), LAM_HARDWARE);
}
