// hal_linux_display on a kernel's mode setting that is played here: one connector, one CRTC, two
// planes, buffers in a file, vblanks that come when a test says so.
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "test_rig.h"

extern "C" {
#include <drm_fourcc.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#include <xf86drm.h>

#include "hal_linux_display.h"
}

namespace {

enum : uint32_t { kCrtc = 40, kConnector = 50, kEncoder = 51, kCursor = 60, kPlane = 61 };
constexpr uint64_t kBufferBytes = 1280 * 800 * 4;
constexpr double kRefreshUs = 1680 * 831 * 1e3 / 83500;

struct Property {
  uint32_t id, flags;
  std::string name;
  uint64_t value;
  std::vector<std::string> words;
};

struct Kernel {
  int calls = 0, failing_call = -1;  // the call with this number fails, whatever it is
  std::set<std::string> failing;     // calls of these names fail
  std::set<uint32_t> buffers, framebuffers, blobs;
  int objects = 0;  // given out and not freed
  std::map<uint32_t, std::vector<Property>> properties;
  std::map<uint32_t, uint64_t> committed;  // property id to value
  std::vector<uint64_t> modesets;          // ACTIVE of each
  uint32_t next_id = 100, shown = 0, asked = 0;
  uint64_t sequence = 1000, now_us = 5000000;
  void* waiting = nullptr;  // for its flip
  struct {
    bool ready;
    unsigned sequence;
    uint64_t at_us;
  } event = {};
  bool master = true, connected = true, preferred = true, interlaced = false;
  uint16_t native_width = 1280;
  uint32_t plane_format = DRM_FORMAT_XRGB8888;
  uint64_t monotonic = 1;

