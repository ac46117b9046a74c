// Any bytes as the files of a burst's folder, as a power cut may leave them: the first byte says
// which file, the next two how long, then its bytes. Recovery ends, and what it calls whole is.
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/store.pb.h"
#include "store.h"
#include "store_record.h"

static char folder[64];

static const char* const kFiles[] = {"begin",           "end",
                                     "timing",          "frame-00.raw",
                                     "frame-00.record", "frame-00.record.tmp",
                                     "frame-01.raw",    "frame-01.record",
                                     "frame-01.acked",  "calibration.json",
                                     "../counter"};
enum { kFileCount = sizeof kFiles / sizeof kFiles[0] };

static void path_of(const char* file, const char* suffix, char path[160]) {
  snprintf(path, 160, "%s/burst-000001%s/%s", folder, suffix, file);
}

static void clear(const char* suffix) {
  char path[160];
  for (size_t i = 0; i < kFileCount; i++) {
    path_of(kFiles[i], suffix, path);
    unlink(path);
  }
  path_of("", suffix, path);
  rmdir(path);
}

static void prepare(bool whole) {
  if (folder[0] == '\0') {
    snprintf(folder, sizeof folder, "%s/lamella-fuzz-XXXXXX",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp");
    if (mkdtemp(folder) == NULL) abort();
    stderr = fopen("/dev/null", "w");  // the fuzzer keeps its own
  }
  char path[160];
  clear("");
  clear(".partial");
  path_of("", whole ? "" : ".partial", path);
  if (mkdir(path, 0755) != 0) abort();
}

// The records alone, without a disk: whatever is accepted can be written again.
static void read_records(const uint8_t* bytes, size_t size) {
  static lamella_v1_BurstBegin begin;
  static lamella_v1_BurstEnd end;
  static lamella_v1_TimingEdges page;
  static lamella_v1_FrameOffer offer;
  uint8_t again[RECORD_MAX_BYTES * 4];
  if (record_get(lamella_v1_BurstBegin_fields, &begin, bytes, size) > 0 &&
      record_put(lamella_v1_BurstBegin_fields, &begin, again, sizeof again) == 0) {
    abort();
  }
  if (record_get(lamella_v1_BurstEnd_fields, &end, bytes, size) > 0 &&
      record_put(lamella_v1_BurstEnd_fields, &end, again, sizeof again) == 0) {
    abort();
  }
  if (record_get(lamella_v1_FrameOffer_fields, &offer, bytes, size) > 0 &&
      record_put(lamella_v1_FrameOffer_fields, &offer, again, sizeof again) == 0) {
    abort();
  }
  record_get(lamella_v1_TimingEdges_fields, &page, bytes, size);
}

static void write_files(bool whole, const uint8_t* bytes, size_t size) {
  while (size > 3) {
    const size_t length = (size_t)bytes[1] | (size_t)bytes[2] << 8;
    const size_t taken = length < size - 3 ? length : size - 3;
    char path[160];
    path_of(kFiles[bytes[0] % kFileCount], whole ? "" : ".partial", path);
    FILE* file = fopen(path, "wb");
    if (file == NULL || fwrite(bytes + 3, 1, taken, file) != taken) abort();
    fclose(file);
    bytes += 3 + taken;
    size -= 3 + taken;
  }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static struct store store;
  static uint8_t block[16];
  static lamella_v1_TimingEdges page;
  lamella_v1_FrameOffer offer;
  char why[200];
  if (size < 1) return 0;
  read_records(bytes, size);
  prepare(bytes[0] & 1);
  write_files(bytes[0] & 1, bytes + 1, size - 1);
  store_init(&store, block, sizeof block);
  if (store_open(&store, folder, block, 0, why, sizeof why) != LAM_OK) abort();
  for (size_t i = 0; i < store.burst_count; i++) {
    const struct held_burst* burst = &store.bursts[i];
    if (burst->whole != (burst->why[0] == '\0')) abort();
    burst_get_timing(&store.disk, burst, bytes[0], &page);
    for (uint32_t k = 0; k < STORE_MAX_PHOTOGRAPHS; k++) {
      if (burst->frames[k] != FRAME_HELD) continue;
      if (!burst_get_offer(&store.disk, burst, k, &offer)) abort();
      store_read(&store, burst->id, k, bytes[0], block, sizeof block);
    }
  }
  store_close(&store);
  return 0;
}
