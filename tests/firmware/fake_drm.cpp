#include "fake_drm.h"

#include <gtest/gtest.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <utility>

extern "C" {
#include <xf86drm.h>
#include <xf86drmMode.h>
}

namespace {

FakeDrm drm_kernel;

template <class T>
T* given() {
  drm_kernel.objects++;
  return static_cast<T*>(calloc(1, sizeof(T)));
}

template <class T>
T* array(size_t count) {
  return static_cast<T*>(calloc(count, sizeof(T)));
}

void take_back(void* object, std::initializer_list<void*> parts) {
  if (object == nullptr) return;
  drm_kernel.objects--;
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
  mode.flags = drm_kernel.interlaced ? DRM_MODE_FLAG_INTERLACE : 0;
  return mode;
}

}  // namespace

FakeDrm& fake_drm() { return drm_kernel; }

bool FakeDrm::fails(const char* name) {
  errno = EINVAL;
  return calls++ == failing_call || failing.count(name) > 0;
}

FakeDrm::Property& FakeDrm::property(uint32_t object, const std::string& name) {
  for (FakeDrm::Property& one : properties[object]) {
    if (one.name == name) return one;
  }
  ADD_FAILURE() << "no property " << name;
  return properties[object].front();
}

void FakeDrm::vblank(unsigned passed, unsigned counted) {
  now_us += static_cast<uint64_t>(passed * kFakeRefreshUs + 0.5);
  sequence += counted;
  if (waiting == nullptr) return;
  shown = asked;
  event = {true, static_cast<unsigned>(sequence), now_us};
}

void reset_fake_drm() {
  drm_kernel = FakeDrm();
  uint32_t id = 200;
  const auto add = [&](uint32_t object, const char* name, uint64_t value, uint32_t flags = 0,
                       std::vector<std::string> words = {}) {
    drm_kernel.properties[object].push_back({id++, flags, name, value, std::move(words)});
  };
  add(kFakeConnector, "CRTC_ID", kFakeCrtc);
  add(kFakeConnector, "max bpc", 12);
  add(kFakeConnector, "Broadcast RGB", 0, DRM_MODE_PROP_ENUM,
      {"Automatic", "Full", "Limited 16:235"});
  add(kFakeCrtc, "MODE_ID", kFakeConsoleMode, DRM_MODE_PROP_BLOB);
  add(kFakeCrtc, "ACTIVE", 1);
  add(kFakeCrtc, "GAMMA_LUT", 0, DRM_MODE_PROP_BLOB);
  for (uint32_t plane : {kFakePlane, kFakeCursor}) {
    add(plane, "type", plane == kFakePlane ? DRM_PLANE_TYPE_PRIMARY : DRM_PLANE_TYPE_CURSOR);
    add(plane, "FB_ID", kFakeConsole);
    add(plane, "CRTC_ID", kFakeCrtc);
    for (const char* name :
         {"SRC_X", "SRC_Y", "SRC_W", "SRC_H", "CRTC_X", "CRTC_Y", "CRTC_W", "CRTC_H"}) {
      add(plane, name, 77);
    }
  }
}

