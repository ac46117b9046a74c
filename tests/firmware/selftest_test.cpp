#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "faulty_rig.h"

extern "C" {
#include "hal_sim.h"
#include "selftest.h"
}

namespace {

unsigned only(selftest_part part) { return 1u << part; }

// A rig in memory that tests itself before a fake twin.
struct SelftestBench : FaultyRig {
  explicit SelftestBench(const std::vector<std::string>& injected = {}) : FaultyRig(injected) {
    selftest_init(&test, &rig, &sim.hal, &photographs);
  }

  const struct selftest& run(unsigned parts, bool quick = false, bool learning = false) {
    selftest_begin(&test, parts, quick, learning);
    while (selftest_work(&test)) continue;
    EXPECT_TRUE(sim.light.blank);
    return test;
  }

  // Learns the LEDs of a rig without faults, then goes on with this one.
  void learn() {
    SelftestBench good;
    EXPECT_EQ(good.run(only(SELFTEST_LEDS), false, true).bad, 0u) << good.text();
    test.reference = good.test.reference;
    EXPECT_EQ(test.reference.led_count, rig.led_count);
  }

  // Every reading that is not good, a line each.
  std::string text() const {
    std::string all;
    for (size_t i = 0; i < test.count; i++) {
      const selftest_reading& r = test.readings[i];
      if (r.verdict == SELFTEST_GOOD) continue;
      all += std::string(selftest_part_name(r.part)) + ": " + r.what + " " +
             std::to_string(r.value) + " " + r.unit + ": " + r.note + "\n";
    }
    return all;
  }

  struct selftest test;
};

void expect_found(const std::string& fault, selftest_part part, lam_part panel,
                  const std::string& says) {
  SelftestBench bench({fault});
  EXPECT_GT(bench.run(only(part)).bad, 0u) << fault;
  EXPECT_EQ(selftest_failed_part(&bench.test), panel) << fault;
  EXPECT_NE(bench.text().find(says), std::string::npos) << fault << "\n" << bench.text();
}

}  // namespace

TEST(Selftest, OfAGoodRigFindsNothing) {
  SelftestBench bench;
  bench.learn();
  const struct selftest& test = bench.run(SELFTEST_ALL);
  EXPECT_EQ(test.bad, 0u) << bench.text();
  bool seen[SELFTEST_PARTS] = {};
  for (size_t i = 0; i < test.count; i++) seen[test.readings[i].part] = true;
  for (int i = 0; i < SELFTEST_PARTS; i++) EXPECT_TRUE(seen[i]) << i;
}

TEST(Selftest, LeavesTheAnalyserWhereItStood) {
  for (const bool crossed : {false, true}) {
    SelftestBench bench;
    double at_us = 0;
    if (crossed) {
      bench.sim.hal.move_analyser(&bench.sim, true, &at_us);
      bench.sim.hal.wait_until_us(&bench.sim, at_us + 1e6);
      bench.test.stands_crossed = true;
    }
    EXPECT_EQ(bench.run(only(SELFTEST_ACTUATOR)).bad, 0u) << bench.text();
    struct hal_senses senses;
    bench.sim.hal.sense(&bench.sim, &senses);
    EXPECT_EQ(senses.at_crossed, crossed);
    EXPECT_EQ(bench.test.stands_crossed, crossed);
  }
}

TEST(Selftest, EachInjectedFaultIsFoundAndNamed) {
  expect_found("estop", SELFTEST_ESTOP, LAM_PART_ESTOP, "release the emergency stop");
  expect_found("hot:95", SELFTEST_TEMPERATURE, LAM_PART_HEAT, "hottest thermistor 95");
  expect_found("stuck-actuator", SELFTEST_ACTUATOR, LAM_PART_ACTUATOR, "does not arrive");
  expect_found("slow-actuator:2", SELFTEST_ACTUATOR, LAM_PART_ACTUATOR, "slower than");
  expect_found("frozen-projector", SELFTEST_PROJECTOR, LAM_PART_PROJECTOR, "does not happen");
  expect_found("missing-camera:0", SELFTEST_CAMERAS, LAM_PART_CAMERA, "left camera");
  expect_found("missing-camera:1", SELFTEST_CAMERAS, LAM_PART_CAMERA, "right camera");
  expect_found("drop-frame:1", SELFTEST_CAMERAS, LAM_PART_CAMERA, "missed a trigger");
}