  uint32_t refresh_clock = 83500;
  bool fails(const char* name) {
    errno = EINVAL;
    return calls++ == failing_call || failing.count(name) > 0;
  }
  Property& property(uint32_t object, const std::string& name) {
    for (Property& one : properties[object]) {
      if (one.name == name) return one;
    }
    ADD_FAILURE() << "no property " << name;
    return properties[object].front();
  }
  // The next vblank, `late` refreshes after the one that is due, counted as `counted` ones.
  void vblank(unsigned passed = 1, unsigned counted = 1) {
    now_us += static_cast<uint64_t>(passed * kRefreshUs + 0.5);
    sequence += counted;
    if (waiting == nullptr) return;
    shown = asked;
    event = {true, static_cast<unsigned>(sequence), now_us};
  }
};
Kernel kernel;

// What the kernel's mode setting looks like while a text console has the display.
void reset_kernel() {
  kernel = Kernel();
  uint32_t id = 200;
  const auto add = [&](uint32_t object, const char* name, uint64_t value, uint32_t flags = 0,
                       std::vector<std::string> words = {}) {
    kernel.properties[object].push_back({id++, flags, name, value, std::move(words)});
  };
  kernel.blobs = {7};
  kernel.framebuffers = {9};
  add(kConnector, "CRTC_ID", kCrtc);
  add(kConnector, "max bpc", 12);
  add(kConnector, "Broadcast RGB", 0, DRM_MODE_PROP_ENUM, {"Automatic", "Full", "Limited 16:235"});
  add(kCrtc, "MODE_ID", 7, DRM_MODE_PROP_BLOB);
  add(kCrtc, "ACTIVE", 1);
  add(kCrtc, "GAMMA_LUT", 0, DRM_MODE_PROP_BLOB);
  for (uint32_t plane : {kPlane, kCursor}) {
    add(plane, "type", plane == kPlane ? DRM_PLANE_TYPE_PRIMARY : DRM_PLANE_TYPE_CURSOR);
    add(plane, "FB_ID", 9);
    add(plane, "CRTC_ID", kCrtc);
    for (const char* name :
         {"SRC_X", "SRC_Y", "SRC_W", "SRC_H", "CRTC_X", "CRTC_Y", "CRTC_W", "CRTC_H"}) {
      add(plane, name, 77);
    }
  }
}

template <class T>
T* given() {
  kernel.objects++;
  return static_cast<T*>(calloc(1, sizeof(T)));
}

template <class T>
T* array(size_t count) {
  return static_cast<T*>(calloc(count, sizeof(T)));
}

void take_back(void* object, std::initializer_list<void*> parts) {
  if (object == nullptr) return;
  kernel.objects--;
  for (void* part : parts) free(part);
  free(object);
}

drmModeModeInfo mode_of(uint16_t width, uint32_t clock, uint32_t type) {
  drmModeModeInfo mode = {};
  mode.clock = clock;
  mode.hdisplay = width;
  mode.vdisplay = 800;
  mode.htotal = 1680;
  mode.vtotal = 831;
  mode.type = type;
  mode.flags = kernel.interlaced ? DRM_MODE_FLAG_INTERLACE : 0;
  return mode;
}

class LinuxDisplay : public testing::Test {
 protected:
  void SetUp() override {
    reset_kernel();
    rig_ = test_rig();
    rig_.projector_refresh_hz = 1e6 / kRefreshUs;
    std::snprintf(path_, sizeof path_, "%s", "/tmp/lamella_display_XXXXXX");
    const int fd = mkstemp(path_);
    ASSERT_GE(fd, 0);
    ASSERT_EQ(ftruncate(fd, kBufferBytes * PATTERN_IMAGES), 0);
    ::close(fd);
    std::snprintf(rig_.board.display_device, sizeof rig_.board.display_device, "%s", path_);
    std::snprintf(rig_.board.display_connector, sizeof rig_.board.display_connector, "HDMI-A-1");
  }
  void TearDown() override {
    linux_display_close(&display_);
    unlink(path_);
  }
  enum lam_status open() { return linux_display_open(&display_, &rig_); }
  std::string refusal() {
    EXPECT_EQ(open(), LAM_HARDWARE);
    expect_nothing_left();
    return display_.error;
  }
  // The device's name is another in each run.
  std::string refusal_of_device() {
    const std::string text = refusal();
    EXPECT_EQ(text.rfind(path_, 0), 0u) << text;
    return text.substr(std::strlen(path_));
  }
  void expect_nothing_left() {
    EXPECT_EQ(kernel.objects, 0);
    EXPECT_EQ(kernel.buffers.size(), 0u);
    EXPECT_EQ(kernel.framebuffers, std::set<uint32_t>({9}));
    EXPECT_EQ(display_.fd, -1);
  }
  void open_and_count() {
    ASSERT_EQ(open(), LAM_OK) << display_.error;
    ASSERT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_OK);
  }
  enum lam_status commit(lamella_v1_PatternSpan_Kind kind, uint8_t index = 0) {
    return linux_display_commit(&display_, {kind, index}, &at_us_);
  }

  struct rig rig_;
  struct linux_display display_ = {};
  char path_[64];
  double at_us_ = 0;
};

}  // namespace

