#include <gtest/gtest.h>
#include <unistd.h>

extern "C" {
#include "hal_linux_spi.h"
#include "hal_linux_time.h"
}

TEST(LinuxSpi, AMissingDeviceIsNamed) {
  struct linux_spi spi;
  EXPECT_EQ(linux_spi_open(&spi, "/dev/spidev77.0", 10e6), LAM_HARDWARE);
  EXPECT_STREQ(spi.error, "/dev/spidev77.0: No such file or directory");
}

TEST(LinuxSpi, ADeviceThatIsNoSpiBusIsRefusedAndNotKeptOpen) {
  struct linux_spi spi;
  EXPECT_EQ(linux_spi_open(&spi, "/dev/null", 10e6), LAM_HARDWARE);
  EXPECT_STREQ(spi.error, "/dev/null: Inappropriate ioctl for device");
  EXPECT_EQ(spi.fd, -1);
}

TEST(LinuxSpi, AFailedShiftSaysWhy) {
  struct linux_spi spi = {};
  spi.fd = -1;
  const uint8_t stream[CHAIN_BYTES] = {};
  EXPECT_EQ(linux_spi_shift(&spi, stream, nullptr), LAM_HARDWARE);
  EXPECT_STREQ(spi.error, "shifting the LED chain: Bad file descriptor");
}

TEST(LinuxTime, WaitingNeverEndsEarly) {
  for (const double spin_us : {0.0, 150.0, 10000.0}) {
    const double due_us = linux_now_us() + 3000.25;
    linux_wait_until_us(due_us, spin_us);
    EXPECT_GE(linux_now_us(), due_us);
  }
}

// In a process of its own: the settings would stay with the tests that follow.
TEST(LinuxTimeDeathTest, AProcessorThatIsNotThereIsReportedByItsKey) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  struct rig_linux board = {};
  board.cpu = 1023;
  board.priority = 1;
  EXPECT_EXIT(
      {
        int fd = -1;
        _exit(linux_time_settle(&board, &fd) > 0 ? 7 : 0);
      },
      testing::ExitedWithCode(7), "processor 1023 \\(linux.cpu\\) cannot be had");
}