TEST(Selftest, AStuckActuatorIsBadForItselfAlone) {
  SelftestBench bench({"stuck-actuator"});
  double at_us = 0;
  ASSERT_EQ(bench.sim.hal.move_analyser(&bench.sim, true, &at_us), LAM_OK);
  bench.sim.hal.wait_until_us(&bench.sim, at_us + 2 * bench.rig.analyser_move_us);
  EXPECT_EQ(bench.run(only(SELFTEST_ESTOP) | only(SELFTEST_TEMPERATURE)).bad, 0u) << bench.text();
  bench.run(SELFTEST_ALL);
  EXPECT_EQ(bench.test.unfit, only(SELFTEST_ACTUATOR)) << bench.text();
}

TEST(Selftest, OfSomePartsReplacesTheVerdictsOfThoseAlone) {
  SelftestBench bench({"slow-actuator:2", "flip-bit:77"});
  const unsigned chain = only(SELFTEST_CHAIN), actuator = only(SELFTEST_ACTUATOR);
  bench.run(SELFTEST_ALL & ~only(SELFTEST_LEDS), true);
  EXPECT_EQ(bench.test.unfit, chain | actuator);
  EXPECT_NE(std::string(bench.test.why[SELFTEST_ACTUATOR]).find("slower than analyser.move_us"),
            std::string::npos);
  EXPECT_EQ(bench.run(only(SELFTEST_ESTOP)).bad, 0u);
  EXPECT_EQ(bench.test.unfit, chain | actuator);
  bench.sim.faults = kSimNoFaults;
  bench.run(chain);
  EXPECT_EQ(bench.test.unfit, actuator);
  EXPECT_STREQ(bench.test.why[SELFTEST_CHAIN], "");
  bench.run(actuator);
  EXPECT_EQ(bench.test.unfit, 0u);
}

TEST(Selftest, ThatSkipsAPartLeavesItsVerdict) {
  SelftestBench bench({"dead-led:17"});
  bench.run(only(SELFTEST_LEDS));
  ASSERT_EQ(bench.test.unfit, only(SELFTEST_LEDS)) << bench.text();
  bench.sim.faults = kSimNoFaults;
  bench.sim.faults.estopped = true;
  EXPECT_EQ(bench.run(only(SELFTEST_LEDS)).bad, 0u) << bench.text();
  EXPECT_EQ(bench.test.unfit, only(SELFTEST_LEDS));
  bench.sim.faults.estopped = false;
  bench.run(only(SELFTEST_LEDS));
  EXPECT_EQ(bench.test.unfit, 0u) << bench.text();
}

TEST(Selftest, ARigWithoutThermistorsIsNotUnfitForThemWhereItsInputsFail) {
  SelftestBench bench;
  bench.rig.board.given = true;
  bench.sim.hal.sense = [](void*, struct hal_senses*) { return LAM_HARDWARE; };
  bench.run(only(SELFTEST_ESTOP) | only(SELFTEST_TEMPERATURE));
  EXPECT_EQ(bench.test.unfit, only(SELFTEST_ESTOP)) << bench.text();
}

// A wire that is broken and reads 1 wherever the analyser stands.
TEST(Selftest, BothEndStopsAtOnceAreBad) {
  static enum lam_status (*sense_rig)(void*, struct hal_senses*);
  SelftestBench bench;
  sense_rig = bench.sim.hal.sense;
  bench.sim.hal.sense = [](void* self, struct hal_senses* senses) {
    const enum lam_status status = sense_rig(self, senses);
    senses->at_parallel = true;
    return status;
  };
  EXPECT_EQ(bench.run(only(SELFTEST_ACTUATOR)).bad, 1u) << bench.text();
  EXPECT_EQ(selftest_failed_part(&bench.test), LAM_PART_ACTUATOR);
  EXPECT_NE(bench.text().find("at crossed 0"), std::string::npos) << bench.text();
}