extern "C" {
int drmSetClientCap(int, uint64_t cap, uint64_t) {
  return kernel.fails(cap == DRM_CLIENT_CAP_ATOMIC ? "atomic" : "planes") ? -1 : 0;
}
int drmGetCap(int, uint64_t, uint64_t* value) {
  *value = kernel.monotonic;
  return kernel.fails("cap") ? -1 : 0;
}
int drmIsMaster(int) { return kernel.fails("master") ? 0 : kernel.master; }

drmModeResPtr drmModeGetResources(int) {
  if (kernel.fails("resources")) return nullptr;
  auto* all = given<drmModeRes>();
  all->count_crtcs = all->count_connectors = 1;
  all->crtcs = array<uint32_t>(1);
  all->connectors = array<uint32_t>(1);
  all->crtcs[0] = kCrtc;
  all->connectors[0] = kConnector;
  return all;
}
void drmModeFreeResources(drmModeResPtr all) {
  if (all != nullptr) take_back(all, {all->crtcs, all->connectors});
}

drmModeConnectorPtr drmModeGetConnector(int, uint32_t) {
  if (kernel.fails("connector")) return nullptr;
  auto* connector = given<drmModeConnector>();
  connector->connector_id = kConnector;
  connector->encoder_id = kEncoder;
  connector->connector_type = DRM_MODE_CONNECTOR_HDMIA;
  connector->connector_type_id = 1;
  connector->connection = kernel.connected ? DRM_MODE_CONNECTED : DRM_MODE_DISCONNECTED;
  connector->count_modes = kernel.connected ? 3 : 0;
  connector->modes = array<drmModeModeInfo>(3);
  const uint32_t type = kernel.preferred ? DRM_MODE_TYPE_PREFERRED : 0;
  connector->modes[0] = mode_of(kernel.native_width, 69800, type);  // 50 Hz
  connector->modes[1] = mode_of(kernel.native_width, kernel.refresh_clock, 0);
  connector->modes[2] = mode_of(1024, kernel.refresh_clock, 0);
  connector->count_encoders = 1;
  connector->encoders = array<uint32_t>(1);
  connector->encoders[0] = kEncoder;
  return connector;
}
void drmModeFreeConnector(drmModeConnectorPtr connector) {
  if (connector != nullptr) take_back(connector, {connector->modes, connector->encoders});
}

drmModeEncoderPtr drmModeGetEncoder(int, uint32_t) {
  if (kernel.fails("encoder")) return nullptr;
  auto* encoder = given<drmModeEncoder>();
  encoder->encoder_id = kEncoder;
  encoder->crtc_id = kCrtc;
  encoder->possible_crtcs = 1;
  return encoder;
}
void drmModeFreeEncoder(drmModeEncoderPtr encoder) { take_back(encoder, {}); }

drmModePlaneResPtr drmModeGetPlaneResources(int) {
  if (kernel.fails("plane list")) return nullptr;
  auto* all = given<drmModePlaneRes>();
  all->count_planes = 2;
  all->planes = array<uint32_t>(2);
  all->planes[0] = kCursor;
  all->planes[1] = kPlane;
  return all;
}
void drmModeFreePlaneResources(drmModePlaneResPtr all) {
  if (all != nullptr) take_back(all, {all->planes});
}
drmModePlanePtr drmModeGetPlane(int, uint32_t id) {
  if (kernel.fails("plane")) return nullptr;
  auto* plane = given<drmModePlane>();
  plane->plane_id = id;
  plane->possible_crtcs = 1;
  plane->crtc_id = kCrtc;
  plane->count_formats = 1;
  plane->formats = array<uint32_t>(1);
  plane->formats[0] = kernel.plane_format;
  return plane;
}
void drmModeFreePlane(drmModePlanePtr plane) {
  if (plane != nullptr) take_back(plane, {plane->formats});
}

drmModeObjectPropertiesPtr drmModeObjectGetProperties(int, uint32_t object, uint32_t) {
  if (kernel.fails("properties")) return nullptr;
  const std::vector<Property>& own = kernel.properties[object];
  auto* all = given<drmModeObjectProperties>();
  all->count_props = static_cast<uint32_t>(own.size());
  all->props = array<uint32_t>(own.size());
  all->prop_values = array<uint64_t>(own.size());
  for (size_t i = 0; i < own.size(); i++) {
    all->props[i] = own[i].id;
    all->prop_values[i] = own[i].value;
  }
  return all;
}
void drmModeFreeObjectProperties(drmModeObjectPropertiesPtr all) {
  if (all != nullptr) take_back(all, {all->props, all->prop_values});
}
drmModePropertyPtr drmModeGetProperty(int, uint32_t id) {
  if (kernel.fails("property")) return nullptr;
  for (const auto& [object, own] : kernel.properties) {
    for (const Property& one : own) {
      if (one.id != id) continue;
      auto* property = given<drmModePropertyRes>();
      property->prop_id = id;
      property->flags = one.flags;
      std::snprintf(property->name, sizeof property->name, "%s", one.name.c_str());
      property->count_enums = static_cast<int>(one.words.size());
      property->enums = array<drm_mode_property_enum>(one.words.size() + 1);
      for (size_t i = 0; i < one.words.size(); i++) {
        property->enums[i].value = i;
        std::snprintf(property->enums[i].name, sizeof property->enums[i].name, "%s",
                      one.words[i].c_str());
      }
      return property;
    }
  }
  return nullptr;
}
void drmModeFreeProperty(drmModePropertyPtr property) {
  if (property != nullptr) take_back(property, {property->enums});
}

drmModePropertyBlobPtr drmModeGetPropertyBlob(int, uint32_t) {
  if (kernel.fails("read blob")) return nullptr;
  auto* blob = given<drmModePropertyBlobRes>();
  blob->length = 4;
  blob->data = calloc(1, 4);
  return blob;
}
void drmModeFreePropertyBlob(drmModePropertyBlobPtr blob) {
  if (blob != nullptr) take_back(blob, {blob->data});
}
int drmModeCreatePropertyBlob(int, const void*, size_t, uint32_t* id) {
  if (kernel.fails("blob")) return -1;
  *id = kernel.next_id++;
  kernel.blobs.insert(*id);
  return 0;
}
int drmModeDestroyPropertyBlob(int, uint32_t id) { return kernel.blobs.erase(id) == 1 ? 0 : -1; }

int drmModeCreateDumbBuffer(int, uint32_t width, uint32_t height, uint32_t, uint32_t,
                            uint32_t* handle, uint32_t* pitch, uint64_t* size) {
  if (kernel.fails("buffer")) return -1;
  *handle = kernel.next_id++;
  *pitch = width * 4;
  *size = uint64_t{width} * height * 4;
  kernel.buffers.insert(*handle);
  return 0;
}
int drmModeDestroyDumbBuffer(int, uint32_t handle) { return kernel.buffers.erase(handle) ? 0 : -1; }
int drmModeMapDumbBuffer(int, uint32_t handle, uint64_t* offset) {
  const auto place = std::distance(kernel.buffers.begin(), kernel.buffers.find(handle));
  *offset = kernel.failing.count("offset") ? 1 : static_cast<uint64_t>(place) * kBufferBytes;
  return kernel.fails("map") ? -1 : 0;
}
int drmModeAddFB2(int, uint32_t, uint32_t, uint32_t, const uint32_t*, const uint32_t*,
                  const uint32_t*, uint32_t* id, uint32_t) {
  if (kernel.fails("framebuffer")) return -1;
  *id = kernel.next_id++;
  kernel.framebuffers.insert(*id);
  return 0;
}
int drmModeRmFB(int, uint32_t id) { return kernel.framebuffers.erase(id) ? 0 : -1; }

struct _drmModeAtomicReq {
  std::vector<std::array<uint64_t, 3>> items;
};
drmModeAtomicReqPtr drmModeAtomicAlloc(void) {
  if (kernel.fails("request")) return nullptr;
  kernel.objects++;
  return new _drmModeAtomicReq();
}
void drmModeAtomicFree(drmModeAtomicReqPtr request) {
  kernel.objects--;
  delete request;
}
void drmModeAtomicSetCursor(drmModeAtomicReqPtr request, int cursor) {
  request->items.resize(static_cast<size_t>(cursor));
}
int drmModeAtomicAddProperty(drmModeAtomicReqPtr request, uint32_t object, uint32_t property,
                             uint64_t value) {
  if (kernel.fails("add property")) return -ENOMEM;
  request->items.push_back({object, property, value});
  return static_cast<int>(request->items.size());
}
int drmModeAtomicCommit(int, const drmModeAtomicReqPtr request, uint32_t flags, void* user) {
  if (kernel.fails("commit")) return -EINVAL;
  if (flags & DRM_MODE_PAGE_FLIP_EVENT) {
    EXPECT_TRUE(flags & DRM_MODE_ATOMIC_NONBLOCK);
    EXPECT_EQ(request->items.size(), 1u);
    EXPECT_EQ(request->items[0][0], kPlane);
    EXPECT_EQ(request->items[0][1], kernel.property(kPlane, "FB_ID").id);
    kernel.asked = static_cast<uint32_t>(request->items[0][2]);
    kernel.waiting = user;
    return 0;
  }
  for (const auto& [object, property, value] : request->items) {
    for (Property& one : kernel.properties[static_cast<uint32_t>(object)]) {
      if (one.id != property) continue;
      // A mode that nothing shows any more is gone with its blob.
      if (one.name == "MODE_ID" && one.value == 7) kernel.blobs.erase(7);
      if (one.flags & DRM_MODE_PROP_BLOB && value != 0 &&
          kernel.blobs.count(uint32_t(value)) == 0) {
        return -ENOENT;
      }
      one.value = value;
    }
  }
  kernel.modesets.push_back(kernel.property(kCrtc, "ACTIVE").value);
  return 0;
}

int drmCrtcGetSequence(int, uint32_t, uint64_t* sequence, uint64_t* at_ns) {
  *sequence = kernel.sequence;
  *at_ns = kernel.now_us * 1000;
  return kernel.fails("sequence") ? -1 : 0;
}
int drmWaitVBlank(int, drmVBlankPtr wait) {
  if (kernel.fails("wait")) return -1;
  kernel.vblank();
  wait->reply.sequence = static_cast<unsigned>(kernel.sequence);
  wait->reply.tval_sec = static_cast<long>(kernel.now_us / 1000000);
  wait->reply.tval_usec = static_cast<long>(kernel.now_us % 1000000);
  return 0;
}
int drmHandleEvent(int fd, drmEventContextPtr context) {
  if (kernel.fails("event")) return -1;
  errno = EAGAIN;
  if (!kernel.event.ready) return -1;
  kernel.event.ready = false;
  void* user = std::exchange(kernel.waiting, nullptr);
  EXPECT_GE(context->version, 3);
  context->page_flip_handler2(fd, kernel.event.sequence,
                              static_cast<unsigned>(kernel.event.at_us / 1000000),
                              static_cast<unsigned>(kernel.event.at_us % 1000000), kCrtc, user);
  return 0;
}
}

