#include "plan.h"

#include <stdio.h>
#include <string.h>

#include "budget.h"
#include "burst_bound.h"
#include "safety.h"
#include "timeline.h"

static void describe_steps(const struct rig* rig, const struct burst_plan* burst,
                           lamella_v1_Plan* plan) {
  plan->steps_count = (pb_size_t)burst->count;
  for (size_t i = 0; i < burst->count; i++) {
    const struct step_times* t = &burst->times[i];
    lamella_v1_PlannedStep* step = &plan->steps[i];
    step->role = burst->steps[i].role;
    step->index = burst->steps[i].index;
    step->analyser = burst->steps[i].crossed ? lamella_v1_Frame_Analyser_CROSS
                                             : lamella_v1_Frame_Analyser_PARALLEL;
    step->open_us = t->open_us;
    step->close_us = t->close_us;
    step->light_on_us = t->light_on_us;
    step->light_off_us = t->light_off_us;
    step->read_out_us = t->close_us + rig->camera_readout_us;
    step->wait_us = t->wait_us;
    snprintf(step->wait, sizeof step->wait, "%s", burst_wait_name(t->wait));
  }
}

static void describe_edges(const struct timeline* timeline, lamella_v1_Plan* plan) {
  plan->edges_count = (pb_size_t)timeline->count;
  for (size_t i = 0; i < timeline->count; i++) {
    const struct edge* edge = &timeline->edges[i];
    lamella_v1_TimedEdge* timed = &plan->edges[i];
    timed->planned_us = edge->t_us;
    timed->tolerance_us = edge->tolerance_us;
    timed->value = edge->value;
    timed->step = edge->step;
    snprintf(timed->line, sizeof timed->line, "%s", timeline_line_name(edge->line));
  }
}

static lamella_v1_PlanDose described_dose(const struct dose* dose) {
  return (lamella_v1_PlanDose){.blue_j_per_m2_sr = dose->blue_j_per_m2_sr,
                               .bursts_per_day = dose->bursts_per_day,
                               .thermal_share = dose->thermal_share};
}

static void describe_budget(const struct budget* budget, lamella_v1_Plan* plan) {
  plan->has_budget = true;
  plan->budget = (lamella_v1_PlanBudget){.leds_share = budget->leds_share,
                                         .projector_share = budget->projector_share,
                                         .junction_c = budget->junction_c,
                                         .frames_bytes = budget->frames_bytes,
                                         .memory_bytes = budget->memory_bytes,
                                         .flashes_per_s = budget->flashes_per_s,
                                         .has_leds_dose = true,
                                         .leds_dose = described_dose(&budget->leds_dose),
                                         .has_projector_dose = true,
                                         .projector_dose = described_dose(&budget->projector_dose)};
}

enum lam_status plan_describe(const struct rig* rig, lamella_v1_Plan* plan) {
  struct timeline timeline;
  struct burst_plan burst;
  struct budget budget;
  struct safety_finding finding;
  memset(plan, 0, sizeof *plan);
  burst_order(rig, kBurstSteps, BURST_STEPS, rig->analyser_parks_crossed, &burst);
  timeline_build(rig, &burst, &timeline);
  plan->duration_us = burst.duration_us;
  plan->cost_us = burst.cost_us;
  plan->starts_crossed = burst.starts_crossed;
  plan->trigger_active_low = rig->sensor.trigger_active_low;
  const struct burst_bound bound =
      burst_bound(rig, kBurstSteps, BURST_STEPS, rig->analyser_parks_crossed);
  plan->least_duration_us = bound.duration_us;
  plan->least_cost_us = bound.cost_us;
  describe_steps(rig, &burst, plan);
  describe_edges(&timeline, plan);
  const char* refusal = "";
  if (budget_check(rig, &burst, &budget) != LAM_OK) refusal = budget.refusal;
  if (safety_check(rig, &timeline, &finding) != LAM_OK) refusal = finding.text;
  describe_budget(&budget, plan);
  snprintf(plan->refusal, sizeof plan->refusal, "%s", refusal);
  return refusal[0] == '\0' ? LAM_OK : LAM_UNSAFE;
}
