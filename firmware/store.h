// The photographs of bursts, from the sensor until a host has acknowledged them. In memory alone
// (the newest burst, in one block sized once), or, after store_open(), on a disk: then the block
// holds what the disk has not taken yet, and every burst stays until it is acknowledged.
//
//   store_begin --> store_room, store_keep ... --> store_end
//
// store_room and store_keep may be called by one other thread; everything else by one. A thread of
// the store's own writes to the disk.
#ifndef LAMELLA_FIRMWARE_STORE_H
#define LAMELLA_FIRMWARE_STORE_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/link.pb.h"
#include "status.h"
#include "store_burst.h"

enum { STORE_MAX_BURSTS = 128, STORE_MAX_TIMING_BYTES = 1 << 17 };

struct photograph {
  uint32_t frame_id;
  lamella_v1_Frame frame;
  uint32_t width, height, crc32c;
  const uint8_t* bytes;  // NULL once it is on disk and no longer in memory
  size_t size;
  bool marked, acknowledged;
};

struct store {
  uint8_t* block;
  size_t capacity, used;  // on disk a ring: `used` is where the next photograph goes
  struct photograph photographs[STORE_MAX_PHOTOGRAPHS];
  size_t count;
  uint64_t last_burst_id;
  char fault[128];
  bool failed;  // `fault` is written; read and set as an atomic
  // On disk alone:
  bool on_disk;
  struct disk disk;
  const uint8_t* calibration;
  size_t calibration_size;
  struct held_burst bursts[STORE_MAX_BURSTS];  // by id, rising
  size_t burst_count;
  struct held_burst current;  // under way; one of `bursts` after its end
  bool is_open;
  int reading;  // the photograph that is being sent; -1: none
  uint64_t reading_burst;
  uint32_t reading_frame;
  pthread_mutex_t lock;  // the block, photographs, current
  pthread_cond_t moved;
  pthread_t writer;
  bool writer_runs, stopping, writing;
  size_t written;  // photographs that left memory
  size_t wanted;   // room that the next photograph will need
  uint8_t* place;  // what store_room() gave, until store_keep(); NULL: nothing
  size_t place_room;
  int avoid_cpu;  // the sequencer's, where the writer must not run; -1: none
};

// What a burst will bring.
struct store_order {
  uint32_t frames;
  double frame_bytes;  // of one, as the rig file says
  bool discard_held;   // in memory alone: give up photographs that nobody acknowledged
  bool flashing_confirmed;
  const char* subject;  // NULL: nobody named one
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

// Bursts are kept in `folder` from now on. Whatever an earlier end, good or bad, left there is
// completed or explained first, a line on stderr each. `calibration` goes with every burst. Where
// it fails `why` is one line.
enum lam_status store_open(struct store* store, const char* folder, const uint8_t* calibration,
                           size_t calibration_size, char* why, size_t why_size);
// Stops the writer; a burst under way is left plainly partial.
void store_close(struct store* store);

// Gives the burst an id that no other ever had. LAM_WRONG_STATE where photographs are held that
// would be lost, LAM_STORE_FULL where the disk has no room for a whole burst, LAM_HARDWARE where it
// does not take one; `why` is one line then.
enum lam_status store_begin(struct store* store, const struct store_order* order,
                            uint64_t* burst_id, char* why, size_t why_size);

// What a disk must have free for so many photographs, and what is kept beside them.
double store_needed_bytes(double frames, double frame_bytes);

// Whether the disk has room for more photographs than the burst was begun for. In memory alone that
// is the budget's to say (budget.h).
bool store_has_room(struct store* store, uint32_t frames, double frame_bytes);

// Where the next photograph's bytes go. On disk it waits until the disk has taken enough.
uint8_t* store_room(struct store* store, size_t* room);
// Keeps a photograph whose `size` bytes were put there. False where there is no place for it:
// store_fault() says why. On disk it is queued: store_held() counts it once it is on the disk.
bool store_keep(struct store* store, const struct photograph* photograph);

// True where nothing is left to be written, or nothing more can be; waits for it up to `wait_ms`.
bool store_is_written(struct store* store, unsigned wait_ms);

// What became clear about a photograph after it was kept, once everything is written: it is bad,
// or taken again by the shot `replaced_by` (-1: by none).
void store_mark(struct store* store, uint32_t frame_id, bool bad, int replaced_by);

// In memory a burst that is not whole is forgotten. On disk it stays, with what the disk has of it
// and the reason; a whole one is whole on disk when this returns LAM_OK.
enum lam_status store_end(struct store* store, const struct store_ending* ending);

// Why photographs can be kept no longer, in one line; "" while they can. Any thread may ask.
const char* store_fault(const struct store* store);

// NULL where there is none, or it is acknowledged. In memory alone.
struct photograph* store_find(struct store* store, uint32_t frame_id);
// Of the newest burst: kept (on disk: there) and not yet acknowledged.
size_t store_held(struct store* store);

// For the self-test, between bursts: free bytes, and how fast some megabytes reached the disk.
// False, with a reason, where the disk does not take them.
bool store_measure(void* store, double* free_bytes, double* bytes_per_s, char error[112]);

// Bursts of which photographs or an explanation are held.
uint32_t store_bursts_held(struct store* store);

// What is on disk. NULL where no such burst is held, or it is under way.
const struct held_burst* store_find_burst(const struct store* store, uint64_t burst_id);
// LAM_OK: as far as this disk is concerned it never comes back. The burst goes with its last
// photograph.
enum lam_status store_acknowledge(struct store* store, uint64_t burst_id, uint32_t frame_id);
// A burst without photographs. LAM_WRONG_STATE while it has some.
enum lam_status store_release(struct store* store, uint64_t burst_id);
// Bytes of a photograph held; 0 where it is not.
size_t store_size(struct store* store, uint64_t burst_id, uint32_t frame_id);
// Some bytes of a photograph held; how many, 0 where there are none (left).
size_t store_read(struct store* store, uint64_t burst_id, uint32_t frame_id, size_t offset,
                  uint8_t* to, size_t room);

#endif
