// Between the store's own files.
#ifndef LAMELLA_FIRMWARE_STORE_INSIDE_H
#define LAMELLA_FIRMWARE_STORE_INSIDE_H

#include "store.h"

static inline bool store_has_failed(const struct store* store) {
  return __atomic_load_n(&store->failed, __ATOMIC_ACQUIRE);
}

// With the lock held. The first reason counts.
void store_fail(struct store* store, const char* what, int error);

// The writer's thread: started where it does not run, at normal priority whoever asks.
int writer_start(struct store* store);
void writer_stop(struct store* store);
// What is queued and not yet being written is dropped.
void writer_drop_queue(struct store* store);
uint8_t* writer_room(struct store* store, size_t* room);  // with the lock held

// This id was given; for ever once the store's own folder is synced.
int store_count_burst(struct disk* disk, uint64_t burst_id);

// `rig sync` names a host's sessions as a store names its bursts: whether a rig wrote what the
// folder holds, before anything in it is touched. Else `why` names what it did not.
bool store_is_a_rigs(const struct disk* disk, char why[160]);

// Completes or explains what the folder holds, and lists it.
int store_recover(struct store* store);

#endif
