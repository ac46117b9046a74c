// A burst as it is taken: its takes, each a timeline planned and played, and the shots of them all,
// counted on from take to take. The first take is of every step; later ones repeat what went wrong.
#ifndef LAMELLA_FIRMWARE_ROLL_H
#define LAMELLA_FIRMWARE_ROLL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "burst.h"
#include "player.h"
#include "proto/link.pb.h"
#include "rig.h"
#include "timeline.h"

// A shot is two photographs, and a store holds 64.
enum { ROLL_MAX_TAKES = 3, ROLL_MAX_SHOTS = 32 };

struct take {
  struct burst_plan plan;
  struct timeline timeline;
  struct player player;
  size_t first_shot;  // shots of a take are numbered in the order of its plan
};

struct shot {
  uint8_t take, step;  // which step of which take
  uint8_t place;       // the step of the first take that it is, or repeats
  bool dropped;        // a camera took no photograph
  bool bad;            // that, or an edge was played beyond its tolerance
  int replaced_by;     // the shot that repeats it; -1: none
};

struct roll {
  const struct rig* rig;
  size_t take_count, shot_count;
  struct take takes[ROLL_MAX_TAKES];
  struct shot shots[ROLL_MAX_SHOTS];
};

void roll_begin(struct roll* roll, const struct rig* rig);

// Adds a take that is about to be played; there must be room. Its shots replace nothing yet.
struct take* roll_add_take(struct roll* roll, const struct burst_plan* plan,
                           const struct timeline* timeline);

// Takes the newest one back: not an edge of it was played.
void roll_withdraw_take(struct roll* roll);

struct take* roll_newest_take(struct roll* roll);

// The newest take has been played: its shots replace those of the same places before them.
void roll_replace(struct roll* roll);

// Which shots are bad, from what is known by now.
void roll_judge(struct roll* roll);

// A step of the take, or the take itself, on the burst's own clock: since the first take's zero.
double roll_zero_us(const struct roll* roll, size_t take);
double roll_open_us(const struct roll* roll, const struct shot* shot);

size_t roll_edge_count(const struct roll* roll);
size_t roll_late_count(const struct roll* roll);

// Edge number `index` of the burst, as planned and as it happened. Edges that a take did not come
// to are as late as they are.
void roll_describe_edge(const struct roll* roll, size_t index, lamella_v1_TimedEdge* timed);

// What the photograph that a shot took with one camera is of, and when it really happened. Its
// edges must all have been played.
void roll_describe_frame(const struct roll* roll, size_t shot, unsigned camera,
                         lamella_v1_Frame* frame);

#endif