TEST_F(LinuxDisplay, HoldsEveryImageOfTheBurstInABufferOfItsOwn) {
  ASSERT_EQ(open(), LAM_OK) << display_.error;
  EXPECT_EQ(kernel.buffers.size(), size_t(PATTERN_IMAGES));
  EXPECT_EQ(display_.bytes, kBufferBytes * PATTERN_IMAGES);
  const int fd = ::open(path_, O_RDONLY);
  void* held = mmap(nullptr, display_.bytes, PROT_READ, MAP_SHARED, fd, 0);
  std::vector<uint32_t> drawn(kBufferBytes / 4);
  for (size_t image = 0; image < PATTERN_IMAGES; image++) {
    pattern_draw(&rig_, image, drawn.data(), 1280);
    EXPECT_EQ(
        std::memcmp(static_cast<char*>(held) + image * kBufferBytes, drawn.data(), kBufferBytes), 0)
        << image;
  }
  munmap(held, display_.bytes);
  ::close(fd);
}

TEST_F(LinuxDisplay, IsSetWholeUnscaledAndFullRangeWithNothingOverIt) {
  ASSERT_EQ(open(), LAM_OK) << display_.error;
  EXPECT_EQ(kernel.property(kConnector, "max bpc").value, 8u);
  EXPECT_EQ(kernel.property(kConnector, "Broadcast RGB").value, 1u);
  EXPECT_EQ(kernel.property(kCrtc, "ACTIVE").value, 1u);
  EXPECT_EQ(kernel.property(kPlane, "SRC_X").value, 0u);
  EXPECT_EQ(kernel.property(kPlane, "SRC_W").value, uint64_t{1280} << 16);
  EXPECT_EQ(kernel.property(kPlane, "CRTC_W").value, 1280u);
  EXPECT_EQ(kernel.property(kPlane, "CRTC_H").value, 800u);
  EXPECT_EQ(kernel.property(kCursor, "FB_ID").value, 0u);
  EXPECT_EQ(kernel.property(kCursor, "CRTC_ID").value, 0u);
}

