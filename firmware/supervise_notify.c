#include "supervise_notify.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef LAMELLA_SYSTEMD
#include <systemd/sd-daemon.h>
#endif

// Half of WatchdogSec would do; a quarter leaves room for the longest piece of work.
static const double kShareOfWatchdog = 0.25;

// What one piece of a self-test may take: the trial of a slow disk is the longest.
static const double kTestingUs = 60e6;

static char last_status[160];
static double last_alive_us;
static bool is_ready;

static void tell(const char* what) {
#ifdef LAMELLA_SYSTEMD
  sd_notify(0, what);
#else
  (void)what;
#endif
}

static void tell_status(const char* before, const char* status) {
  snprintf(last_status, sizeof last_status, "%s", status);
  char text[200];
  snprintf(text, sizeof text, "%sSTATUS=%s", before, last_status);
  tell(text);
}

// Not sd_watchdog_enabled(): that asks whether this very process was started by the service
// manager, and the sequencer is its child's child (the unit says NotifyAccess=all).
static double watchdog_us(void) {
  const char* text = getenv("WATCHDOG_USEC");
  return text != NULL ? strtod(text, NULL) : 0;
}

void notify_status(const char* status) {
  if (strncmp(status, last_status, sizeof last_status - 1) == 0) return;
  tell_status("", status);
}

void notify_ready(const char* status) {
  is_ready = true;
  tell_status("READY=1\n", status);
}

void notify_testing(bool testing) {
  if (watchdog_us() <= 0) return;
  char text[48];
  snprintf(text, sizeof text, "WATCHDOG_USEC=%.0f", testing ? kTestingUs : watchdog_us());
  tell(text);
}

void notify_alive(double now_us) {
  const double every_us = watchdog_us() * kShareOfWatchdog;
  if (every_us <= 0 || (last_alive_us > 0 && now_us - last_alive_us < every_us)) return;
  last_alive_us = now_us;
  char text[64];
  snprintf(text, sizeof text, "WATCHDOG=1\nEXTEND_TIMEOUT_USEC=%.0f", kTestingUs);
  tell(is_ready ? "WATCHDOG=1" : text);
}

void notify_stopping(void) { tell("STOPPING=1\nSTATUS=stopping, lights off"); }
