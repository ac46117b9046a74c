#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "test_rig.h"

extern "C" {
#include "hal_sim.h"
#include "led_driver.h"
}

namespace {

// A simulated rig whose lines and bus are counted, and whose drivers are looked at after each edge.
struct Wired {
  explicit Wired(const std::string& fault = "") {
    sim_faults faults = kSimNoFaults;
    EXPECT_EQ(sim_faults_parse(fault.c_str(), &faults), !fault.empty()) << fault;
    EXPECT_EQ(hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, faults, nullptr), LAM_OK);
    hal = sim.hal;
    hal.self = this;
    hal.set_line = [](void* self, hal_line line, bool level, double* at_us) {
      Wired* wired = static_cast<Wired*>(self);
      const lam_status status = wired->sim.hal.set_line(&wired->sim, line, level, at_us);
      wired->latches += line == HAL_LATCH && level;
      wired->lit_while_latching |= line == HAL_LATCH && !wired->sim.light.blank;
      if (line == HAL_LATCH && level) wired->look_for_garbage();
      return status;
    };
    hal.shift_leds = [](void* self, const uint8_t* stream, uint8_t* out, double* at_us) {
      Wired* wired = static_cast<Wired*>(self);
      wired->shifts++;
      return wired->sim.hal.shift_leds(&wired->sim, stream, out, at_us);
    };
    hal.now_us = [](void* self) { return static_cast<Wired*>(self)->sim.virtual_now_us; };
    hal.wait_until_us = [](void* self, double t_us) {
      return sim_of(self)->hal.wait_until_us(sim_of(self), t_us);
    };
    hal.lights_off = [](void* self) { sim_of(self)->hal.lights_off(sim_of(self)); };
  }

  static hal_sim* sim_of(void* self) { return &static_cast<Wired*>(self)->sim; }

  void look_for_garbage() {
    for (const uint8_t cell : sim.light.chain.latched) garbage |= cell != 0;
  }

  // The supply of the drivers goes and comes; the daemon does not see it.
  void lose_supply() { sim_chain_power_up(&sim.light.chain, true); }

  lam_status ready() {
    shifts = latches = 0;
    return led_driver_ready(&hal, &rig, &functions);
  }

  // What LED 0 gives once it was told to be full.
  uint16_t full_code() {
    uint16_t codes[RIG_MAX_LEDS] = {CHAIN_FULL_CODE};
    uint8_t stream[CHAIN_BYTES];
    led_chain_encode(&rig, codes, stream);
    sim_chain_shift(&sim.light.chain, stream, CHAIN_BITS, nullptr);
    sim_chain_latch(&sim.light.chain, true);
    sim_chain_latch(&sim.light.chain, false);
    return sim_chain_code(&sim.light.chain, rig.leds[0].chip, rig.leds[0].output);
  }

  struct rig rig = test_rig();
  struct hal_sim sim;
  struct hal hal;
  struct led_functions functions;
  int shifts = 0, latches = 0;
  bool garbage = false, lit_while_latching = false;
};

// Bits `low` to `high` of a chip's register in a stream that was shifted in.
unsigned field(const uint8_t* stream, int chip, int low, int high) {
  unsigned value = 0;
  for (int bit = high; bit >= low; bit--) {
    const int at = (CHAIN_CHIPS - 1 - chip) * CHAIN_CHIP_BITS + CHAIN_CHIP_BITS - 1 - bit;
    value = value << 1 | (stream[at / 8] >> (7 - at % 8) & 1);
  }
  return value;
}

}  // namespace

// Places and values as the data sheet's tables have them (SBVS127E, 9.4.5.3).
TEST(LedDriver, FunctionsAreFullCurrentAndTwelveBitPeriodsThatRepeat) {
  uint8_t stream[CHAIN_BYTES];
  led_chain_encode_functions(stream);
  for (int chip = 0; chip < CHAIN_CHIPS; chip++) {
    for (int output = 0; output < CHAIN_OUTPUTS; output++) {
      EXPECT_EQ(field(stream, chip, 7 * output, 7 * output + 6), 127u) << chip << " " << output;
    }
    for (const int low : {168, 176, 184}) EXPECT_EQ(field(stream, chip, low, low + 7), 255u);
    EXPECT_EQ(field(stream, chip, 192, 194), 7u) << "the upper range of dot correction";
    EXPECT_EQ(field(stream, chip, 195, 195), 1u) << "auto repeat";
    EXPECT_EQ(field(stream, chip, 196, 196), 0u) << "a LATCH restarts no counter";
    EXPECT_EQ(field(stream, chip, 197, 198), 0u) << "counters of 12 bits";
    for (int bit = 199; bit < CHAIN_CHIP_BITS; bit++) {
      EXPECT_EQ(field(stream, chip, bit, bit), 0u) << bit;
    }
  }
}