TEST_F(LinuxDisplay, TakesTheModeThatRefreshesAsTheRigFileSays) {
  ASSERT_EQ(open(), LAM_OK);
  EXPECT_NEAR(display_.output.refresh_us, kRefreshUs, 1e-6);
}

TEST_F(LinuxDisplay, GoesBackToTheConsoleItCameFrom) {
  ASSERT_EQ(open(), LAM_OK);
  linux_display_close(&display_);
  EXPECT_EQ(kernel.property(kConnector, "max bpc").value, 12u);
  EXPECT_EQ(kernel.property(kConnector, "Broadcast RGB").value, 0u);
  EXPECT_EQ(kernel.property(kPlane, "FB_ID").value, 9u);
  EXPECT_EQ(kernel.property(kPlane, "SRC_W").value, 77u);
  EXPECT_EQ(kernel.property(kCursor, "CRTC_ID").value, uint64_t{kCrtc});
  EXPECT_NE(kernel.property(kCrtc, "MODE_ID").value, 0u);  // a copy of the mode that it had
  expect_nothing_left();
  EXPECT_EQ(kernel.blobs.size(), 0u);
}

TEST_F(LinuxDisplay, FlipsAtTheNextVblankAndSaysWhenOnce) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_FRINGE, 2), LAM_OK) << display_.error;
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  kernel.vblank();
  ASSERT_TRUE(linux_display_flipped(&display_, &at_us_));
  EXPECT_DOUBLE_EQ(at_us_, static_cast<double>(kernel.now_us));
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  const size_t image = pattern_image({lamella_v1_PatternSpan_Kind_FRINGE, 2});
  EXPECT_EQ(kernel.shown, display_.framebuffers[image]);
  EXPECT_STREQ(display_.error, "");
}

