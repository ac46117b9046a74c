// The photographs of a burst, from the sensor until a host has acknowledged them. Bounded: one
// block of memory, sized once.
//
//   store_begin --> store_room, store_keep ... --> store_end
#ifndef LAMELLA_FIRMWARE_STORE_H
#define LAMELLA_FIRMWARE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/link.pb.h"
#include "status.h"

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
  uint64_t last_burst_id;
  char fault[128];
};

// What a burst will bring.
struct store_order {
  uint32_t frames;
  double frame_bytes;  // of one, as the rig file says
  bool discard_held;   // give up photographs that nobody acknowledged
};

// How a burst ended.
struct store_ending {
  const char* why;            // not whole, and why; NULL: whole
  lamella_v1_BurstDone done;  // the verdict
  // Fills in edges from `first_edge` on; `total_edges` says how many there are.
  void (*timing)(const void* context, uint32_t first_edge, lamella_v1_TimingEdges* page);
  const void* context;
};

void store_init(struct store* store, uint8_t* block, size_t capacity);

// Gives the burst an id of its own. LAM_WRONG_STATE where photographs are held that would be lost;
// `why` is one line then.
enum lam_status store_begin(struct store* store, const struct store_order* order,
                            uint64_t* burst_id, char* why, size_t why_size);

// Where the next photograph's bytes go.
uint8_t* store_room(struct store* store, size_t* room);
// Keeps a photograph whose `size` bytes were put there. False where there is no place for it:
// store_fault() says why.
bool store_keep(struct store* store, const struct photograph* photograph);

// A burst that is not whole is forgotten.
enum lam_status store_end(struct store* store, const struct store_ending* ending);

// Why photographs can be kept no longer, in one line; "" while they can.
const char* store_fault(const struct store* store);

// NULL where there is none, or it is acknowledged.
struct photograph* store_find(struct store* store, uint32_t frame_id);
size_t store_held(const struct store* store);  // kept and not yet acknowledged

#endif