TEST(LedDriver, GivesNoLightAfterPowerOnUntilItsFunctionsAreWritten) {
  Wired wired;
  EXPECT_EQ(wired.full_code(), 0);
  ASSERT_EQ(wired.ready(), LAM_OK) << wired.hal.error;
  EXPECT_EQ(wired.functions.compared, 7 * 199);
  EXPECT_EQ(wired.functions.wrong, 0);
  EXPECT_EQ(wired.full_code(), CHAIN_FULL_CODE);
}

TEST(LedDriver, TakesNoGarbageAsLevelsWhileItsFunctionsAreWritten) {
  Wired wired;
  for (int again = 0; again < 2; again++) {
    ASSERT_EQ(wired.ready(), LAM_OK);
    EXPECT_GT(wired.latches, 0);
    EXPECT_FALSE(wired.garbage);
    EXPECT_FALSE(wired.lit_while_latching);
  }
}

TEST(LedDriver, IsDarkenedFirst) {
  Wired wired;
  double at_us = 0;
  wired.hal.set_line(&wired, HAL_BLANK, false, &at_us);
  ASSERT_EQ(wired.ready(), LAM_OK);
  EXPECT_FALSE(wired.lit_while_latching);
  EXPECT_TRUE(wired.sim.light.blank);
}

TEST(LedDriver, ThatKeptItsFunctionsIsReadBackWithOneFrameAlone) {
  Wired wired;
  ASSERT_EQ(wired.ready(), LAM_OK);
  EXPECT_GT(wired.shifts, 1);
  wired.full_code();  // a burst's last frame
  ASSERT_EQ(wired.ready(), LAM_OK);
  EXPECT_EQ(wired.shifts, 1);
  EXPECT_EQ(wired.functions.wrong, 0);
}

TEST(LedDriver, ThatLostItsSupplyIsToldItsFunctionsAgain) {
  Wired wired;
  ASSERT_EQ(wired.ready(), LAM_OK);
  wired.lose_supply();
  EXPECT_EQ(wired.full_code(), 0);
  wired.lose_supply();
  ASSERT_EQ(wired.ready(), LAM_OK);
  EXPECT_EQ(wired.full_code(), CHAIN_FULL_CODE);
}

TEST(LedDriver, WhoseLatchWasLeftHighByADeadProgramIsToldAsWell) {
  Wired wired;
  sim_chain_latch(&wired.sim.light.chain, true);
  ASSERT_EQ(wired.ready(), LAM_OK);
  EXPECT_FALSE(wired.garbage);
  EXPECT_EQ(wired.full_code(), CHAIN_FULL_CODE);
}

TEST(LedDriver, ThatDoesNotKeepItsFunctionsIsNamed) {
  for (int chip = 0; chip < CHAIN_CHIPS; chip++) {
    Wired wired("forgetful-chip:" + std::to_string(chip));
    EXPECT_EQ(wired.ready(), LAM_HARDWARE);
    EXPECT_EQ(wired.functions.first_chip, chip);
    EXPECT_GT(wired.functions.wrong, 0);
    EXPECT_EQ(std::string(wired.hal.error).find("LED driver chip " + std::to_string(chip)), 0u);
  }
}

TEST(LedDriver, OfAChainThatIsTooShortOrSilentIsNotTakenForGood) {
  for (const char* fault : {"missing-chip:2", "broken-chip:6", "broken-chip:0"}) {
    Wired wired(fault);
    EXPECT_EQ(wired.ready(), LAM_HARDWARE) << fault;
  }
}

TEST(LedDriver, WithoutFunctionsIsLeftAlone) {
  Wired wired;
  wired.rig.leds_have_functions = false;
  EXPECT_EQ(wired.ready(), LAM_OK);
  EXPECT_EQ(wired.functions.compared, 0);
  EXPECT_EQ(wired.shifts, 0);
}
