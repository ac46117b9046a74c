// The order found is the best there is on small sets, and near what no order can beat on all
// twenty.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "test_rig.h"

extern "C" {
#include "burst_bound.h"
}

namespace {

using Steps = std::vector<burst_step>;

// Different steps of the paper's twenty; some have their partner among them, some have not.
Steps drawn(size_t count, std::mt19937* random) {
  Steps steps(kBurstSteps, kBurstSteps + BURST_STEPS);
  std::shuffle(steps.begin(), steps.end(), *random);
  steps.resize(count);
  return steps;
}

// Every order of one side of the move: the other side follows from the mirror only in its pairs.
struct Exhaustive {
  const struct rig& rig;
  const Steps& steps;
  bool starts_crossed;
  burst_plan plan = {};
  std::vector<bool> used = std::vector<bool>(steps.size());
  std::vector<size_t> begun;
  double best_us = INFINITY;

  bool side_is_done(bool crossed) const {
    for (size_t i = 0; i < steps.size(); i++) {
      if (!used[i] && steps[i].crossed == crossed) return false;
    }
    return true;
  }

  void search() {
    if (plan.count == steps.size()) {
      burst_time(&rig, &plan);
      best_us = std::min(best_us, plan.cost_us);
      return;
    }
    for (size_t i = 0; i < steps.size(); i++) {
      if (!used[i]) try_step(i);
    }
  }

  void try_step(size_t i) {
    const bool first_side = steps[i].crossed == starts_crossed;
    if (!first_side && !side_is_done(starts_crossed)) return;
    const size_t partner = burst_partner(steps.data(), steps.size(), i);
    const bool paired = partner < steps.size();
    if (paired && !first_side && begun.back() != partner) return;  // mirrored about the move
    if (paired) first_side ? begun.push_back(i) : begun.pop_back();
    used[i] = true;
    plan.steps[plan.count++] = steps[i];
    search();
    plan.count--;
    used[i] = false;
    if (paired) first_side ? begun.pop_back() : begun.push_back(partner);
  }
};

double cheapest_of_all_orders(const struct rig& rig, const Steps& steps, bool starts_crossed) {
  Exhaustive all{.rig = rig, .steps = steps, .starts_crossed = starts_crossed, .begun = {}};
  all.plan.starts_crossed = starts_crossed;
  all.search();
  return all.best_us;
}

const char* const kRigs[] = {"slr", "machine_vision", "sim"};

}  // namespace

TEST(BurstBound, TheOrderCostsWhatAnExhaustiveSearchOfUpToNineRandomStepsFinds) {
  std::mt19937 random(20261125);
  for (const char* name : kRigs) {
    const struct rig rig = test_rig(name);
    for (size_t count = 2; count <= 9; count++) {
      for (int set = 0; set < (count < 9 ? 4 : 2); set++) {
        const Steps steps = drawn(count, &random);
        const bool starts_crossed = set % 2 == 1;
        const double best_us = cheapest_of_all_orders(rig, steps, starts_crossed);
        EXPECT_NEAR(planned(rig, steps, starts_crossed).cost_us, best_us, 1e-3)
            << name << ", " << count << " steps, set " << set;
        const auto bound = burst_bound(&rig, steps.data(), count, starts_crossed);
        EXPECT_LE(bound.cost_us, best_us + 1e-3) << name << ", " << count << " steps, set " << set;
      }
    }
  }
}

TEST(BurstBound, LiesBelowEveryOrderOfTwentyThatIsTried) {
  std::mt19937 random(7);
  for (const char* name : kRigs) {
    const struct rig rig = test_rig(name);
    const auto bound = burst_bound(&rig, kBurstSteps, BURST_STEPS, false);
    burst_plan plan = planned(rig, Steps(kBurstSteps, kBurstSteps + BURST_STEPS), false);
    for (int i = 0; i < 200; i++) {
      const auto middle = std::stable_partition(plan.steps, plan.steps + BURST_STEPS,
                                                [](const burst_step& s) { return !s.crossed; });
      std::shuffle(plan.steps, middle, random);
      std::shuffle(middle, plan.steps + BURST_STEPS, random);
      burst_time(&rig, &plan);
      EXPECT_GE(plan.duration_us, bound.duration_us - 1e-3);
      EXPECT_GE(plan.cost_us, bound.cost_us - 1e-3);
    }
  }
}

TEST(BurstBound, TheOrderOfTwentyStepsCostsAtMostSevenPercentMore) {
  for (const char* name : kRigs) {
    const struct rig rig = test_rig(name);
    for (const bool starts_crossed : {false, true}) {
      const burst_plan plan =
          planned(rig, Steps(kBurstSteps, kBurstSteps + BURST_STEPS), starts_crossed);
      const auto bound = burst_bound(&rig, kBurstSteps, BURST_STEPS, starts_crossed);
      EXPECT_LE(plan.duration_us, 1.12 * bound.duration_us) << name;
      EXPECT_LE(plan.cost_us, 1.07 * bound.cost_us) << name;
    }
  }
}

TEST(BurstBound, TheReferenceRigsKeepTheirTimes) {
  const Steps steps(kBurstSteps, kBurstSteps + BURST_STEPS);
  EXPECT_LT(planned(test_rig("machine_vision"), steps, false).duration_us, 0.79e6);
  EXPECT_LT(planned(test_rig("slr"), steps, false).duration_us, 4.65e6);
}
