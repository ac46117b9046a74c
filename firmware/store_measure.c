// How the rig's disk is: room, and speed in a trial.
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "store_inside.h"

enum { kTrialBytes = 8 << 20 };
static const char kTrial[] = "trial", kUnfinished[] = "trial.tmp";

static double now_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

bool store_measure(void* context, double* free_bytes, double* bytes_per_s, char error[112]) {
  struct store* store = context;
  *free_bytes = (double)disk_free_bytes(&store->disk);
  size_t size = store->capacity < kTrialBytes ? store->capacity : kTrialBytes;
  if ((double)size > *free_bytes / 2) size = (size_t)(*free_bytes / 2);
  // Nothing that a disk could pack, and nothing of ours. Between bursts no photograph lies there.
  for (size_t i = 0; i < size; i++) store->block[i] = (uint8_t)(i * 2654435761u >> 24);
  const double begun_s = now_s();
  const int failed = disk_write_whole(&store->disk, kTrial, store->block, size);
  *bytes_per_s = (double)size / (now_s() - begun_s);
  if (failed != 0) disk_remove(&store->disk, kUnfinished);
  const int left = failed != 0 ? failed : disk_remove(&store->disk, kTrial);
  if (left != 0) snprintf(error, 112, "a trial of %zu bytes: %.76s", size, disk_explain(left));
  return left == 0;
}
