#include "hal_linux_controls.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "rig_hook.h"

enum { kWordChars = 64, kErrorChars = LINUX_CONTROLS_ERROR_CHARS };

static enum lam_status fail(char* error, const char* what, const char* name) {
  snprintf(error, kErrorChars, "%.70s %.40s: %s", what, name, strerror(errno));
  return LAM_HARDWARE;
}

static int ask(int fd, unsigned long request, void* argument) {
  int result;
  do {
    result = ioctl(fd, request, argument);
  } while (result != 0 && errno == EINTR);
  return result;
}

static bool find_control(int fd, const char* name, struct v4l2_query_ext_ctrl* found) {
  *found = (struct v4l2_query_ext_ctrl){.id = V4L2_CTRL_FLAG_NEXT_CTRL};
  while (ask(fd, VIDIOC_QUERY_EXT_CTRL, found) == 0) {
    if (strcasecmp(found->name, name) == 0) return true;
    found->id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return false;
}

// Sets the control and reads it back into `value`.
static enum lam_status set_control(int fd, uint32_t id, int64_t* value, char* error) {
  struct v4l2_control control = {.id = id, .value = (int32_t)*value};
  if (ask(fd, VIDIOC_S_CTRL, &control) != 0) return fail(error, "the camera refuses", "a control");
  control.value = 0;
  if (ask(fd, VIDIOC_G_CTRL, &control) != 0) return fail(error, "cannot read back", "a control");
  *value = control.value;
  return LAM_OK;
}

static enum lam_status set_by_name(int fd, const char* device, const char* name, long value,
                                   char* error) {
  struct v4l2_query_ext_ctrl control;
  if (!find_control(fd, name, &control)) {
    snprintf(error, kErrorChars, "%.40s has no control '%.32s': v4l2-ctl -l lists those it has",
             device, name);
    return LAM_HARDWARE;
  }
  int64_t is = value;
  const enum lam_status status = set_control(fd, control.id, &is, error);
  if (status != LAM_OK || is == value) return status;
  snprintf(error, kErrorChars, "%.40s: control '%.32s' stays %lld, not %ld", device, name,
           (long long)is, value);
  return LAM_HARDWARE;
}

static enum lam_status trigger_by_control(const char* device, const struct rig_hook* hook,
                                          char* error) {
  const int fd = open(device, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return fail(error, "cannot open", device);
  const enum lam_status status = set_by_name(fd, device, hook->name, hook->number, error);
  close(fd);
  return status;
}

// The first word of a file under /sys.
static bool read_word(const char* path, char word[kWordChars]) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const ssize_t size = read(fd, word, kWordChars - 1);
  close(fd);
  word[size > 0 ? size : 0] = '\0';
  word[strcspn(word, " \n")] = '\0';
  return size > 0;
}

static enum lam_status trigger_by_module(const struct rig_hook* hook, char* error) {
  char path[sizeof hook->name + 16], is[kWordChars];
  snprintf(path, sizeof path, "/sys/module/%s", hook->name);
  if (!read_word(path, is)) return fail(error, "the camera's module is not there:", path);
  if (strcmp(is, hook->value) == 0) return LAM_OK;
  snprintf(error, kErrorChars,
           "%.24s is %.8s: write 'options %.*s %.24s=%.8s' into /etc/modprobe.d/lamella.conf, "
           "and restart",
           strrchr(hook->name, '/') + 1, is, (int)strcspn(hook->name, "/"), hook->name,
           strrchr(hook->name, '/') + 1, hook->value);
  return LAM_HARDWARE;
}

enum lam_status linux_controls_trigger(const char* device, const char* text,
                                       char error[LINUX_CONTROLS_ERROR_CHARS]) {
  struct rig_hook hook;
  if (!rig_hook_read(text, &hook, error)) return LAM_BAD_INPUT;
  switch (hook.kind) {
    case RIG_HOOK_CONTROL:
      return trigger_by_control(device, &hook, error);
    case RIG_HOOK_MODULE:
      return trigger_by_module(&hook, error);
    case RIG_HOOK_FIXED:
      break;
  }
  return LAM_OK;
}

// A sensor's driver counts lines, of whatever length; a USB camera counts what V4L2 says.
static enum lam_status find_exposure(int fd, double step_us, uint32_t* id, char* error) {
  static const double kAbsoluteUs = 100;
  struct v4l2_query_ext_ctrl control = {.id = V4L2_CID_EXPOSURE};
  const bool counts_lines = ask(fd, VIDIOC_QUERY_EXT_CTRL, &control) == 0;
  if (!counts_lines && errno != EINVAL) return fail(error, "cannot ask for", "the exposure");
  *id = counts_lines ? V4L2_CID_EXPOSURE : V4L2_CID_EXPOSURE_ABSOLUTE;
  if (counts_lines || step_us == kAbsoluteUs) return LAM_OK;
  snprintf(error, kErrorChars,
           "the camera has no control Exposure; 'camera.exposure_step_us = %.0f' for its Exposure "
           "Time, Absolute",
           kAbsoluteUs);
  return LAM_BAD_INPUT;
}

static enum lam_status expose(int fd, double step_us, double wished_us, double* exposure_us,
                              char* error) {
  // A camera without an automatic exposure has nothing to switch off.
  struct v4l2_control manual = {.id = V4L2_CID_EXPOSURE_AUTO, .value = V4L2_EXPOSURE_MANUAL};
  if (ask(fd, VIDIOC_S_CTRL, &manual) != 0 && errno != EINVAL && errno != ENOTTY) {
    return fail(error, "cannot switch off", "automatic exposure");
  }
  uint32_t id = 0;
  enum lam_status status = find_exposure(fd, step_us, &id, error);
  if (status != LAM_OK) return status;
  int64_t steps = llround(wished_us / step_us);
  status = set_control(fd, id, &steps, error);
  if (status != LAM_OK) return status;
  *exposure_us = (double)steps * step_us;
  if (fabs(*exposure_us - wished_us) <= step_us) return LAM_OK;
  snprintf(error, kErrorChars, "the camera exposes for %.1f us where %.1f us were asked",
           *exposure_us, wished_us);
  return LAM_HARDWARE;
}

enum lam_status linux_controls_expose(const char* device, double step_us, double wished_us,
                                      double* exposure_us, char error[LINUX_CONTROLS_ERROR_CHARS]) {
  const int fd = open(device, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return fail(error, "cannot open", device);
  const enum lam_status status = expose(fd, step_us, wished_us, exposure_us, error);
  close(fd);
  return status;
}
