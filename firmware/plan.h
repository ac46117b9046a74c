// A burst planned for a rig file, described for people: order, times, waits, budget.
#ifndef LAMELLA_FIRMWARE_PLAN_H
#define LAMELLA_FIRMWARE_PLAN_H

#include "proto/plan.pb.h"
#include "rig.h"
#include "status.h"

// Plans the twenty steps from where the analyser parks. LAM_UNSAFE, with plan->refusal, where the
// rig would not play it; the plan is described all the same.
enum lam_status plan_describe(const struct rig* rig, lamella_v1_Plan* plan);

#endif
