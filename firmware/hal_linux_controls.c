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

enum { kNameChars = 64, kErrorChars = LINUX_CONTROLS_ERROR_CHARS };
static const char kControl[] = "control:", kModule[] = "module:", kFixed[] = "fixed";

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

// "NAME=VALUE" into its two parts.
static bool split(const char* text, char name[kNameChars], const char** value) {
  const char* equals = strrchr(text, '=');
  if (equals == NULL || equals == text || equals[1] == '\0') return false;
  const size_t length = (size_t)(equals - text);
  if (length >= kNameChars) return false;
  memcpy(name, text, length);
  name[length] = '\0';
  *value = equals + 1;
  return true;
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

static enum lam_status trigger_by_control(const char* device, const char* setting, char* error) {
  char name[kNameChars], *end = NULL;
  const char* text = NULL;
  const long value = split(setting, name, &text) ? strtol(text, &end, 0) : 0;
  if (end == NULL || *end != '\0' || value < INT32_MIN || value > INT32_MAX) {
    snprintf(error, kErrorChars, "'control:%.60s' is not control:NAME=NUMBER", setting);
    return LAM_BAD_INPUT;
  }
  const int fd = open(device, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return fail(error, "cannot open", device);
  const enum lam_status status = set_by_name(fd, device, name, value, error);
  close(fd);
  return status;
}

// The first word of a file under /sys.
static bool read_word(const char* path, char word[kNameChars]) {
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const ssize_t size = read(fd, word, kNameChars - 1);
  close(fd);
  word[size > 0 ? size : 0] = '\0';
  word[strcspn(word, " \n")] = '\0';
  return size > 0;
}

static enum lam_status trigger_by_module(const char* setting, char* error) {
  static const char kMiddle[] = "/parameters/";
  char name[kNameChars], path[kNameChars + 16], is[kNameChars];
  const char* value = NULL;
  char* middle = split(setting, name, &value) ? strstr(name, kMiddle) : NULL;
  if (middle == NULL || strstr(name, "..") != NULL) {
    snprintf(error, kErrorChars, "'module:%.60s' is not module:NAME/parameters/NAME=VALUE",
             setting);
    return LAM_BAD_INPUT;
  }
  snprintf(path, sizeof path, "/sys/module/%s", name);
  if (!read_word(path, is)) return fail(error, "the camera's module is not there:", path);
  if (strcmp(is, value) == 0) return LAM_OK;
  *middle = '\0';
  const char* parameter = middle + sizeof kMiddle - 1;
  snprintf(error, kErrorChars,
           "%.24s is %.8s: write 'options %.24s %.24s=%.8s' into /etc/modprobe.d/lamella.conf, "
           "and restart",
           parameter, is, name, parameter, value);
  return LAM_HARDWARE;
}

enum lam_status linux_controls_trigger(const char* device, const char* hook,
                                       char error[LINUX_CONTROLS_ERROR_CHARS]) {
  if (strcmp(hook, kFixed) == 0) return LAM_OK;
  if (strncmp(hook, kControl, strlen(kControl)) == 0) {
    return trigger_by_control(device, hook + strlen(kControl), error);
  }
  if (strncmp(hook, kModule, strlen(kModule)) == 0) {
    return trigger_by_module(hook + strlen(kModule), error);
  }
  snprintf(error, kErrorChars, "linux.camera_trigger is control:, module: or fixed, not '%.40s'",
           hook);
  return LAM_BAD_INPUT;
}

static enum lam_status expose(int fd, double step_us, double wished_us, double* exposure_us,
                              char* error) {
  // A camera without an automatic exposure has nothing to switch off.
  struct v4l2_control manual = {.id = V4L2_CID_EXPOSURE_AUTO, .value = V4L2_EXPOSURE_MANUAL};
  if (ask(fd, VIDIOC_S_CTRL, &manual) != 0 && errno != EINVAL && errno != ENOTTY) {
    return fail(error, "cannot switch off", "automatic exposure");
  }
  int64_t steps = llround(wished_us / step_us);
  const enum lam_status status = set_control(fd, V4L2_CID_EXPOSURE, &steps, error);
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
