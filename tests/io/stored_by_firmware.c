#include "stored_by_firmware.h"

#include <stdio.h>
#include <string.h>

#include "crc32c.h"
#include "store.h"

static const uint8_t kCalibration[] = "{}";
enum { kEdges = 100 };

static void fill_timing(const void* context, uint32_t first, lamella_v1_TimingEdges* page) {
  (void)context;
  *page = (lamella_v1_TimingEdges){.first_edge = first,
                                   .total_edges = kEdges,
                                   .zero_us = 5,
                                   .has_latency = true,
                                   .latency = {.waits = 300, .lead_us = 1.5}};
  for (; first < kEdges && page->edges_count < 64; first++) {
    page->edges[page->edges_count++].planned_us = first;
  }
}

static int keep(struct store* store, uint32_t frame_id, size_t frame_bytes) {
  size_t room = 0;
  uint8_t* place = store_room(store, &room);
  if (room < frame_bytes) return 0;
  memset(place, (int)frame_id, frame_bytes);
  struct photograph photograph = {.frame_id = frame_id, .size = frame_bytes};
  photograph.crc32c = crc32c_extend(0, place, frame_bytes);
  return store_keep(store, &photograph);
}

uint64_t stored_by_firmware(const char* folder, uint32_t frames, size_t frame_bytes,
                            const char* why, uint32_t acknowledged) {
  static struct store store;
  static uint8_t block[1 << 16];
  char error[200];
  uint64_t id = 0;
  store_init(&store, block, sizeof block);
  const struct store_order order = {.frames = frames,
                                    .frame_bytes = (double)frame_bytes,
                                    .flashing_confirmed = why == NULL,
                                    .subject = why == NULL ? "Ada" : NULL};
  const struct store_ending ending = {.why = why, .timing = fill_timing};
  int good = store_open(&store, folder, kCalibration, 2, error, sizeof error) == LAM_OK &&
             store_begin(&store, &order, &id, error, sizeof error) == LAM_OK;
  for (uint32_t i = 0; good && i < frames; i++) good = keep(&store, i, frame_bytes);
  while (good && !store_is_written(&store, 1000)) continue;
  good = good && store_end(&store, &ending) == LAM_OK;
  for (uint32_t i = 0; good && i < acknowledged; i++) {
    good = store_acknowledge(&store, id, i) == LAM_OK;
  }
  store_close(&store);
  return good ? id : 0;
}

int explained_by_firmware(const char* folder, uint64_t burst_id, char why[160]) {
  static struct store store;
  char error[200];
  store_init(&store, NULL, 0);
  if (store_open(&store, folder, kCalibration, 2, error, sizeof error) != LAM_OK) return 0;
  const struct held_burst* burst = store_find_burst(&store, burst_id);
  if (burst != NULL) snprintf(why, 160, "%s", burst->why);
  const int whole = burst != NULL && burst->whole;
  store_close(&store);
  return whole;
}
