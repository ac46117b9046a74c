// A kernel with one V4L2 camera, played behind open(), ioctl(), poll() and mmap(), which the linker
// sends here (--wrap). Any of its calls can be made to fail.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "hal_linux_frames.h"

struct FakeFrame {
  uint32_t sequence;
  double stamp_us;
  std::vector<uint8_t> bytes;
  uint32_t flags = 0;  // beside V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC
};

struct FakeControl {
  uint32_t id;
  int32_t value;
  bool stuck = false;
};

struct FakeV4l2 {
  uint32_t capabilities = 0;                               // 0: capture and streaming
  uint32_t fourcc = 0, width = 0, height = 0, stride = 0;  // forced where not 0
  uint32_t most_buffers = 32;
  std::map<std::string, FakeControl> controls;  // by name
  std::map<std::string, std::string> files;     // under /sys
  std::deque<FakeFrame> frames;                 // yet to come
  short poll_events = 0;                        // forced where not 0
  bool no_memory = false;                       // calloc() gives none
  linux_frames_plugin plugin = {0, nullptr};    // what dlopen() finds, where it opens something

  bool streams = false;
  size_t buffer_bytes = 0;
  std::vector<std::vector<uint8_t>> buffers;
  std::deque<uint32_t> queued;
  int open_files = 0, mappings = 0;

  int calls = 0, failing_call = -1, failing_errno = 5;
  std::vector<std::string> called;  // what each call was
};

extern FakeV4l2 fake_v4l2;
