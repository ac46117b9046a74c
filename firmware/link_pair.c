#include "link_pair.h"

#include <math.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>
#include <pb_decode.h>
#include <stdio.h>
#include <string.h>

#include "complain.h"

#define CODE(name) lamella_v1_PairRefusal_Code_##name

static const char kCommitLabel[] = "lamella pair commitment 1";
static const double kHoldUs = 1e6;       // no press by chance
static const double kGreetUs = 10e6;     // a host says at once what it came for
static const double kWindowUs = 120e6;   // to read the code and type it
static const double kLongestWaitS = 60;  // for the button
static const double kMostAttempts = 6, kAttemptEveryUs = 10e6;
static const double kBlinkUs = 500e3, kBetweenDigitsUs = 1e6, kBetweenCodesUs = 2.5e6;

// What is not printable ASCII a host would not show; cut in its middle it would be no text at all.
static void name_rig(char to[TRUST_NAME_CHARS], const char* name) {
  snprintf(to, TRUST_NAME_CHARS, "%s", name);
  for (char* c = to; *c != '\0'; c++) {
    if (*c < 0x20 || *c > 0x7e) *c = '_';
  }
}

void pair_init(struct pair* pair, struct trust* trust, const struct identity* identity,
               const char* rig_name) {
  memset(pair, 0, sizeof *pair);
  pair->trust = trust;
  memcpy(pair->rig_fingerprint, identity->fingerprint, FINGERPRINT_BYTES);
  name_rig(pair->rig_name, rig_name);
  pair->attempts = kMostAttempts;
}

void pair_begin(struct pair* pair, const struct link_peer* host, double now_us) {
  pair_end(pair);
  pair->host = *host;
  pair->phase = PAIR_GREETED;
  pair->now_us = now_us;
  pair->ends_us = now_us + kGreetUs;
}

void pair_end(struct pair* pair) {
  pair->phase = PAIR_IDLE;
  pair->pressed_us = 0;
  OPENSSL_cleanse(pair->digits, sizeof pair->digits);
  OPENSSL_cleanse(pair->nonce, sizeof pair->nonce);
}

static bool refuse(struct pair* pair, lamella_v1_PairRefusal_Code code, const char* reason) {
  lamella_v1_PairReply reply = {.which_body = lamella_v1_PairReply_refusal_tag};
  reply.body.refusal.code = code;
  snprintf(reply.body.refusal.reason, sizeof reply.body.refusal.reason, "%s", reason);
  complain("lamella-rigd: pairing refused: %s", reason);
  pair->send(pair->context, &reply);
  pair_end(pair);
  return false;
}

// A bucket of attempts that fills again with time.
static bool take_attempt(struct pair* pair) {
  const double grown = pair->attempts + (pair->now_us - pair->counted_us) / kAttemptEveryUs;
  pair->attempts = fmin(kMostAttempts, grown);
  pair->counted_us = pair->now_us;
  if (pair->attempts < 1) return false;
  pair->attempts -= 1;
  return true;
}

static bool answer_open(struct pair* pair, const lamella_v1_PairOpen* open) {
  if (pair->phase != PAIR_GREETED) return refuse(pair, CODE(BAD_REQUEST), "opened already");
  if (open->protocol_version != PAIR_PROTOCOL_VERSION) {
    return refuse(pair, CODE(VERSION), "this rig pairs by version 1");
  }
  if (!take_attempt(pair)) {
    return refuse(pair, CODE(TOO_OFTEN), "too many attempts to pair: wait a minute");
  }
  if (pair->is_busy) return refuse(pair, CODE(BUSY), "a burst is under way");
  snprintf(pair->host_name, sizeof pair->host_name, "%s", open->host_name);
  const double wait_s = open->wait_s > 0 ? fmin(open->wait_s, kLongestWaitS) : 0;
  pair->ends_us = pair->now_us + wait_s * 1e6;
  pair->phase = PAIR_AWAITS_BUTTON;
  return true;
}

// Each of 1 to 6 as likely as the others.
static bool draw_code(uint8_t digits[PAIR_DIGITS]) {
  for (int i = 0; i < PAIR_DIGITS;) {
    uint8_t byte = 0;
    if (RAND_bytes(&byte, 1) != 1) return false;
    if (byte < 252) digits[i++] = (uint8_t)(1 + byte % 6);
  }
  return true;
}

