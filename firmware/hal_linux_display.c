#include "hal_linux_display.h"

#include <drm_fourcc.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include <xf86drm.h>

#include "hal_linux_time.h"

enum { kBitsPerPixel = 32, kEventVersion = 3, kLongestFlip = 4 };  // the last in vblanks

static enum lam_status fail(struct linux_display* display, const char* what, int reason) {
  snprintf(display->error, sizeof display->error, "%.90s: %s", what, strerror(reason));
  return LAM_HARDWARE;
}

static enum lam_status refuse(struct linux_display* display, const char* what, const char* why) {
  snprintf(display->error, sizeof display->error, "%.70s: %s", what, why);
  return LAM_HARDWARE;
}

static enum lam_status open_device(struct linux_display* display, const char* device) {
  display->fd = open(device, O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (display->fd < 0) return fail(display, device, errno);
  if (drmSetClientCap(display->fd, DRM_CLIENT_CAP_UNIVERSAL_PLANES, 1) != 0 ||
      drmSetClientCap(display->fd, DRM_CLIENT_CAP_ATOMIC, 1) != 0) {
    return refuse(display, device, "has no atomic mode setting");
  }
  uint64_t monotonic = 0;
  if (drmGetCap(display->fd, DRM_CAP_TIMESTAMP_MONOTONIC, &monotonic) != 0 || monotonic != 1) {
    return refuse(display, device, "tells no monotonic time of its vblanks");
  }
  if (!drmIsMaster(display->fd)) {
    return refuse(display, device, "another program has the display: stop its desktop");
  }
  return LAM_OK;
}

static enum lam_status out_of_memory(struct linux_display* display, size_t image, size_t bytes) {
  snprintf(display->error, sizeof display->error,
           "image %zu of %d of the projector, %zu bytes each: %s (on a board: cma= of the kernel)",
           image + 1, PATTERN_IMAGES, bytes, strerror(errno));
  return LAM_HARDWARE;
}

static enum lam_status draw(struct linux_display* display, const struct rig* rig, size_t image,
                            uint32_t pitch_bytes) {
  uint64_t offset = 0;
  const size_t bytes = (size_t)pitch_bytes * display->output.mode.vdisplay;
  if (drmModeMapDumbBuffer(display->fd, display->handles[image], &offset) != 0) {
    return out_of_memory(display, image, bytes);
  }
  void* pixels = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, display->fd, (off_t)offset);
  if (pixels == MAP_FAILED) return out_of_memory(display, image, bytes);
  pattern_draw(rig, image, pixels, pitch_bytes / sizeof(uint32_t));
  munmap(pixels, bytes);
  return LAM_OK;
}

static enum lam_status make_image(struct linux_display* display, const struct rig* rig,
                                  size_t image) {
  const uint32_t width = display->output.mode.hdisplay, height = display->output.mode.vdisplay;
  uint32_t handles[4] = {0}, pitches[4] = {0}, offsets[4] = {0};
  uint64_t size = 0;
  if (drmModeCreateDumbBuffer(display->fd, width, height, kBitsPerPixel, 0,
                              &display->handles[image], &pitches[0], &size) != 0) {
    return out_of_memory(display, image, (size_t)width * height * sizeof(uint32_t));
  }
  display->bytes += (size_t)size;
  handles[0] = display->handles[image];
  if (drmModeAddFB2(display->fd, width, height, DRM_FORMAT_XRGB8888, handles, pitches, offsets,
                    &display->framebuffers[image], 0) != 0) {
    return fail(display, "a framebuffer for the projector", errno);
  }
  return draw(display, rig, image, pitches[0]);
}

static uint32_t flip_property(const struct linux_display* display) {
  const struct linux_settings* settings = &display->settings;
  uint32_t property = 0;
  for (size_t i = 0; i < settings->count; i++) {
    const bool shows = settings->list[i].now == display->framebuffers[0];
    if (shows && settings->list[i].object == display->output.plane) {
      property = settings->list[i].property;
    }
  }
  return property;
}

static enum lam_status take_display(struct linux_display* display) {
  const drmModeModeInfo* mode = &display->output.mode;
  if (drmModeCreatePropertyBlob(display->fd, mode, sizeof *mode, &display->mode_blob) != 0) {
    return fail(display, "the projector's mode", errno);
  }
  const enum lam_status status =
      linux_output_settings(display->fd, &display->output,
                            (const uint32_t[]){display->mode_blob, display->framebuffers[0]},
                            &display->settings, display->error);
  if (status != LAM_OK) return status;
  const int failed = linux_settings_commit(display->fd, &display->settings, false);
  if (failed != 0) return fail(display, "setting the projector's mode", failed);
  display->taken = true;
  display->flip_property = flip_property(display);
  return LAM_OK;
}

static enum lam_status open_display(struct linux_display* display, const struct rig* rig) {
  enum lam_status status = open_device(display, rig->board.display_device);
  if (status != LAM_OK) return status;
  status = linux_output_find(display->fd, rig, &display->output, display->error);
  for (size_t i = 0; status == LAM_OK && i < PATTERN_IMAGES; i++) {
    status = make_image(display, rig, i);
  }
  return status == LAM_OK ? take_display(display) : status;
}

