// The kernel's mode setting, played here: one connector, one CRTC, two planes, buffers in a file,
// vblanks that come when a test says so. It begins with a text console on the display.
#pragma once

#include <drm_fourcc.h>

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

enum : uint32_t {
  kFakeConsoleMode = 7,  // the blob of the console's mode
  kFakeConsole = 9,      // and its framebuffer
  kFakeCrtc = 40,
  kFakeConnector = 50,
  kFakeEncoder = 51,
  kFakeCursor = 60,
  kFakePlane = 61,
};
constexpr uint64_t kFakeBufferBytes = 1280 * 800 * 4;
constexpr double kFakeRefreshUs = 1680 * 831 * 1e3 / 83500;

struct FakeDrm {
  struct Property {
    uint32_t id, flags;
    std::string name;
    uint64_t value;
    std::vector<std::string> words;
  };
  struct Event {
    bool ready = false;
    unsigned sequence = 0;
    uint64_t at_us = 0;
  };

  int calls = 0, failing_call = -1;  // the call with this number fails, whatever it is
  std::set<std::string> failing;     // calls of these names fail
  bool master = true, connected = true, preferred = true, interlaced = false;
  uint16_t native_width = 1280;
  uint32_t plane_format = DRM_FORMAT_XRGB8888;
  uint64_t monotonic = 1;

  int objects = 0;  // given out and not freed
  std::set<uint32_t> buffers, framebuffers{kFakeConsole}, blobs{kFakeConsoleMode};
  std::map<uint32_t, std::vector<Property>> properties;
  uint32_t next_id = 100, shown = 0, asked = 0;
  uint64_t sequence = 1000, now_us = 5000000;
  void* waiting = nullptr;  // for its flip
  Event event;

  bool fails(const char* name);
  Property& property(uint32_t object, const std::string& name);
  // Lets so many refreshes pass and counts so many: a flip that was asked for happens.
  void vblank(unsigned passed = 1, unsigned counted = 1);
};

// The display of the test that runs.
FakeDrm& fake_drm();
void reset_fake_drm();