TEST_F(LinuxDisplay, AFlipThatMissesItsVblankSaysSoAndTellsItsRealTime) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_STRIPES, 1), LAM_OK);
  kernel.vblank(2, 2);
  ASSERT_TRUE(linux_display_flipped(&display_, &at_us_));
  EXPECT_DOUBLE_EQ(at_us_, static_cast<double>(kernel.now_us));
  EXPECT_STREQ(display_.error, "stripes 1 was shown 1 refreshes late");
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_OK);
}

TEST_F(LinuxDisplay, AGapInTheVblanksIsAFaultUntilTheyAreCountedAnew) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_DOTS), LAM_OK);
  kernel.vblank(2, 1);
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_HARDWARE);
  EXPECT_STREQ(display_.error,
               "the projector's vblanks: 1 counted in 33439 us, 16720 us each: some were lost");
  ASSERT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_OK);
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_OK);
}

TEST_F(LinuxDisplay, ASecondFlipBeforeTheFirstIsRefused) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_DOTS), LAM_OK);
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "white: the flip before has not happened yet");
}

TEST_F(LinuxDisplay, APatternThatIsNotThereIsRefused) {
  open_and_count();
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_FRINGE, 4), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "fringe 4: the projector has no such pattern");
}

TEST_F(LinuxDisplay, AFlipOfABurstThatWasGivenUpIsForgottenBeforeTheNext) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_DOTS), LAM_OK);
  ASSERT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_OK);
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_OK);
}

TEST_F(LinuxDisplay, AFlipThatNeverHappensIsAFault) {
  open_and_count();
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_DOTS), LAM_OK);
  kernel.waiting = nullptr;
  EXPECT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "the projector: a flip never happened");
}

TEST_F(LinuxDisplay, EveryCallThatFailsDuringABurstSaysWhat) {
  open_and_count();
  kernel.failing = {"sequence"};
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "counting the projector's vblanks: Invalid argument");
  kernel.failing = {"add property"};
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "white: Cannot allocate memory");
  kernel.failing = {"commit"};
  EXPECT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "white: Invalid argument");
  kernel.failing = {"wait"};
  EXPECT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_HARDWARE);
  EXPECT_STREQ(display_.error, "waiting for the projector's vblank: Invalid argument");
  kernel.failing = {};
  ASSERT_EQ(commit(lamella_v1_PatternSpan_Kind_WHITE), LAM_OK);
  kernel.failing = {"event"};
  EXPECT_FALSE(linux_display_flipped(&display_, &at_us_));
  EXPECT_STREQ(display_.error, "the projector's events: Invalid argument");
  EXPECT_EQ(linux_display_next_vblank(&display_, &at_us_), LAM_HARDWARE);
}