TEST(Selftest, AMissingChipIsALengthThatComesBack) {
  for (const char* fault : {"missing-chip:0", "missing-chip:6"}) {
    expect_found(fault, SELFTEST_CHAIN, LAM_PART_LED_CHAIN, "chips in the chain 6");
    expect_found(fault, SELFTEST_CHAIN, LAM_PART_LED_CHAIN, "1728 bits come back after");
    SelftestBench bench({fault});
    bench.run(only(SELFTEST_CHAIN));
    EXPECT_EQ(bench.text().find("chip 0 is the first"), std::string::npos) << bench.text();
  }
}

TEST(Selftest, AChipThatPassesNothingOnIsSilence) {
  expect_found("broken-chip:2", SELFTEST_CHAIN, LAM_PART_LED_CHAIN, "nothing comes back");
}

TEST(Selftest, AWrongBitIsNamedByItsPlace) {
  // The top bit of chip 0 output 0 is the twelfth from the stream's end.
  expect_found("flip-bit:" + std::to_string(CHAIN_BITS - 12), SELFTEST_CHAIN, LAM_PART_LED_CHAIN,
               "chip 0 output 0 bit 11");
  expect_found("stuck-bit:0", SELFTEST_CHAIN, LAM_PART_LED_CHAIN, "chip 6 output 23 bit 11");
  SelftestBench flipped({"flip-bit:77"});
  flipped.run(only(SELFTEST_CHAIN));
  EXPECT_NE(flipped.text().find("wrong bits 9"), std::string::npos) << flipped.text();
}

TEST(Selftest, AChipThatForgetsWhatItIsToldBesideLevelsIsNamed) {
  expect_found("forgetful-chip:3", SELFTEST_CHAIN, LAM_PART_LED_CHAIN,
               "chip 3 is the first that does not keep them");
  expect_found("forgetful-chip:3", SELFTEST_LEDS, LAM_PART_LED_CHAIN,
               "does not keep its functions");
}

TEST(Selftest, SeesThatLightsGoOffByThemselvesWhenTheHeartStops) {
  SelftestBench bench;
  EXPECT_EQ(bench.run(only(SELFTEST_BLANK)).bad, 0u) << bench.text();
  ASSERT_EQ(bench.test.count, 2u);
  EXPECT_STREQ(bench.test.readings[1].what, "dark after the last heartbeat");
  EXPECT_NEAR(bench.test.readings[1].value, 8, 0.01);
  for (const uint8_t level : bench.sim.light.chain.latched) ASSERT_EQ(level, 0) << "it was lit";
  expect_found("dead-monostable", SELFTEST_BLANK, LAM_PART_LED_CHAIN, "stays lit when the heart");
}

TEST(Selftest, NeverLatchesTheRandomStreamsOfTheChain) {
  SelftestBench bench;
  uint8_t before[CHAIN_BITS];
  memcpy(before, bench.sim.light.chain.latched, sizeof before);
  selftest_begin(&bench.test, only(SELFTEST_CHAIN), false, false);
  while (bench.test.step < CHAIN_TRIAL_STREAMS && selftest_work(&bench.test)) {
    EXPECT_EQ(memcmp(before, bench.sim.light.chain.latched, sizeof before), 0) << bench.test.step;
  }
  while (selftest_work(&bench.test)) continue;
  const uint8_t dark[CHAIN_BITS] = {};
  EXPECT_EQ(memcmp(dark, bench.sim.light.chain.latched, sizeof dark), 0);
}

