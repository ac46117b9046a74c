// A board's kernel beside its GPIO chip (fake_gpio.h), played behind open(), ioctl() and their
// like, which the linker sends here (--wrap). Its calls are counted with the chip's, and can fail
// like them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

struct FakeBoard {
  int open_files = 0;
  std::vector<uint8_t> shifted;  // the last frame that the LED chain got
  std::string temperature = "45000\n";
  bool may_lock = true;  // memory
  // Settings for the sequencer's time, as asked for.
  int cpu = -1, policy = -1, priority = -1, locked = -1, latency_us = -1;
};

extern FakeBoard fake_board;