enum lam_status linux_display_open(struct linux_display* display, const struct rig* rig) {
  *display = (struct linux_display){.fd = -1};
  const enum lam_status status = open_display(display, rig);
  if (status != LAM_OK) linux_display_close(display);
  return status;
}

// The call itself: a request of libdrm's would allocate while a burst is played.
static bool flip(struct linux_display* display, uint64_t framebuffer) {
  const uint32_t one = 1;
  struct drm_mode_atomic commit = {.flags = DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT,
                                   .count_objs = one,
                                   .objs_ptr = (uintptr_t)&display->output.plane,
                                   .count_props_ptr = (uintptr_t)&one,
                                   .props_ptr = (uintptr_t)&display->flip_property,
                                   .prop_values_ptr = (uintptr_t)&framebuffer,
                                   .user_data = (uintptr_t)display};
  return drmIoctl(display->fd, DRM_IOCTL_MODE_ATOMIC, &commit) == 0;
}

enum lam_status linux_display_commit(struct linux_display* display, struct hal_pattern pattern,
                                     double* at_us) {
  char name[16];
  pattern_name(pattern, name);
  const size_t image = pattern_image(pattern);
  *at_us = linux_now_us();
  if (display->broken) return LAM_HARDWARE;
  if (image == PATTERN_IMAGES) return refuse(display, name, "the projector has no such pattern");
  if (display->pending) return refuse(display, name, "the flip before has not happened yet");
  if (!flip(display, display->framebuffers[image])) return fail(display, name, errno);
  display->pattern = pattern;
  display->pending = true;
  return LAM_OK;
}

static double time_us(unsigned seconds, unsigned micros) { return seconds * 1e6 + micros; }

// Vblanks are counted by the kernel and timed by the display: where the two disagree, some were
// lost.
static bool keeps_pace(struct linux_display* display, uint32_t sequence, double vblank_us) {
  const uint32_t count = sequence - display->sequence;
  const double passed_us = vblank_us - display->vblank_us;
  const double refresh_us = display->output.refresh_us;
  if (fabs(passed_us - count * refresh_us) < refresh_us / 4) return true;
  char name[16];
  pattern_name(display->pattern, name);
  snprintf(display->error, sizeof display->error,
           "the flip to %s: %u vblanks counted in %.0f us, %.0f us each: some were lost", name,
           count, passed_us, refresh_us);
  return false;
}

static void on_flip(int fd, unsigned sequence, unsigned seconds, unsigned micros, unsigned crtc,
                    void* self) {
  (void)fd, (void)crtc;
  struct linux_display* display = self;
  const double vblank_us = time_us(seconds, micros);
  display->pending = false;
  if (!keeps_pace(display, sequence, vblank_us)) display->broken = true;
  display->sequence = sequence;
  display->vblank_us = vblank_us;
}

// Takes the events that have come; false where they cannot be read.
static bool take_events(struct linux_display* display) {
  drmEventContext context = {.version = kEventVersion, .page_flip_handler2 = on_flip};
  errno = 0;
  if (drmHandleEvent(display->fd, &context) == 0 || errno == EAGAIN || errno == EINTR) return true;
  fail(display, "the projector's events", errno != 0 ? errno : EIO);
  return false;
}

bool linux_display_flipped(struct linux_display* display, double* at_us) {
  if (!display->pending) return false;
  if (!take_events(display)) display->broken = true;
  *at_us = display->vblank_us;
  return !display->pending && !display->broken;
}

static enum lam_status wait_vblank(struct linux_display* display) {
  const unsigned pipe = display->output.pipe << DRM_VBLANK_HIGH_CRTC_SHIFT;
  drmVBlank wait = {.request = {.type = DRM_VBLANK_RELATIVE | pipe, .sequence = 1}};
  if (drmWaitVBlank(display->fd, &wait) != 0) {
    return fail(display, "waiting for the projector's vblank", errno);
  }
  display->sequence = wait.reply.sequence;
  display->vblank_us = time_us((unsigned)wait.reply.tval_sec, (unsigned)wait.reply.tval_usec);
  return LAM_OK;
}

enum lam_status linux_display_next_vblank(struct linux_display* display, double* at_us) {
  enum lam_status status = wait_vblank(display);
  for (int i = 0; status == LAM_OK && display->pending; i++) {  // of a burst that was given up
    if (i == kLongestFlip) return refuse(display, "the projector", "a flip never happened");
    if (!take_events(display)) return LAM_HARDWARE;
    status = wait_vblank(display);
  }
  if (status == LAM_OK) display->broken = false;
  *at_us = display->vblank_us;
  return status;
}

void linux_display_close(struct linux_display* display) {
  if (display->fd < 0) return;
  if (display->taken) linux_settings_commit(display->fd, &display->settings, true);
  linux_settings_forget(display->fd, &display->settings);
  for (size_t i = 0; i < PATTERN_IMAGES; i++) {
    if (display->framebuffers[i] != 0) drmModeRmFB(display->fd, display->framebuffers[i]);
    if (display->handles[i] != 0) drmModeDestroyDumbBuffer(display->fd, display->handles[i]);
  }
  if (display->mode_blob != 0) drmModeDestroyPropertyBlob(display->fd, display->mode_blob);
  close(display->fd);
  display->fd = -1;
  display->taken = display->pending = false;
}
