#include "fake_board.h"

#include <linux/spi/spidev.h>
#include <sched.h>

#include <cerrno>
#include <cstdarg>
#include <cstring>

#include "../fake_gpio.h"

extern "C" {
#include "led_chain.h"
}

FakeBoard fake_board;

namespace {

enum { kSpi = 9000, kTemperature, kLatency, kEnd };
const char* const kPaths[] = {"/dev/spidev0.0", "/fake/temperature", "/dev/cpu_dma_latency"};

bool is_ours(int fd) { return fd >= kSpi && fd < kEnd; }

}  // namespace

extern "C" {
int __real_open(const char* path, int flags, ...);
int __real_close(int fd);
int __real_ioctl(int fd, unsigned long request, ...);
ssize_t __real_pread(int fd, void* to, size_t size, off_t offset);
ssize_t __real_write(int fd, const void* from, size_t size);

int __wrap_open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const int mode = va_arg(arguments, int);
  va_end(arguments);
  for (int fd = kSpi; fd < kEnd; fd++) {
    if (std::strcmp(path, kPaths[fd - kSpi]) != 0) continue;
    if (fake_gpio_fails()) return -1;
    fake_board.open_files++;
    return fd;
  }
  return __real_open(path, flags, mode);
}

int __wrap_close(int fd) {
  if (!is_ours(fd)) return __real_close(fd);
  fake_board.open_files--;
  return 0;
}

int __wrap_ioctl(int fd, unsigned long request, ...) {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (fd != kSpi) return __real_ioctl(fd, request, argument);
  if (fake_gpio_fails()) return -1;
  if (request != SPI_IOC_MESSAGE(1)) return 0;
  const auto* transfer = static_cast<const spi_ioc_transfer*>(argument);
  const auto* bytes = reinterpret_cast<const uint8_t*>(transfer->tx_buf);
  fake_board.shifted.assign(bytes, bytes + transfer->len);
  return int(transfer->len);
}

ssize_t __wrap_pread(int fd, void* to, size_t size, off_t offset) {
  if (fd != kTemperature) return __real_pread(fd, to, size, offset);
  if (fake_gpio_fails()) return -1;
  return ssize_t(fake_board.temperature.copy(static_cast<char*>(to), size));
}

ssize_t __wrap_write(int fd, const void* from, size_t size) {
  if (fd != kLatency) return __real_write(fd, from, size);
  if (fake_gpio_fails()) return -1;
  std::memcpy(&fake_board.latency_us, from, sizeof fake_board.latency_us);
  return ssize_t(size);
}

int __wrap_sched_setaffinity(pid_t, size_t size, const cpu_set_t* cpus) {
  if (fake_gpio_fails()) return -1;
  for (int cpu = 0; cpu < int(8 * size); cpu++) {
    if (CPU_ISSET(cpu, cpus)) fake_board.cpu = CPU_COUNT(cpus) == 1 ? cpu : -2;
  }
  return 0;
}

int __wrap_sched_setscheduler(pid_t, int policy, const sched_param* param) {
  if (fake_gpio_fails()) return -1;
  fake_board.policy = policy;
  fake_board.priority = param->sched_priority;
  return 0;
}

int __wrap_mlockall(int flags) {
  if (fake_gpio_fails()) return -1;
  errno = ENOMEM;
  if (!fake_board.may_lock) return -1;
  fake_board.locked = flags;
  return 0;
}
}