extern "C" {
int drmSetClientCap(int, uint64_t cap, uint64_t) {
  return drm_kernel.fails(cap == DRM_CLIENT_CAP_ATOMIC ? "atomic" : "planes") ? -1 : 0;
}
int drmGetCap(int, uint64_t, uint64_t* value) {
  *value = drm_kernel.monotonic;
  return drm_kernel.fails("cap") ? -1 : 0;
}
int drmIsMaster(int) { return drm_kernel.fails("master") ? 0 : drm_kernel.master; }

drmModeResPtr drmModeGetResources(int) {
  if (drm_kernel.fails("resources")) return nullptr;
  auto* all = given<drmModeRes>();
  all->count_crtcs = all->count_connectors = 1;
  all->crtcs = array<uint32_t>(1);
  all->connectors = array<uint32_t>(1);
  all->crtcs[0] = kFakeCrtc;
  all->connectors[0] = kFakeConnector;
  return all;
}
void drmModeFreeResources(drmModeResPtr all) {
  if (all != nullptr) take_back(all, {all->crtcs, all->connectors});
}

drmModeConnectorPtr drmModeGetConnector(int, uint32_t) {
  if (drm_kernel.fails("connector")) return nullptr;
  auto* connector = given<drmModeConnector>();
  connector->connector_id = kFakeConnector;
  connector->encoder_id = kFakeEncoder;
  connector->connector_type = DRM_MODE_CONNECTOR_HDMIA;
  connector->connector_type_id = 1;
  connector->connection = drm_kernel.connected ? DRM_MODE_CONNECTED : DRM_MODE_DISCONNECTED;
  connector->count_modes = drm_kernel.connected ? 3 : 0;
  connector->modes = array<drmModeModeInfo>(3);
  const uint32_t type = drm_kernel.preferred ? DRM_MODE_TYPE_PREFERRED : 0;
  connector->modes[0] = mode_of(drm_kernel.native_width, 69800, type);  // 50 Hz
  connector->modes[1] = mode_of(drm_kernel.native_width, 83500, 0);
  connector->modes[2] = mode_of(1024, 83500, 0);
  connector->count_encoders = 1;
  connector->encoders = array<uint32_t>(1);
  connector->encoders[0] = kFakeEncoder;
  return connector;
}
void drmModeFreeConnector(drmModeConnectorPtr connector) {
  if (connector != nullptr) take_back(connector, {connector->modes, connector->encoders});
}

drmModeEncoderPtr drmModeGetEncoder(int, uint32_t) {
  if (drm_kernel.fails("encoder")) return nullptr;
  auto* encoder = given<drmModeEncoder>();
  encoder->encoder_id = kFakeEncoder;
  encoder->crtc_id = kFakeCrtc;
  encoder->possible_crtcs = 1;
  return encoder;
}
void drmModeFreeEncoder(drmModeEncoderPtr encoder) { take_back(encoder, {}); }

drmModePlaneResPtr drmModeGetPlaneResources(int) {
  if (drm_kernel.fails("plane list")) return nullptr;
  auto* all = given<drmModePlaneRes>();
  all->count_planes = 2;
  all->planes = array<uint32_t>(2);
  all->planes[0] = kFakeCursor;
  all->planes[1] = kFakePlane;
  return all;
}
void drmModeFreePlaneResources(drmModePlaneResPtr all) {
  if (all != nullptr) take_back(all, {all->planes});
}
drmModePlanePtr drmModeGetPlane(int, uint32_t id) {
  if (drm_kernel.fails("plane")) return nullptr;
  auto* plane = given<drmModePlane>();
  plane->plane_id = id;
  plane->possible_crtcs = 1;
  plane->crtc_id = kFakeCrtc;
  plane->count_formats = 1;
  plane->formats = array<uint32_t>(1);
  plane->formats[0] = drm_kernel.plane_format;
  return plane;
}
void drmModeFreePlane(drmModePlanePtr plane) {
  if (plane != nullptr) take_back(plane, {plane->formats});
}

drmModeObjectPropertiesPtr drmModeObjectGetProperties(int, uint32_t object, uint32_t) {
  if (drm_kernel.fails("properties")) return nullptr;
  const std::vector<FakeDrm::Property>& own = drm_kernel.properties[object];
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
  if (drm_kernel.fails("property")) return nullptr;
  for (const auto& [object, own] : drm_kernel.properties) {
    for (const FakeDrm::Property& one : own) {
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
  if (drm_kernel.fails("read blob")) return nullptr;
  auto* blob = given<drmModePropertyBlobRes>();
  blob->length = 4;
  blob->data = calloc(1, 4);
  return blob;
}
void drmModeFreePropertyBlob(drmModePropertyBlobPtr blob) {
  if (blob != nullptr) take_back(blob, {blob->data});
}
int drmModeCreatePropertyBlob(int, const void*, size_t, uint32_t* id) {
  if (drm_kernel.fails("blob")) return -1;
  *id = drm_kernel.next_id++;
  drm_kernel.blobs.insert(*id);
  return 0;
}
int drmModeDestroyPropertyBlob(int, uint32_t id) {
  return drm_kernel.blobs.erase(id) == 1 ? 0 : -1;
}

int drmModeCreateDumbBuffer(int, uint32_t width, uint32_t height, uint32_t, uint32_t,
                            uint32_t* handle, uint32_t* pitch, uint64_t* size) {
  if (drm_kernel.fails("buffer")) return -1;
  *handle = drm_kernel.next_id++;
  *pitch = width * 4;
  *size = uint64_t{width} * height * 4;
  drm_kernel.buffers.insert(*handle);
  return 0;
}
int drmModeDestroyDumbBuffer(int, uint32_t handle) {
  return drm_kernel.buffers.erase(handle) ? 0 : -1;
}
int drmModeMapDumbBuffer(int, uint32_t handle, uint64_t* offset) {
  const auto place = std::distance(drm_kernel.buffers.begin(), drm_kernel.buffers.find(handle));
  *offset =
      drm_kernel.failing.count("offset") ? 1 : static_cast<uint64_t>(place) * kFakeBufferBytes;
  return drm_kernel.fails("map") ? -1 : 0;
}
int drmModeAddFB2(int, uint32_t, uint32_t, uint32_t, const uint32_t*, const uint32_t*,
                  const uint32_t*, uint32_t* id, uint32_t) {
  if (drm_kernel.fails("framebuffer")) return -1;
  *id = drm_kernel.next_id++;
  drm_kernel.framebuffers.insert(*id);
  return 0;
}
int drmModeRmFB(int, uint32_t id) { return drm_kernel.framebuffers.erase(id) ? 0 : -1; }

struct _drmModeAtomicReq {
  std::vector<std::array<uint64_t, 3>> items;
};
drmModeAtomicReqPtr drmModeAtomicAlloc(void) {
  if (drm_kernel.fails("request")) return nullptr;
  drm_kernel.objects++;
  return new _drmModeAtomicReq();
}
void drmModeAtomicFree(drmModeAtomicReqPtr request) {
  drm_kernel.objects--;
  delete request;
}
int drmModeAtomicAddProperty(drmModeAtomicReqPtr request, uint32_t object, uint32_t property,
                             uint64_t value) {
  if (drm_kernel.fails("add property")) return -ENOMEM;
  request->items.push_back({object, property, value});
  return static_cast<int>(request->items.size());
}
int drmModeAtomicCommit(int, const drmModeAtomicReqPtr request, uint32_t flags, void* user) {
  if (drm_kernel.fails("commit")) return -EINVAL;
  EXPECT_EQ(flags, static_cast<uint32_t>(DRM_MODE_ATOMIC_ALLOW_MODESET));
  EXPECT_EQ(user, nullptr);
  for (const auto& [object, property, value] : request->items) {
    for (FakeDrm::Property& one : drm_kernel.properties[static_cast<uint32_t>(object)]) {
      if (one.id != property) continue;
      // A mode that nothing shows any more is gone with its blob.
      if (one.name == "MODE_ID" && one.value == kFakeConsoleMode)
        drm_kernel.blobs.erase(kFakeConsoleMode);
      if (one.flags & DRM_MODE_PROP_BLOB && value != 0 &&
          drm_kernel.blobs.count(uint32_t(value)) == 0) {
        return -ENOENT;
      }
      one.value = value;
    }
  }
  return 0;
}

int drmIoctl(int, unsigned long call, void* argument) {
  EXPECT_EQ(call, DRM_IOCTL_MODE_ATOMIC);
  if (drm_kernel.fails("flip")) return -1;
  const auto* commit = static_cast<const drm_mode_atomic*>(argument);
  EXPECT_EQ(commit->flags, uint32_t{DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT});
  EXPECT_EQ(commit->count_objs, 1u);
  EXPECT_EQ(*reinterpret_cast<const uint32_t*>(commit->objs_ptr), kFakePlane);
  EXPECT_EQ(*reinterpret_cast<const uint32_t*>(commit->count_props_ptr), 1u);
  EXPECT_EQ(*reinterpret_cast<const uint32_t*>(commit->props_ptr),
            drm_kernel.property(kFakePlane, "FB_ID").id);
  drm_kernel.asked =
      static_cast<uint32_t>(*reinterpret_cast<const uint64_t*>(commit->prop_values_ptr));
  drm_kernel.waiting = reinterpret_cast<void*>(commit->user_data);
  return 0;
}

int drmWaitVBlank(int, drmVBlankPtr wait) {
  if (drm_kernel.fails("wait")) return -1;
  drm_kernel.vblank();
  wait->reply.sequence = static_cast<unsigned>(drm_kernel.sequence);
  wait->reply.tval_sec = static_cast<long>(drm_kernel.now_us / 1000000);
  wait->reply.tval_usec = static_cast<long>(drm_kernel.now_us % 1000000);
  return 0;
}
int drmHandleEvent(int fd, drmEventContextPtr context) {
  if (drm_kernel.fails("event")) return -1;
  errno = EAGAIN;
  if (!drm_kernel.event.ready) return -1;
  drm_kernel.event.ready = false;
  void* user = std::exchange(drm_kernel.waiting, nullptr);
  EXPECT_GE(context->version, 3);
  context->page_flip_handler2(
      fd, drm_kernel.event.sequence, static_cast<unsigned>(drm_kernel.event.at_us / 1000000),
      static_cast<unsigned>(drm_kernel.event.at_us % 1000000), kFakeCrtc, user);
  return 0;
}
}