TEST(Selftest, DeadWeakAndSwappedLedsAreNamedByNumberChipAndOutput) {
  for (const bool quick : {false, true}) {
    SelftestBench dead({"dead-led:17"});
    dead.learn();
    EXPECT_EQ(dead.run(only(SELFTEST_LEDS), quick).blamed, 1u);
    EXPECT_NE(dead.text().find("LED 17 (chip 3 output 2) 0.0"), std::string::npos) << dead.text();

    SelftestBench weak({"weak-led:149"});
    weak.learn();
    EXPECT_EQ(weak.run(only(SELFTEST_LEDS), quick).blamed, 1u);
    EXPECT_NE(weak.text().find("LED 149 (chip 2 output 21) 0.5"), std::string::npos) << weak.text();

    SelftestBench swapped({"swapped-leds:40:60"});
    swapped.learn();
    EXPECT_EQ(swapped.run(only(SELFTEST_LEDS), quick).blamed, 2u);
    const std::string text = swapped.text();
    EXPECT_NE(text.find("LED 40 (chip 5 output 5)"), std::string::npos) << text;
    EXPECT_NE(text.find("as LED 60 (chip 4 output 8) should"), std::string::npos) << text;
    EXPECT_NE(text.find("as LED 40 (chip 5 output 5) should"), std::string::npos) << text;
  }
}

// At half its brightness an LED is nearer to a neighbour that was always dim than to itself.
TEST(Selftest, AnLedThatIsWeakIsWeakWhicheverItIs) {
  for (const char* fault : {"weak-led:3", "weak-led:0", "weak-led:9", "weak-led:100"}) {
    SelftestBench bench({fault});
    bench.learn();
    EXPECT_EQ(bench.run(only(SELFTEST_LEDS)).blamed, 1u);
    EXPECT_NE(bench.text().find("weak: dirt"), std::string::npos) << fault << bench.text();
  }
}

// A chip's LEDs together look the same whichever of them is wired where.
TEST(Selftest, LedsSwappedWithinAChipAreForTheFullTest) {
  SelftestBench bench({"swapped-leds:40:61"});
  bench.learn();
  EXPECT_EQ(bench.run(only(SELFTEST_LEDS), true).blamed, 0u) << bench.text();
  EXPECT_EQ(bench.run(only(SELFTEST_LEDS), false).blamed, 2u) << bench.text();
}

TEST(Selftest, WithoutAReferenceADeadLedIsToldAllTheSame) {
  SelftestBench bench({"dead-led:3"});
  EXPECT_EQ(bench.run(only(SELFTEST_LEDS)).blamed, 1u);
  EXPECT_NE(bench.text().find("LED 3 (chip 3 output 0)"), std::string::npos) << bench.text();
  EXPECT_NE(bench.text().find("none: dead LEDs alone"), std::string::npos) << bench.text();
}

// No camera sees what LEDs 84 and 85 light: they stand behind. LED 3 is above.
TEST(Selftest, ADarkLedBehindIsNotJudgedAndADarkOneInSightIsDead) {
  SelftestBench behind({"dead-led:85"});
  EXPECT_EQ(behind.run(only(SELFTEST_LEDS)).bad, 0u) << behind.text();
  EXPECT_NE(behind.text().find("LED 85 (chip 1 output 12)"), std::string::npos) << behind.text();
  EXPECT_NE(behind.text().find("not judged, look whether it lights up"), std::string::npos);
  const struct selftest_reading& all = behind.test.readings[behind.test.count - 1];
  EXPECT_STREQ(all.what, "LEDs as expected");
  EXPECT_EQ(all.value, 149);
  EXPECT_EQ(all.high, 149);
  EXPECT_STREQ(all.note, "of 150; not judged, as no camera sees their light: 1");
  EXPECT_EQ(SelftestBench({"dead-led:3"}).run(only(SELFTEST_LEDS)).blamed, 1u);
  behind.learn();  // on a rig whose cameras do see it, dead is dead
  EXPECT_EQ(behind.run(only(SELFTEST_LEDS)).blamed, 1u);
}

// It may be dead or behind the subject: whoever learns is told to look, and it is left out.
TEST(Selftest, AnLedThatNoCameraSeesIsNamedWhenLearning) {
  SelftestBench bench({"dead-led:3"});
  EXPECT_EQ(bench.run(only(SELFTEST_LEDS), false, true).bad, 0u);
  EXPECT_NE(bench.text().find("LED 3 (chip 3 output 0)"), std::string::npos) << bench.text();
  EXPECT_NE(bench.text().find("look whether it lights up"), std::string::npos) << bench.text();
  for (const bool quick : {false, true}) {
    EXPECT_EQ(bench.run(only(SELFTEST_LEDS), quick).bad, 0u) << bench.text();
  }
  bench.sim.faults.weak_led = 4;
  EXPECT_EQ(bench.run(only(SELFTEST_LEDS)).blamed, 1u);
}