static bool show_code(struct pair* pair) {
  if (!draw_code(pair->digits)) return refuse(pair, CODE(STORE), "the rig has no random numbers");
  pair->digit = 0;
  pair->shown_us = pair->now_us;
  pair->ends_us = pair->now_us + kWindowUs;
  pair->phase = PAIR_AWAITS_COMMIT;
  char code[PAIR_DIGITS + 1] = "";
  for (int i = 0; i < PAIR_DIGITS; i++) code[i] = (char)('0' + pair->digits[i]);
  complain("lamella-rigd: START is held: the code for the host that wants to pair is %s", code);
  lamella_v1_PairReply reply = {.which_body = lamella_v1_PairReply_ready_tag};
  snprintf(reply.body.ready.rig_name, sizeof reply.body.ready.rig_name, "%s", pair->rig_name);
  return pair->send(pair->context, &reply);
}

bool pair_tick(struct pair* pair, bool start_pressed, double now_us) {
  if (pair->phase == PAIR_IDLE) return true;
  pair->now_us = now_us;
  if (!start_pressed) pair->pressed_us = 0;
  if (start_pressed && pair->pressed_us == 0) pair->pressed_us = now_us;
  if (pair->phase != PAIR_AWAITS_BUTTON) {
    return now_us < pair->ends_us || refuse(pair, CODE(LATE), "the time to pair is over");
  }
  if (pair->is_busy) return refuse(pair, CODE(BUSY), "a burst is under way");
  if (start_pressed && now_us - pair->pressed_us >= kHoldUs) return show_code(pair);
  if (start_pressed || now_us < pair->ends_us) return true;
  return refuse(pair, CODE(BUTTON), "START is not held: hold it until the light blinks");
}

void pair_commitment(const struct pair* pair, bool is_rig, const uint8_t nonce[PAIR_NONCE_BYTES],
                     uint8_t commitment[PAIR_HASH_BYTES]) {
  const uint8_t what[3] = {is_rig, (uint8_t)pair->digit, pair->digits[pair->digit]};
  EVP_MD_CTX* hash = EVP_MD_CTX_new();
  const bool done = hash != NULL && EVP_DigestInit_ex(hash, EVP_sha256(), NULL) &&
                    EVP_DigestUpdate(hash, kCommitLabel, sizeof kCommitLabel) &&
                    EVP_DigestUpdate(hash, what, sizeof what) &&
                    EVP_DigestUpdate(hash, nonce, PAIR_NONCE_BYTES) &&
                    EVP_DigestUpdate(hash, pair->host.channel, CHANNEL_BYTES) &&
                    EVP_DigestUpdate(hash, pair->host.fingerprint, FINGERPRINT_BYTES) &&
                    EVP_DigestUpdate(hash, pair->rig_fingerprint, FINGERPRINT_BYTES) &&
                    EVP_DigestFinal_ex(hash, commitment, NULL);
  // Without a hash nobody may agree with us.
  if (!done) RAND_bytes(commitment, PAIR_HASH_BYTES);
  EVP_MD_CTX_free(hash);
}

static bool answer_commit(struct pair* pair, const lamella_v1_PairCommit* commit) {
  if (pair->phase != PAIR_AWAITS_COMMIT || commit->commitment.size != PAIR_HASH_BYTES) {
    return refuse(pair, CODE(BAD_REQUEST), "no commitment is due, or it is not 32 bytes");
  }
  if (RAND_bytes(pair->nonce, PAIR_NONCE_BYTES) != 1) {
    return refuse(pair, CODE(STORE), "the rig has no random numbers");
  }
  memcpy(pair->commitment, commit->commitment.bytes, PAIR_HASH_BYTES);
  pair->phase = PAIR_AWAITS_REVEAL;
  lamella_v1_PairReply reply = {.which_body = lamella_v1_PairReply_commit_tag};
  reply.body.commit.commitment.size = PAIR_HASH_BYTES;
  pair_commitment(pair, true, pair->nonce, reply.body.commit.commitment.bytes);
  return pair->send(pair->context, &reply);
}

