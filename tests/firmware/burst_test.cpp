#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "test_rig.h"

extern "C" {
#include "burst.h"
#include "led_chain.h"
}

namespace {

using Steps = std::vector<burst_step>;

int count_moves(const burst_plan& plan) {
  int moves = plan.steps[0].crossed != plan.starts_crossed;
  for (size_t i = 1; i < plan.count; i++)
    moves += plan.steps[i].crossed != plan.steps[i - 1].crossed;
  return moves;
}

// Pairs begin on one side of the move and complete, last begun first, on the other.
bool is_mirrored(const burst_plan& plan) {
  std::vector<size_t> begun;
  for (size_t i = 0; i < plan.count; i++) {
    const size_t partner = burst_partner(plan.steps, plan.count, i);
    if (partner == plan.count) continue;
    if (partner > i) {
      begun.push_back(i);
    } else if (begun.back() != partner) {
      return false;
    } else {
      begun.pop_back();
    }
  }
  return true;
}

double cheapest_of_permutations(const struct rig& rig, const Steps& steps, bool starts_crossed) {
  std::vector<size_t> order(steps.size());
  std::iota(order.begin(), order.end(), 0);
  double best = INFINITY;
  do {
    burst_plan plan = {};
    plan.count = steps.size();
    plan.starts_crossed = starts_crossed;
    for (size_t i = 0; i < order.size(); i++) plan.steps[i] = steps[order[i]];
    if (count_moves(plan) > 1 || !is_mirrored(plan)) continue;
    burst_time(&rig, &plan);
    best = std::min(best, plan.cost_us);
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

Steps paper_steps() { return Steps(kBurstSteps, kBurstSteps + BURST_STEPS); }

Steps some(std::initializer_list<int> indices) {
  Steps steps;
  for (const int i : indices) steps.push_back(kBurstSteps[i]);
  return steps;
}

}  // namespace

TEST(BurstOrder, TakesEveryStepOfTheTableOnce) {
  const burst_plan plan = planned(test_rig(), paper_steps(), false);
  ASSERT_EQ(plan.count, 20u);
  for (const burst_step& step : kBurstSteps) {
    EXPECT_EQ(std::count_if(plan.steps, plan.steps + 20,
                            [&](const burst_step& s) {
                              return s.role == step.role && s.index == step.index &&
                                     s.crossed == step.crossed;
                            }),
              1);
  }
}

TEST(BurstOrder, MovesTheActuatorOnceAndMirrorsPairsAboutIt) {
  for (const bool starts_crossed : {false, true}) {
    const burst_plan plan = planned(test_rig(), paper_steps(), starts_crossed);
    EXPECT_EQ(count_moves(plan), 1);
    EXPECT_EQ(plan.steps[0].crossed, starts_crossed);
    EXPECT_TRUE(is_mirrored(plan));
  }
}

TEST(BurstOrder, CostsWhatAnExhaustiveSearchFindsOnSmallCases) {
  struct rig rig = test_rig();
  const std::vector<Steps> cases = {
      some({0, 1, 2, 3, 14, 15, 8}),   // two LED pairs, the projector's pair, one fringe
      some({0, 1, 14, 15, 8, 9, 13}),  // one of each kind of pair, three patterns
      some({2, 3, 14, 15}),            // pairs alone
      some({8, 9, 10, 0, 1}),          // one pair
      some({8, 12, 13}),               // none
  };
  for (const double weight : {0.0, 0.05, 0.5, 10.0}) {
    rig.burst_pair_weight = weight;
    for (const Steps& steps : cases) {
      for (const bool starts_crossed : {false, true}) {
        const burst_plan plan = planned(rig, steps, starts_crossed);
        EXPECT_NEAR(plan.cost_us, cheapest_of_permutations(rig, steps, starts_crossed), 1e-3)
            << steps.size() << " steps, weight " << weight << ", crossed " << starts_crossed;
      }
    }
  }
}

TEST(BurstOrder, FollowsTheCostWhenARigIsBuiltDifferently) {
  struct rig rig = test_rig();
  // A lamp that takes long: switching it is what costs, so LEDs and projector are not mixed.
  rig.projector_lamp_settle_us = 400000;
  const burst_plan plan = planned(rig, paper_steps(), false);
  int switches = 0;
  for (size_t i = 1; i < plan.count; i++) {
    switches +=
        burst_step_is_lit_by_leds(&plan.steps[i]) != burst_step_is_lit_by_leds(&plan.steps[i - 1]);
  }
  EXPECT_EQ(switches, 2);
}

TEST(BurstOrder, HeavierPairsComeCloserTogether) {
  struct rig rig = test_rig();
  const auto separation_us = [&](double weight) {
    rig.burst_pair_weight = weight;
    const burst_plan plan = planned(rig, paper_steps(), false);
    return weight > 0 ? (plan.cost_us - plan.duration_us) / weight : plan.duration_us;
  };
  EXPECT_LE(separation_us(10), separation_us(0.01) + 1e-3);
}

TEST(BurstOrder, OfTheSimulatedRigFitsIntoOneAndAHalfSeconds) {
  EXPECT_LT(planned(test_rig(), paper_steps(), false).duration_us, 1.5e6);
}

TEST(BurstLevels, OfAGradientAreHalfOfOnePlusTheDirection) {
  const struct rig rig = test_rig();
  uint16_t codes[RIG_MAX_LEDS];
  const lamella_v1_Frame_Role roles[] = {lamella_v1_Frame_Role_GRADIENT_X,
                                         lamella_v1_Frame_Role_GRADIENT_Y,
                                         lamella_v1_Frame_Role_GRADIENT_Z};
  for (int axis = 0; axis < 3; axis++) {
    burst_led_codes(&rig, roles[axis], codes);
    for (size_t i = 0; i < rig.led_count; i++) {
      EXPECT_NEAR(codes[i] / 4095.0, (1 + rig.leds[i].direction[axis]) / 2, 0.5 / 4095 + 1e-9);
    }
  }
}

TEST(BurstLevels, OfTheFullSphereAreFull) {
  const struct rig rig = test_rig();
  uint16_t codes[RIG_MAX_LEDS];
  burst_led_codes(&rig, lamella_v1_Frame_Role_GRADIENT_FULL, codes);
  EXPECT_TRUE(std::all_of(codes, codes + rig.led_count,
                          [](uint16_t code) { return code == CHAIN_FULL_CODE; }));
}
