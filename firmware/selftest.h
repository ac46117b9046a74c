// Proof, part by part, that the rig does what the rig file says: each with a reading, its unit, the
// limits and a verdict. Done piece by piece, so that the rig stays within reach meanwhile.
#ifndef LAMELLA_FIRMWARE_SELFTEST_H
#define LAMELLA_FIRMWARE_SELFTEST_H

#include <stdbool.h>

#include "hal.h"
#include "led_reference.h"
#include "rig.h"
#include "selftest_chain.h"
#include "store.h"

// In the order in which they are tested: what the later ones need comes first.
enum selftest_part {
  SELFTEST_ESTOP,
  SELFTEST_TEMPERATURE,
  SELFTEST_DISK,
  SELFTEST_CHAIN,
  SELFTEST_BLANK,
  SELFTEST_ACTUATOR,
  SELFTEST_PROJECTOR,
  SELFTEST_CAMERAS,
  SELFTEST_LEDS,
  SELFTEST_LATENCY,
  SELFTEST_PARTS,
};

enum { SELFTEST_MAX_READINGS = 48, SELFTEST_WHY_CHARS = 192 };
#define SELFTEST_ALL ((1u << SELFTEST_PARTS) - 1)

enum selftest_verdict { SELFTEST_GOOD, SELFTEST_BAD, SELFTEST_SKIPPED };

struct selftest_reading {
  enum selftest_part part;
  enum selftest_verdict verdict;
  char what[48];
  double value, low, high;  // low and high are infinite where there is no limit
  char unit[12];            // "yes/no" where `value` is 1 or 0
  char note[112];           // what to do; why it was skipped
};

// What the disk says of itself: free bytes, and bytes a second of a trial. False with a reason.
struct selftest_disk {
  bool (*measure)(void* context, double* free_bytes, double* bytes_per_s, char error[112]);
  void* context;
};

struct selftest {
  // Set once.
  const struct rig* rig;
  struct hal* hal;
  struct store* store;               // lends room for one photograph at a time
  struct led_reference reference;    // not learned: LEDs are told dead or alive, no more
  const char* reference_path;        // where a learned one is kept; NULL: nowhere
  const struct selftest_disk* disk;  // NULL: photographs are kept in memory alone

  // Of all runs: what was found bad and not good since, bit by selftest_part, and of each part its
  // first bad reading in words.
  unsigned unfit;
  bool needs_full;  // LEDs are unfit by a test that was not quick: a quick one may miss why
  char why[SELFTEST_PARTS][SELFTEST_WHY_CHARS];

  // Of the run under way, or of the last one.
  unsigned parts;  // bit by selftest_part
  bool quick, learning, running;
  bool stands_crossed;  // where the analyser stands, and is left again
  enum selftest_part part;
  unsigned step;
  struct selftest_reading readings[SELFTEST_MAX_READINGS];
  size_t count, bad;

  // Of the part under way.
  double begun_us, dark_until_us;
  unsigned shots;  // since prepare()
  struct chain_trial trial;
  struct led_signature dark;
  bool suspect[CHAIN_CHIPS];  // a chip whose LEDs together were not as expected
  double brightness[RIG_MAX_LEDS];
  size_t blamed, unseen;  // LEDs
  bool heart;             // level of the heartbeat's line
  double worst_us;
};

const char* selftest_part_name(enum selftest_part part);
// The part of that name; SELFTEST_PARTS where there is none.
enum selftest_part selftest_part_named(const char* name);

void selftest_init(struct selftest* test, const struct rig* rig, struct hal* hal,
                   struct store* store);

// `quick` looks at LEDs chip by chip and at single ones only where that is not as expected;
// `learning` takes the LEDs as they are for the reference of later tests.
void selftest_begin(struct selftest* test, unsigned parts, bool quick, bool learning);

// The next piece, some ten milliseconds. False where there is nothing to do. Lights are off between
// pieces.
bool selftest_work(struct selftest* test);

// Stops a test that is under way; lights off.
void selftest_abandon(struct selftest* test);

// What the panel tells of an unfit rig: of its first unfit part.
enum lam_part selftest_failed_part(const struct selftest* test);

// What was read, and what to do, in one line.
void selftest_tell(const struct selftest_reading* reading, char text[SELFTEST_WHY_CHARS]);

// The part is unfit from now on, until a test finds it good.
void selftest_condemn(struct selftest* test, enum selftest_part part, const char* why);

// For the parts themselves. A reading between its limits is good.
struct selftest_reading* selftest_read(struct selftest* test, const char* what, double value,
                                       const char* unit);
void selftest_limit(struct selftest* test, struct selftest_reading* reading, double low,
                    double high);
void selftest_fail(struct selftest* test, const char* what, const char* note);
void selftest_skip(struct selftest* test, const char* what, const char* note);

// A part's next piece: true while there is more. `step` counts its pieces from 0.
bool selftest_estop(struct selftest* test);
bool selftest_temperature(struct selftest* test);
bool selftest_disk(struct selftest* test);
bool selftest_chain(struct selftest* test);
bool selftest_blank(struct selftest* test);
bool selftest_actuator(struct selftest* test);
bool selftest_projector(struct selftest* test);
bool selftest_cameras(struct selftest* test);
bool selftest_leds(struct selftest* test);
bool selftest_latency(struct selftest* test);

#endif