static bool let_in(struct pair* pair) {
  char error[LINK_FILE_PATH_CHARS + 64];
  const enum lam_status status =
      trust_add(pair->trust, pair->host.fingerprint, pair->host_name, error, sizeof error);
  if (status == LAM_STORE_FULL) {
    return refuse(pair, CODE(FULL), "the rig is paired with 16 hosts: let one forget it");
  }
  if (status != LAM_OK) {
    complain("lamella-rigd: %s", error);
    return refuse(pair, CODE(STORE), "the rig could not write down that this host is paired");
  }
  complain("lamella-rigd: paired with a host");
  return true;
}

static bool answer_reveal(struct pair* pair, const lamella_v1_PairReveal* reveal) {
  if (pair->phase != PAIR_AWAITS_REVEAL || reveal->nonce.size != PAIR_NONCE_BYTES) {
    return refuse(pair, CODE(BAD_REQUEST), "no nonce is due, or it is not 32 bytes");
  }
  uint8_t expected[PAIR_HASH_BYTES];
  pair_commitment(pair, false, reveal->nonce.bytes, expected);
  if (CRYPTO_memcmp(expected, pair->commitment, PAIR_HASH_BYTES) != 0) {
    return refuse(pair, CODE(WRONG_CODE),
                  "the code is not the one that the rig blinks, or somebody is in between");
  }
  const bool last = pair->digit + 1 == PAIR_DIGITS;
  if (last && !let_in(pair)) return false;
  lamella_v1_PairReply reply = {.which_body = lamella_v1_PairReply_reveal_tag};
  reply.body.reveal.nonce.size = PAIR_NONCE_BYTES;
  memcpy(reply.body.reveal.nonce.bytes, pair->nonce, PAIR_NONCE_BYTES);
  const bool sent = pair->send(pair->context, &reply);
  pair->digit++;
  pair->phase = PAIR_AWAITS_COMMIT;
  if (last) pair_end(pair);
  return sent && !last;
}

// Whoever holds a key may have it forgotten; nobody can do so for another.
static bool answer_forget(struct pair* pair) {
  char error[LINK_FILE_PATH_CHARS + 64];
  lamella_v1_PairReply reply = {.which_body = lamella_v1_PairReply_forgotten_tag};
  reply.body.forgotten.knew = trust_knows(pair->trust, pair->host.fingerprint);
  if (trust_remove(pair->trust, pair->host.fingerprint, error, sizeof error) != LAM_OK) {
    complain("lamella-rigd: %s", error);
    return refuse(pair, CODE(STORE), "the rig could not write down that this host is forgotten");
  }
  pair->send(pair->context, &reply);
  pair_end(pair);
  return false;
}

bool pair_answer(struct pair* pair, const uint8_t* message, size_t length, double now_us) {
  lamella_v1_PairRequest request;
  pair->now_us = now_us;
  pb_istream_t stream = pb_istream_from_buffer(message, length);
  if (!pb_decode(&stream, lamella_v1_PairRequest_fields, &request)) {
    return refuse(pair, CODE(BAD_REQUEST), "not a request to pair, or a field is too long");
  }
  switch (request.which_body) {
    case lamella_v1_PairRequest_open_tag:
      return answer_open(pair, &request.body.open);
    case lamella_v1_PairRequest_commit_tag:
      return answer_commit(pair, &request.body.commit);
    case lamella_v1_PairRequest_reveal_tag:
      return answer_reveal(pair, &request.body.reveal);
    case lamella_v1_PairRequest_forget_tag:
      return answer_forget(pair);
    default:
      return refuse(pair, CODE(BAD_REQUEST), "a request that this rig does not know");
  }
}

bool pair_is_showing(const struct pair* pair) {
  return pair->phase == PAIR_AWAITS_COMMIT || pair->phase == PAIR_AWAITS_REVEAL;
}

bool pair_light(const struct pair* pair, double now_us) {
  double length_us = kBetweenCodesUs;
  for (int i = 0; i < PAIR_DIGITS; i++) length_us += pair->digits[i] * kBlinkUs + kBetweenDigitsUs;
  double t_us = fmod(now_us - pair->shown_us, length_us) - kBetweenDigitsUs;
  for (int i = 0; i < PAIR_DIGITS && t_us >= 0; i++) {
    const double digit_us = pair->digits[i] * kBlinkUs;
    if (t_us < digit_us) return fmod(t_us, kBlinkUs) < kBlinkUs / 2;
    t_us -= digit_us + kBetweenDigitsUs;
  }
  return false;
}
