#include "link_selftest.h"

#include <math.h>
#include <stdio.h>

#define VERDICT(name) lamella_v1_SelftestReading_Verdict_##name

static void describe(const struct selftest_reading* from, lamella_v1_SelftestReading* to) {
  static const lamella_v1_SelftestReading_Verdict kVerdicts[] = {
      [SELFTEST_GOOD] = VERDICT(GOOD),
      [SELFTEST_BAD] = VERDICT(BAD),
      [SELFTEST_SKIPPED] = VERDICT(SKIPPED),
  };
  snprintf(to->part, sizeof to->part, "%s", selftest_part_name(from->part));
  snprintf(to->what, sizeof to->what, "%s", from->what);
  snprintf(to->unit, sizeof to->unit, "%s", from->unit);
  snprintf(to->note, sizeof to->note, "%s", from->note);
  to->verdict = kVerdicts[from->verdict];
  to->has_value = isfinite(from->value);
  to->has_low = isfinite(from->low);
  to->has_high = isfinite(from->high);
  to->value = to->has_value ? from->value : 0;
  to->low = to->has_low ? from->low : 0;
  to->high = to->has_high ? from->high : 0;
}

static bool send_result(struct dialogue* dialogue, uint32_t id) {
  const struct selftest* test = dialogue->alone->selftest;
  lamella_v1_SelftestResult* result =
      &link_begin(dialogue, id, lamella_v1_Reply_selftest_tag)->body.selftest;
  result->running = dialogue->alone->state == STANDALONE_TESTING;
  result->bad = (uint32_t)test->bad;
  for (size_t i = 0; i < test->count; i++) {
    describe(&test->readings[i], &result->readings[result->readings_count++]);
  }
  return link_send(dialogue);
}

// SELFTEST_PARTS bits; 0 where a part has a name that none has.
static unsigned parts_of(const lamella_v1_SelftestRequest* request) {
  if (request->only_count == 0) return SELFTEST_ALL;
  unsigned parts = 0;
  for (pb_size_t i = 0; i < request->only_count; i++) {
    const enum selftest_part part = selftest_part_named(request->only[i]);
    if (part == SELFTEST_PARTS) return 0;
    parts |= 1u << part;
  }
  return parts;
}

bool link_answer_selftest(struct dialogue* dialogue, uint32_t id,
                          const lamella_v1_SelftestRequest* request) {
  if (dialogue->alone == NULL) {
    return link_refuse(dialogue, id, lamella_v1_Refusal_Code_NOT_FOUND,
                       "this rig cannot test itself");
  }
  if (request->report) return send_result(dialogue, id);
  const unsigned parts = parts_of(request);
  if (parts == 0) {
    return link_refuse(
        dialogue, id, lamella_v1_Refusal_Code_BAD_REQUEST,
        "parts are chain, blank, leds, actuator, cameras, projector, disk, temperature, "
        "estop, latency");
  }
  const char* why = NULL;
  if (standalone_request_selftest(dialogue->alone, parts, request->learn, &why) != LAM_OK) {
    return link_refuse(dialogue, id, lamella_v1_Refusal_Code_WRONG_STATE, why);
  }
  return send_result(dialogue, id);
}
