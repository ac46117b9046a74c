#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <string>

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

namespace {

// What the kernel keeps to, whoever asked for it.
bool is_deep_sleep_forbidden() {
  const int fd = open("/dev/cpu_dma_latency", O_RDONLY | O_CLOEXEC);
  int32_t latency_us = -1;
  const bool known = fd >= 0 && read(fd, &latency_us, sizeof latency_us) == sizeof latency_us;
  if (fd >= 0) close(fd);
  return known && latency_us == 0;
}

// How many settings the kernel does not say that this thread has.
int settings_not_had(const struct rig_linux& board) {
  cpu_set_t cpus;
  sched_getaffinity(0, sizeof cpus, &cpus);
  struct sched_param param = {};
  sched_getparam(0, &param);
  const bool pinned = CPU_COUNT(&cpus) == 1 && CPU_ISSET(int(board.cpu), &cpus);
  const bool fifo = (sched_getscheduler(0) & ~SCHED_RESET_ON_FORK) == SCHED_FIFO &&
                    param.sched_priority == int(board.priority);
  return !pinned + !fifo + !is_deep_sleep_forbidden();
}

}  // namespace

// What could not be had, on a machine that does not allow it, is a line on stderr with the reason.
TEST(LinuxTimeDeathTest, EverySettingIsHadAsTheKernelSaysOrReported) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  struct rig_linux board = {};
  board.cpu = sched_getcpu();
  board.priority = 7;
  EXPECT_EXIT(
      {
        int fd = -1;
        const int missing = linux_time_settle(&board, &fd);
        const int not_had = settings_not_had(board);
        fprintf(stderr, "%d missing, %d not had\n", missing, not_had);
        _exit(missing == not_had ? 0 : 1);
      },
      testing::ExitedWithCode(0), "missing");
}

// A sanitizer's mlockall() locks nothing and says that it did.
#ifndef LAMELLA_SANITIZED
namespace {

long locked_kilobytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    long kilobytes = 0;
    if (word == "VmLck:" && status >> kilobytes) return kilobytes;
  }
  return 0;
}

// As a user who is not root and may lock so much.
enum lam_status lock_memory(rlim_t most_bytes, char error[160]) {
  const rlimit limit = {most_bytes, most_bytes};
  if (setrlimit(RLIMIT_MEMLOCK, &limit) != 0) return LAM_WRONG_STATE;
  if (getuid() == 0 && setuid(65534) != 0) return LAM_WRONG_STATE;
  return linux_memory_lock(error);
}

}  // namespace

TEST(LinuxTimeDeathTest, MemoryIsLockedOrRefusedWithTheLimitAndWhatToDo) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  char error[160] = "";
  EXPECT_EXIT(
      {
        const enum lam_status status = lock_memory(64 << 10, error);
        fputs(error, stderr);
        _exit(status == LAM_HARDWARE ? 7 : 0);
      },
      testing::ExitedWithCode(7),
      "limit is 64 KiB: set LimitMEMLOCK=infinity in the unit, or ulimit");
  EXPECT_EXIT(_exit((linux_memory_lock(error) == LAM_OK) == (locked_kilobytes() > 0) ? 7 : 0),
              testing::ExitedWithCode(7), "");
}
#endif
