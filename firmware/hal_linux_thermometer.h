// The board's thermometer: a file of hwmon, read at most every 5 ms.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_THERMOMETER_H
#define LAMELLA_FIRMWARE_HAL_LINUX_THERMOMETER_H

#include "status.h"

struct linux_thermometer {
  int fd;            // -1: none
  double due_us;     // read again from then on
  double hottest_c;  // NAN until it is read
  char error[112];
};

// `file` may be empty: nothing is read then.
enum lam_status linux_thermometer_open(struct linux_thermometer* thermometer, const char* file);

enum lam_status linux_thermometer_read(struct linux_thermometer* thermometer);

void linux_thermometer_close(struct linux_thermometer* thermometer);

#endif
