// Any text as a rig file: it is read whole or refused with a line of text, and a rig that is
// read compiles into a burst that the safety check understands.
#include <stdlib.h>
#include <string.h>

#include "burst.h"
#include "rig.h"
#include "safety.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static struct rig rig;
  struct rig_error error;
  if (rig_parse((const char*)bytes, size, &rig, &error) != LAM_OK) {
    if (error.text[0] == '\0' || strlen(error.text) >= sizeof error.text) abort();
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