TEST(Selftest, TheQuickTestTakesAPhotographOfEachChipAlone) {
  SelftestBench bench;
  bench.learn();
  EXPECT_EQ(bench.run(only(SELFTEST_LEDS), true).bad, 0u) << bench.text();
  EXPECT_EQ(bench.twin.reports().size(), 2u * (1 + CHAIN_CHIPS));
}

TEST(Selftest, LedLightKeepsToTheRulesOfTimeAndDuty) {
  SelftestBench bench;
  bench.run(only(SELFTEST_LEDS));
  const auto reports = bench.twin.reports();
  double on_us = 0, first_us = -1, last_us = 0;
  for (size_t i = 0; i < reports.size(); i += 2) {
    for (int k = 0; k < reports[i].leds_count; k++) {
      const lamella_v1_LedSpan& span = reports[i].leds[k];
      const double length_us = span.off_us - span.on_us;
      EXPECT_LE(length_us, bench.rig.leds_longest_on_us);
      EXPECT_NEAR(std::remainder(length_us, rig_pwm_period_us(&bench.rig)), 0, 0.1);
      if (first_us < 0) first_us = span.on_us;
      on_us += length_us;
      last_us = span.off_us;
    }
  }
  EXPECT_NEAR(on_us, 150 * bench.rig.leds_light_us, 1);
  const double window_us = last_us - first_us + bench.rig.leds_light_us;
  EXPECT_LE(on_us / window_us, bench.rig.leds_highest_duty + 1e-6);
}

TEST(Selftest, UnderAnEmergencyStopTheLedsAreNotBlamed) {
  SelftestBench bench({"estop"});
  EXPECT_EQ(bench.run(only(SELFTEST_LEDS)).bad, 0u);
  EXPECT_NE(bench.text().find("emergency stop cuts"), std::string::npos);
}

// A board that is being built up names its devices one after the other.
TEST(Selftest, WhatTheRigFileDoesNotNameIsSkippedAndSaid) {
  SelftestBench bench;
  bench.rig.board.given = true;
  const struct selftest& test =
      bench.run(only(SELFTEST_PROJECTOR) | only(SELFTEST_CAMERAS) | only(SELFTEST_LEDS));
  EXPECT_EQ(test.bad, 0u) << bench.text();
  ASSERT_EQ(test.count, 3u);
  for (size_t i = 0; i < test.count; i++) EXPECT_EQ(test.readings[i].verdict, SELFTEST_SKIPPED);
}

TEST(Selftest, TheDiskIsMeasuredAgainstTheBudget) {
  SelftestBench bench;
  struct Disk {
    double free_bytes, bytes_per_s;
  } disk = {1e12, 200e6};
  const struct selftest_disk door = {
      [](void* context, double* free_bytes, double* bytes_per_s, char*) {
        *free_bytes = static_cast<Disk*>(context)->free_bytes;
        *bytes_per_s = static_cast<Disk*>(context)->bytes_per_s;
        return true;
      },
      &disk};
  bench.test.disk = &door;
  bench.rig.store_disk_bytes_per_s = 100e6;
  EXPECT_EQ(bench.run(only(SELFTEST_DISK)).bad, 0u) << bench.text();
  disk.bytes_per_s = 50e6;
  EXPECT_EQ(bench.run(only(SELFTEST_DISK)).bad, 1u);
  EXPECT_EQ(selftest_failed_part(&bench.test), LAM_PART_DISK);
  disk = {60e6, 200e6};
  bench.run(only(SELFTEST_DISK));
  EXPECT_NE(bench.text().find("two bursts' room is asked: make some on it"), std::string::npos)
      << bench.text();
  bench.photographs.on_disk = true;
  bench.photographs.burst_count = 1;
  EXPECT_EQ(bench.run(only(SELFTEST_DISK)).bad, 1u);
  EXPECT_NE(bench.text().find("sync sessions"), std::string::npos);
}

