// The kernel's monotonic clock, and what keeps the kernel from making the player late.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_TIME_H
#define LAMELLA_FIRMWARE_HAL_LINUX_TIME_H

#include "rig_linux.h"
#include "status.h"

double linux_now_us(void);

// Sleeps to spin_us before t_us and spins to it; at once where t_us has passed. Returns the time.
double linux_wait_until_us(double t_us, double spin_us);

// Pins this thread, makes it SCHED_FIFO and keeps processors out of deep sleep. What cannot be had
// is a line on stderr, and edges may come late; the count of those is returned. *latency_fd is to
// stay open for as long as timing matters; -1 where there is none.
int linux_time_settle(const struct rig_linux* board, int* latency_fd);

// How long the kernel's timer leaves this thread alone, and a moment at which it interrupted it, to
// some microseconds. Watches some ticks go by. 0 where there are none.
double linux_tick_us(double* at_us);

// Locks all memory, now and later: a page that is fetched in a burst takes milliseconds.
// LAM_HARDWARE with the reason, and with what to do, where this process may not lock so much.
enum lam_status linux_memory_lock(char error[160]);

#endif
