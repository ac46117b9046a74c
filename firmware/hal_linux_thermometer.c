#include "hal_linux_thermometer.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "hal_linux_time.h"

static const double kEveryUs = 5000;  // a sensor may take a millisecond to read

static enum lam_status fail(struct linux_thermometer* thermometer, const char* file) {
  snprintf(thermometer->error, sizeof thermometer->error,
           "linux.temperature_file%s%.64s cannot be read", file[0] == '\0' ? "" : " ", file);
  return LAM_HARDWARE;
}

enum lam_status linux_thermometer_open(struct linux_thermometer* thermometer, const char* file) {
  *thermometer = (struct linux_thermometer){.fd = -1, .hottest_c = NAN};
  if (file[0] == '\0') return LAM_OK;
  thermometer->fd = open(file, O_RDONLY | O_CLOEXEC);
  if (thermometer->fd < 0 || linux_thermometer_read(thermometer) != LAM_OK) {
    return fail(thermometer, file);
  }
  return LAM_OK;
}

enum lam_status linux_thermometer_read(struct linux_thermometer* thermometer) {
  if (thermometer->fd < 0 || linux_now_us() < thermometer->due_us) return LAM_OK;
  char text[16];
  const ssize_t size = pread(thermometer->fd, text, sizeof text - 1, 0);
  if (size <= 0) return fail(thermometer, "");
  text[size] = '\0';
  char* end = NULL;
  thermometer->hottest_c = strtol(text, &end, 10) * 1e-3;
  thermometer->due_us = linux_now_us() + kEveryUs;
  return end != text ? LAM_OK : fail(thermometer, "");
}

void linux_thermometer_close(struct linux_thermometer* thermometer) {
  if (thermometer->fd >= 0) close(thermometer->fd);
  thermometer->fd = -1;
}
