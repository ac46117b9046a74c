#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "test_rig.h"

extern "C" {
#include "crc32c.h"
#include "hal_sim_chain.h"
#include "led_chain.h"
}

namespace {

std::vector<uint16_t> random_codes(size_t count) {
  std::mt19937 random(7);
  std::vector<uint16_t> codes(count);
  for (uint16_t& code : codes) code = random() % 4096;
  return codes;
}

std::vector<uint16_t> decoded(const struct rig& rig, const uint8_t* stream) {
  struct sim_chain chain = {};
  sim_chain_shift(&chain, stream, CHAIN_BITS, nullptr);
  sim_chain_latch(&chain, true);
  std::vector<uint16_t> codes;
  for (size_t i = 0; i < rig.led_count; i++) {
    codes.push_back(sim_chain_code(&chain, rig.leds[i].chip, rig.leds[i].output));
  }
  return codes;
}

}  // namespace

TEST(LedChain, CodesSurviveTheWayThroughTheShiftRegister) {
  const struct rig rig = test_rig();
  const std::vector<uint16_t> codes = random_codes(rig.led_count);
  uint8_t stream[CHAIN_BYTES];
  led_chain_encode(&rig, codes.data(), stream);
  EXPECT_EQ(decoded(rig, stream), codes);
}

TEST(LedChain, SendsLastChipOutput23MostSignificantBitFirst) {
  struct rig rig = {};
  rig.led_count = 2;
  rig.leds[0] = {6, 23, {0, 0, 1}};
  rig.leds[1] = {0, 0, {0, 0, 1}};
  const uint16_t codes[] = {0x800, 0x001};
  uint8_t stream[CHAIN_BYTES];
  led_chain_encode(&rig, codes, stream);
  EXPECT_EQ(stream[0], 0x80);                // the very first bit
  EXPECT_EQ(stream[CHAIN_BYTES - 1], 0x01);  // the very last
  for (int i = 1; i < CHAIN_BYTES - 1; i++) EXPECT_EQ(stream[i], 0) << i;
}

TEST(LedChain, BitOfChipOutputAndWeightIsAtItsClosedFormPlace) {
  for (const int chip : {0, 3, 6}) {
    for (const int output : {0, 11, 23}) {
      for (const int weight : {0, 5, 11}) {
        struct rig rig = {};
        rig.led_count = 1;
        rig.leds[0] = {static_cast<uint8_t>(chip), static_cast<uint8_t>(output), {0, 0, 1}};
        const uint16_t code = 1u << weight;
        uint8_t stream[CHAIN_BYTES];
        led_chain_encode(&rig, &code, stream);
        const int place = (6 - chip) * 288 + (23 - output) * 12 + (11 - weight);
        EXPECT_EQ(stream[place / 8], 0x80 >> place % 8);
      }
    }
  }
}

TEST(LedChain, UnusedOutputsAreDark) {
  const struct rig rig = test_rig();
  const std::vector<uint16_t> codes(rig.led_count, 4095);
  uint8_t stream[CHAIN_BYTES];
  led_chain_encode(&rig, codes.data(), stream);
  int ones = 0;
  for (const uint8_t byte : stream) ones += __builtin_popcount(byte);
  EXPECT_EQ(ones, 150 * 12);
}

TEST(LedChain, OneFlippedBitChangesOneLevel) {
  const struct rig rig = test_rig();
  const std::vector<uint16_t> codes = random_codes(rig.led_count);
  uint8_t stream[CHAIN_BYTES];
  led_chain_encode(&rig, codes.data(), stream);
  for (int bit = 0; bit < CHAIN_BITS; bit += 13) {
    uint8_t wrong[CHAIN_BYTES];
    std::copy(stream, stream + CHAIN_BYTES, wrong);
    wrong[bit / 8] ^= 0x80 >> bit % 8;
    const std::vector<uint16_t> seen = decoded(rig, wrong);
    int changed = 0;
    for (size_t i = 0; i < codes.size(); i++) {
      if (seen[i] == codes[i]) continue;
      changed++;
      EXPECT_EQ(seen[i] ^ codes[i], 1 << (11 - bit % 12));
    }
    const int chip = 6 - bit / 288, output = 23 - bit % 288 / 12;
    bool used = false;
    for (size_t i = 0; i < rig.led_count; i++) {
      used |= rig.leds[i].chip == chip && rig.leds[i].output == output;
    }
    EXPECT_EQ(changed, used ? 1 : 0) << bit;
  }
}

TEST(LedChain, BitsShiftedInPieceByPieceEndWhereOneShiftPutsThem) {
  const struct rig rig = test_rig();
  uint8_t stream[CHAIN_BYTES];
  led_chain_encode(&rig, random_codes(rig.led_count).data(), stream);
  struct sim_chain whole = {}, pieces = {};
  sim_chain_shift(&whole, stream, CHAIN_BITS, nullptr);
  for (int at = 0; at < CHAIN_BYTES; at += 36)
    sim_chain_shift(&pieces, stream + at, 36 * 8, nullptr);
  EXPECT_TRUE(std::equal(whole.cells, whole.cells + CHAIN_BITS, pieces.cells));
}

TEST(LedChain, NothingShinesUntilLatch) {
  struct sim_chain chain = {};
  const uint8_t stream[CHAIN_BYTES] = {0xFF, 0xF0};
  sim_chain_shift(&chain, stream, CHAIN_BITS, nullptr);
  EXPECT_EQ(sim_chain_code(&chain, 6, 23), 0);
  sim_chain_latch(&chain, true);
  EXPECT_EQ(sim_chain_code(&chain, 6, 23), 4095);
}

TEST(Crc32c, OfTheCheckStringIsTheCheckValue) {
  const uint8_t text[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc32c_extend(0, text, 9), 0xE3069283u);
}

TEST(Crc32c, GoesOnFromWhereItStopped) {
  std::vector<uint8_t> bytes(1001);
  for (size_t i = 0; i < bytes.size(); i++) bytes[i] = static_cast<uint8_t>(i * 37);
  const uint32_t whole = crc32c_extend(0, bytes.data(), bytes.size());
  for (const size_t cut : {0u, 1u, 13u, 1000u}) {
    const uint32_t first = crc32c_extend(0, bytes.data(), cut);
    EXPECT_EQ(crc32c_extend(first, bytes.data() + cut, bytes.size() - cut), whole);
  }
}

TEST(SimChain, PushesOutWhatItHeldBefore) {
  uint8_t first[CHAIN_BYTES], second[CHAIN_BYTES], out[CHAIN_BYTES];
  for (int i = 0; i < CHAIN_BYTES; i++) {
    first[i] = uint8_t(i * 37 + 11);
    second[i] = uint8_t(i * 91 + 5);
  }
  struct sim_chain chain = {};
  sim_chain_shift(&chain, first, CHAIN_BITS, nullptr);
  sim_chain_shift(&chain, second, CHAIN_BITS, out);
  EXPECT_EQ(memcmp(out, first, CHAIN_BYTES), 0);
}
