#include "store.h"

#include <stdio.h>
#include <string.h>

void store_init(struct store* store, uint8_t* block, size_t capacity) {
  memset(store, 0, sizeof *store);
  store->block = block;
  store->capacity = capacity;
}

static void forget(struct store* store) {
  store->used = 0;
  store->count = 0;
}

enum lam_status store_begin(struct store* store, const struct store_order* order,
                            uint64_t* burst_id, char* why, size_t why_size) {
  if (store_held(store) > 0 && !order->discard_held) {
    snprintf(why, why_size, "photographs of the last burst are held: acknowledge or discard them");
    return LAM_WRONG_STATE;
  }
  forget(store);
  store->fault[0] = '\0';
  *burst_id = ++store->last_burst_id;
  return LAM_OK;
}

uint8_t* store_room(struct store* store, size_t* room) {
  *room = store->count < STORE_MAX_PHOTOGRAPHS ? store->capacity - store->used : 0;
  return store->block + store->used;
}

bool store_keep(struct store* store, const struct photograph* photograph) {
  size_t room = 0;
  const uint8_t* bytes = store_room(store, &room);
  if (photograph->size > room) {
    snprintf(store->fault, sizeof store->fault,
             "the store is full: raise store.capacity_bytes in the rig file");
    return false;
  }
  struct photograph* kept = &store->photographs[store->count++];
  *kept = *photograph;
  kept->bytes = bytes;
  kept->acknowledged = false;
  store->used += photograph->size;
  return true;
}

enum lam_status store_end(struct store* store, const struct store_ending* ending) {
  if (ending->why != NULL) forget(store);
  return LAM_OK;
}

const char* store_fault(const struct store* store) { return store->fault; }

struct photograph* store_find(struct store* store, uint32_t frame_id) {
  for (size_t i = 0; i < store->count; i++) {
    struct photograph* photograph = &store->photographs[i];
    if (photograph->frame_id == frame_id && !photograph->acknowledged) return photograph;
  }
  return NULL;
}

size_t store_held(const struct store* store) {
  size_t held = 0;
  for (size_t i = 0; i < store->count; i++) held += !store->photographs[i].acknowledged;
  return held;
}
