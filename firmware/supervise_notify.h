// What the service manager is told (sd_notify). Without one every call does nothing. The keeper of
// the time must be the loop that plays bursts: a thread of its own would live on when that hangs.
#ifndef LAMELLA_FIRMWARE_SUPERVISE_NOTIFY_H
#define LAMELLA_FIRMWARE_SUPERVISE_NOTIFY_H

#include <stdbool.h>

// The rig serves: READY=1, and a first status.
void notify_ready(const char* status);

// One line for `systemctl status`; the same line again is not sent.
void notify_status(const char* status);

// The loop is alive. As often as one likes: WATCHDOG=1 is sent at a quarter of WatchdogSec. Before
// the rig serves it asks for more of TimeoutStartSec too: a self-test takes as long as its rig is
// large.
void notify_alive(double now_us);

// A self-test begins or is over. Meanwhile the loop may be silent for a minute in place of
// WatchdogSec: a slow disk's trial is one piece of work. The lights' other guards stay as they are.
void notify_testing(bool testing);

void notify_stopping(void);

#endif
