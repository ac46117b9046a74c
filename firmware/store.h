// Photographs in memory until a host has acknowledged them. Bounded: one block, sized once.
#ifndef LAMELLA_FIRMWARE_STORE_H
#define LAMELLA_FIRMWARE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/session.pb.h"

enum { STORE_MAX_PHOTOGRAPHS = 64 };

struct photograph {
  uint32_t frame_id;
  lamella_v1_Frame frame;
  uint32_t width, height, crc32c;
  const uint8_t* bytes;
  size_t size;
  bool marked, acknowledged;
};

struct store {
  uint8_t* block;
  size_t capacity, used;
  struct photograph photographs[STORE_MAX_PHOTOGRAPHS];
  size_t count;
};

void store_init(struct store* store, uint8_t* block, size_t capacity);
void store_clear(struct store* store);

// Where the next photograph's bytes go.
uint8_t* store_room(struct store* store, size_t* room);
// Keeps a photograph whose `size` bytes were put there; false where there is no place for it.
bool store_keep(struct store* store, const struct photograph* photograph);

// NULL where there is none, or it is acknowledged.
struct photograph* store_find(struct store* store, uint32_t frame_id);
size_t store_held(const struct store* store);  // kept and not yet acknowledged

#endif
