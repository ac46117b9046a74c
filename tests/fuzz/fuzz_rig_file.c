// Any text as a rig file and, behind a byte of 0, its list of LEDs: both are read whole or refused
// with a line of text for each mistake, and a rig that is read compiles into a burst that the
// safety check understands.
#include <stdlib.h>
#include <string.h>

#include "burst.h"
#include "rig.h"
#include "safety.h"

static void require_reasons(const struct rig_errors* errors) {
  if (errors->count == 0) abort();
  for (size_t i = 0; i < errors->count && i < RIG_MAX_ERRORS; i++) {
    const char* text = errors->list[i].text;
    if (text[0] == '\0' || strlen(text) >= sizeof errors->list[i].text) abort();
  }
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static struct rig rig;
  static struct rig_errors errors;
  const char* text = (const char*)bytes;
  const char* end = memchr(text, '\0', size);
  const size_t length = end != NULL ? (size_t)(end - text) : size;
  const size_t rest = size - length;
  enum lam_status status = rig_parse(text, length, &rig, &errors);
  if (status == LAM_OK) {
    status = rig_parse_leds(rest > 0 ? end + 1 : "", rest > 0 ? rest - 1 : 0, &rig, &errors);
  }
  if (status != LAM_OK) {
    require_reasons(&errors);
    return 0;
  }
  static struct burst_plan plan;
  static struct timeline timeline;
  struct safety_finding finding;
  plan.count = BURST_STEPS;
  memcpy(plan.steps, kBurstSteps, sizeof kBurstSteps);
  burst_time(&rig, &plan);
  timeline_build(&rig, &plan, &timeline);
  if (safety_check(&rig, &timeline, &finding) == LAM_OK) abort();  // table order moves it often
  return 0;
}
