#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "test_rig.h"

extern "C" {
#include "hal_sim.h"
}

namespace {

std::vector<uint8_t> random_stream(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<uint8_t> stream(CHAIN_BYTES);
  for (uint8_t& byte : stream) byte = static_cast<uint8_t>(random());
  return stream;
}

bool bit_of(const std::vector<uint8_t>& stream, size_t bit) {
  return stream[bit / 8] >> (7 - bit % 8) & 1;
}

// What leaves a chain's far end while the third of three random streams goes in.
std::vector<uint8_t> echo(struct sim_chain chain, unsigned seed = 1) {
  std::vector<uint8_t> out(CHAIN_BYTES);
  for (unsigned i = 0; i < 3; i++) {
    sim_chain_shift(&chain, random_stream(seed + i).data(), CHAIN_BITS, out.data());
  }
  return out;
}

}  // namespace

TEST(SimulatedFaults, AreReadFromTheCommandLine) {
  sim_faults faults = kSimNoFaults;
  for (const char* right :
       {"flip-bit:2015", "late-blank:250.5", "slow-actuator:3", "missing-chip:6", "dead-led:17",
        "swapped-leds:3:149", "stuck-actuator", "missing-camera:1", "press:2e6:1e5", "hot:90"}) {
    EXPECT_TRUE(sim_faults_parse(right, &faults)) << right;
  }
  EXPECT_EQ(faults.flipped_bit, 2015);
  EXPECT_DOUBLE_EQ(faults.late_blank_us, 250.5);
  EXPECT_DOUBLE_EQ(faults.slow_actuator, 3);
  EXPECT_EQ(faults.missing_chip, 6);
  EXPECT_EQ(faults.dead_led, 17);
  EXPECT_EQ(faults.swapped_leds[1], 149);
  EXPECT_TRUE(faults.stuck_actuator);
  EXPECT_EQ(faults.missing_camera, 1);
  EXPECT_DOUBLE_EQ(faults.press_us, 2e6);
  EXPECT_DOUBLE_EQ(faults.hold_us, 1e5);
  EXPECT_DOUBLE_EQ(faults.hottest_c, 90);
  EXPECT_EQ(faults.weak_led, -1);
  EXPECT_EQ(faults.late_pulse, -1);
  EXPECT_TRUE(sim_faults_parse("late-blank:50:3", &faults));
  EXPECT_DOUBLE_EQ(faults.late_blank_us, 50);
  EXPECT_EQ(faults.late_pulse, 3);
  EXPECT_TRUE(sim_faults_parse("drop-frame:7", &faults));
  EXPECT_EQ(faults.dropped_shot, 7);
}

TEST(SimulatedFaults, WhatIsNoFaultIsRefused) {
  for (const char* wrong : {"flip-bit:", "late-blank:-1", "slow-actuator:0", "slow-actuator:x",
                            "flip", "", "swapped-leds:3", "press:1", "stuck-actuator:1",
                            "flip-bit:3:1", "late-blank:5:", "late-blank:5:x", "late-blank:5:-1",
                            "drop-frame:1:2", "dead-led:1:2", "hot:nan"}) {
    sim_faults faults = kSimNoFaults;
    EXPECT_FALSE(sim_faults_parse(wrong, &faults)) << wrong;
  }
}

TEST(SimulatedFaults, AChainWithoutOneChipIsShorterAndTheLaterChipsGetTheNextOnesCodes) {
  struct sim_chain chain = {};
  chain.missing_chip = 3;  // number 2
  const std::vector<uint8_t> out = echo(chain), second = random_stream(2), third = random_stream(3);
  const size_t length = CHAIN_BITS - CHAIN_CHIP_BITS;
  for (size_t i = 0; i < CHAIN_BITS; i++) {
    const bool expected =
        i < length ? bit_of(second, CHAIN_CHIP_BITS + i) : bit_of(third, i - length);
    ASSERT_EQ(bit_of(out, i), expected) << i;
  }
  const struct rig rig = test_rig();
  std::vector<uint16_t> codes(RIG_MAX_LEDS);
  for (size_t i = 0; i < rig.led_count; i++) codes[i] = rig.leds[i].chip * 100 + 1;
  uint8_t stream[CHAIN_BYTES];
  led_chain_encode(&rig, codes.data(), stream);
  sim_chain_shift(&chain, stream, CHAIN_BITS, nullptr);
  sim_chain_latch(&chain, true);
  EXPECT_EQ(sim_chain_code(&chain, 1, 0), 101);
  EXPECT_EQ(sim_chain_code(&chain, 2, 0), 0);
  EXPECT_EQ(sim_chain_code(&chain, 3, 0), 201);
}

TEST(SimulatedFaults, ABrokenChipPassesNothingOn) {
  for (const int broken : {1, 4, 7}) {
    struct sim_chain chain = {};
    chain.broken_chip = broken;
    EXPECT_EQ(echo(chain), std::vector<uint8_t>(CHAIN_BYTES)) << broken;
    const std::vector<uint8_t> ones(CHAIN_BYTES, 0xFF);
    sim_chain_shift(&chain, ones.data(), CHAIN_BITS, nullptr);
    sim_chain_latch(&chain, true);
    for (int chip = 0; chip < CHAIN_CHIPS; chip++) {
      EXPECT_EQ(sim_chain_code(&chain, chip, 5), chip < broken ? CHAIN_FULL_CODE : 0);
    }
  }
}

TEST(SimulatedFaults, TheOperatorsLinesAreRecordedInTime) {
  const struct rig rig = test_rig();
  static struct hal_sim sim;
  ASSERT_EQ(hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, kSimNoFaults, nullptr), LAM_OK);
  double at_us = 0;
  sim.hal.set_line(&sim, HAL_READY, true, &at_us);
  sim.hal.wait_until_us(&sim, 500);
  sim.hal.set_line(&sim, HAL_BUZZER, true, &at_us);
  ASSERT_EQ(sim.signal_count, 2u);
  EXPECT_EQ(sim.signals[0].line, HAL_READY);
  EXPECT_EQ(sim.signals[1].line, HAL_BUZZER);
  EXPECT_DOUBLE_EQ(sim.signals[1].at_us, 500);
}