// Each call to the kernel in turn: opening fails with a reason and leaves nothing behind, or does
// without what was asked.
TEST_F(LinuxDisplay, EveryCallThatFailsWhileItIsOpenedIsToldAndLeavesNothingBehind) {
  int failures = 0;
  for (int call = 0;; call++) {
    reset_kernel();
    kernel.failing_call = call;
    if (open() == LAM_OK) {
      const bool through = kernel.calls <= call;
      linux_display_close(&display_);
      expect_nothing_left();
      if (through) break;
      continue;
    }
    failures++;
    EXPECT_STRNE(display_.error, "") << call;
    expect_nothing_left();
    EXPECT_LE(kernel.blobs.size(), 1u) << call;
    EXPECT_EQ(kernel.property(kPlane, "FB_ID").value, 9u) << call << ": " << display_.error;
  }
  EXPECT_GT(failures, 100);
}

TEST_F(LinuxDisplay, MemoryThatCannotBeHadIsNamedWithItsSize) {
  for (const char* what : {"buffer", "map", "offset"}) {
    kernel.failing = {what};
    EXPECT_EQ(refusal(),
              "image 1 of 11 of the projector, 4096000 bytes each: Invalid argument (on a board: "
              "cma= of the kernel)");
  }
}

TEST_F(LinuxDisplay, AProjectorThatIsNotAsTheRigFileSaysIsRefusedWithBothNumbers) {
  kernel.native_width = 1920;
  EXPECT_EQ(refusal(),
            "HDMI-A-1 has 1920 x 800 pixels, projector.width_px x height_px are 1280 x 800");
  kernel.native_width = 1280;
  rig_.projector_refresh_hz = 60;
  EXPECT_EQ(refusal(), "HDMI-A-1 refreshes at 59.8103 Hz, projector.refresh_hz is 60");
  kernel.interlaced = true;
  EXPECT_EQ(refusal(), "HDMI-A-1: only interlaced modes have the projector's pixels");
}

TEST_F(LinuxDisplay, AProjectorThatPrefersNothingIsTakenAtItsFirstMode) {
  kernel.preferred = false;
  EXPECT_EQ(open(), LAM_OK) << display_.error;
}

TEST_F(LinuxDisplay, WhatIsMissingIsNamed) {
  kernel.connected = false;
  EXPECT_EQ(refusal(), "HDMI-A-1: no projector answers: is it switched on?");
  kernel.connected = true;
  kernel.plane_format = DRM_FORMAT_NV12;
  EXPECT_EQ(refusal(), "HDMI-A-1: no primary plane shows XRGB8888 on its CRTC");
  kernel.plane_format = DRM_FORMAT_XRGB8888;
  kernel.failing = {"encoder"};
  EXPECT_EQ(refusal(), "HDMI-A-1: no CRTC can feed this connector");
  kernel.failing = {};
  kernel.property(kPlane, "CRTC_W").name = "other";
  EXPECT_EQ(refusal(), "CRTC_W: the display has no such property");
  std::snprintf(rig_.board.display_connector, sizeof rig_.board.display_connector, "DP-2");
  EXPECT_EQ(refusal(), "DP-2: the display device has no such connector (linux.display_connector)");
}

TEST_F(LinuxDisplay, ADeviceThatWillNotDoIsRefused) {
  kernel.failing = {"atomic"};
  EXPECT_EQ(refusal_of_device(), ": has no atomic mode setting");
  kernel.failing = {};
  kernel.monotonic = 0;
  EXPECT_EQ(refusal_of_device(), ": tells no monotonic time of its vblanks");
  kernel.monotonic = 1;
  kernel.master = false;
  EXPECT_EQ(refusal_of_device(), ": another program has the display: stop its desktop");
  std::snprintf(rig_.board.display_device, sizeof rig_.board.display_device, "/dev/dri/card77");
  EXPECT_EQ(refusal(), "/dev/dri/card77: No such file or directory");
}
