// The rig's half of pairing (proto/pair.proto): one host at a time, while somebody at the rig holds
// START. No sockets, no clock and no lines here: messages, times and the button come from outside.
//
// The rig draws a code of five digits, 1 to 6, and blinks it. Whoever sees the rig types it into
// the host. Digit by digit both ends then prove that they know it: each commits itself to the digit
// together with a nonce, the TLS channel and both fingerprints, and opens that once the other is
// committed too. A man in the middle has two channels, so he must commit himself to each digit
// before he can know it: he gets as far as learning the last one once in 6^4 attempts, each of
// which needs somebody to hold the button, and else is found out by whichever end he guessed for.
#ifndef LAMELLA_FIRMWARE_LINK_PAIR_H
#define LAMELLA_FIRMWARE_LINK_PAIR_H

#include "link_tls.h"
#include "link_trust.h"
#include "proto/pair.pb.h"

enum { PAIR_PROTOCOL_VERSION = 1, PAIR_DIGITS = 5, PAIR_NONCE_BYTES = 32, PAIR_HASH_BYTES = 32 };

enum pair_phase {
  PAIR_IDLE,
  PAIR_GREETED,
  PAIR_AWAITS_BUTTON,
  PAIR_AWAITS_COMMIT,
  PAIR_AWAITS_REVEAL
};

struct pair {
  // Set once.
  struct trust* trust;
  uint8_t rig_fingerprint[FINGERPRINT_BYTES];
  char rig_name[TRUST_NAME_CHARS];
  bool (*send)(void* context, const lamella_v1_PairReply* reply);  // false: the host is gone
  void* context;

  // Of the host that is being paired.
  enum pair_phase phase;
  struct link_peer host;
  char host_name[TRUST_NAME_CHARS];
  double now_us, ends_us, pressed_us, shown_us;  // pressed_us: since when; 0: not pressed
  uint8_t digits[PAIR_DIGITS];
  unsigned digit;  // that is being proved
  uint8_t commitment[PAIR_HASH_BYTES], nonce[PAIR_NONCE_BYTES];
  bool is_busy;  // edges are played, or are about to be

  // Of all of them: attempts that are left for now.
  double attempts, counted_us;
};

void pair_init(struct pair* pair, struct trust* trust, const struct identity* identity,
               const char* rig_name);

// A connection that came to be paired. Ends what another one had begun.
void pair_begin(struct pair* pair, const struct link_peer* host, double now_us);
void pair_end(struct pair* pair);

// False where the connection is to be closed; the host has been told why.
bool pair_answer(struct pair* pair, const uint8_t* message, size_t length, double now_us);

// To be called every 50 ms or so: the button, and the end of the host's time. False as above.
bool pair_tick(struct pair* pair, bool start_pressed, double now_us);

// The code, for the ready light and the buzzer: each digit as so many blinks. False: not shown.
bool pair_is_showing(const struct pair* pair);
bool pair_light(const struct pair* pair, double now_us);

// What binds `is_rig`'s side to one digit.
void pair_commitment(const struct pair* pair, bool is_rig, const uint8_t nonce[PAIR_NONCE_BYTES],
                     uint8_t commitment[PAIR_HASH_BYTES]);

#endif