// A burst needs room beside its photographs, however small they are, and a number of its own.
TEST(Selftest, ADiskOnWhichNoBurstWouldBeBegunIsNotGood) {
  SelftestBench bench;
  static double free_bytes;
  const struct selftest_disk door = {[](void*, double* free, double* bytes_per_s, char*) {
                                       *free = free_bytes;
                                       *bytes_per_s = 1e9;
                                       return true;
                                     },
                                     nullptr};
  bench.test.disk = &door;
  bench.rig.camera_frame_bytes = 1000;
  free_bytes = 4e6;
  EXPECT_EQ(bench.run(only(SELFTEST_DISK)).bad, 1u) << bench.text();
  free_bytes = 5e6;
  EXPECT_EQ(bench.run(only(SELFTEST_DISK)).bad, 0u) << bench.text();
  bench.photographs.on_disk = true;
  bench.photographs.burst_count = STORE_MAX_BURSTS - 1;
  EXPECT_EQ(bench.run(only(SELFTEST_DISK)).bad, 0u) << bench.text();
  bench.photographs.burst_count = STORE_MAX_BURSTS;
  EXPECT_EQ(bench.run(only(SELFTEST_DISK)).bad, 1u) << bench.text();
  EXPECT_NE(bench.text().find("bursts held"), std::string::npos) << bench.text();
}

TEST(Selftest, PartsAreFoundByTheirNames) {
  for (int i = 0; i < SELFTEST_PARTS; i++) {
    EXPECT_EQ(selftest_part_named(selftest_part_name(selftest_part(i))), i);
  }
  EXPECT_EQ(selftest_part_named("engine"), SELFTEST_PARTS);
}

TEST(LedReference, GoesWhereALinkLeadsAndStaysALinkItself) {
  SelftestBench bench;
  bench.learn();
  char folder[] = "/tmp/lamella-reference-XXXXXX";
  const std::filesystem::path place = mkdtemp(folder);
  const std::string link = place / "link";
  char error[112] = "";
  std::filesystem::create_symlink("leds", link);
  EXPECT_EQ(led_reference_write(link.c_str(), &bench.test.reference, error), LAM_HARDWARE);
  std::ofstream(place / "leds") << "an older one";
  EXPECT_EQ(led_reference_write(link.c_str(), &bench.test.reference, error), LAM_OK) << error;
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_GT(std::filesystem::file_size(place / "leds"), 1000u);
  std::filesystem::remove_all(place);
}

TEST(LedReference, ComesBackFromItsFileAndADamagedOneIsRefused) {
  SelftestBench bench;
  bench.learn();
  char folder[] = "/tmp/lamella-reference-XXXXXX";
  const std::string path = std::string(mkdtemp(folder)) + "/leds.reference";
  static struct led_reference read;
  char error[112] = "";
  EXPECT_EQ(led_reference_read(path.c_str(), 150, &read, error), LAM_OK);
  EXPECT_EQ(read.led_count, 0u);
  ASSERT_EQ(led_reference_write(path.c_str(), &bench.test.reference, error), LAM_OK) << error;
  EXPECT_EQ(led_reference_read(path.c_str(), 150, &read, error), LAM_OK);
  EXPECT_EQ(read.led_count, 150u);
  EXPECT_NEAR(led_signature_distance(&read.leds[9], &bench.test.reference.leds[9]), 0, 1e-4);
  EXPECT_EQ(led_reference_read(path.c_str(), 149, &read, error), LAM_BAD_INPUT);
  std::fstream(path, std::ios::in | std::ios::out | std::ios::binary).seekp(500).put('\x7F');
  EXPECT_EQ(led_reference_read(path.c_str(), 150, &read, error), LAM_BAD_INPUT);
  EXPECT_EQ(read.led_count, 0u);
  EXPECT_EQ(led_reference_write("/nowhere/leds", &bench.test.reference, error), LAM_HARDWARE);
  std::filesystem::remove_all(folder);
}
