#include "io/crc32c.h"

#include <array>
#include <bit>
#include <cstring>

namespace lamella {

namespace {

static_assert(std::endian::native == std::endian::little, "eight bytes are folded at a time");

constexpr uint32_t kPolynomial = 0x82f63b78;  // 0x1edc6f41, bits reversed

using Tables = std::array<std::array<uint32_t, 256>, 8>;

// tables[k][b] is the CRC of byte b followed by k zero bytes ("slicing by eight").
constexpr Tables make_tables() {
  Tables tables{};
  for (uint32_t b = 0; b < 256; ++b) {
    uint32_t crc = b;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? kPolynomial : 0);
    tables[0][b] = crc;
  }
  for (size_t k = 1; k < 8; ++k) {
    for (uint32_t b = 0; b < 256; ++b) {
      const uint32_t crc = tables[k - 1][b];
      tables[k][b] = (crc >> 8) ^ tables[0][crc & 0xff];
    }
  }
  return tables;
}

constexpr Tables kTables = make_tables();

uint32_t fold_eight(uint32_t crc, const unsigned char* bytes) {
  uint64_t word;
  std::memcpy(&word, bytes, 8);
  word ^= crc;
  crc = 0;
  for (int k = 0; k < 8; ++k) crc ^= kTables[7 - k][(word >> (8 * k)) & 0xff];
  return crc;
}

#if defined(__x86_64__)

// The processor's own instruction takes eight bytes every three cycles, and can do three sums at
// once: each block of three is summed from 0, and moved past the next ones by a table.
constexpr size_t kBlock = 1360;

using PastBlock = std::array<std::array<uint32_t, 256>, 4>;

// What a sum becomes when a block of zeros follows is linear in its bits.
PastBlock make_past_block() {
  PastBlock past;
  for (uint32_t k = 0; k < 4; ++k) {
    for (uint32_t i = 0; i < 256; ++i) {
      uint32_t crc = i << (8 * k);
      for (size_t zero = 0; zero < kBlock; ++zero) crc = (crc >> 8) ^ kTables[0][crc & 0xff];
      past[k][i] = crc;
    }
  }
  return past;
}

uint32_t move_past_block(uint32_t crc) {
  static const PastBlock past = make_past_block();
  return past[0][crc & 0xff] ^ past[1][(crc >> 8) & 0xff] ^ past[2][(crc >> 16) & 0xff] ^
         past[3][crc >> 24];
}

__attribute__((target("sse4.2"))) uint64_t sum_eight(uint64_t crc, const unsigned char* bytes) {
  uint64_t word;
  std::memcpy(&word, bytes, 8);
  return __builtin_ia32_crc32di(crc, word);
}

__attribute__((target("sse4.2"))) uint32_t sum_blocks(uint32_t crc, const unsigned char* bytes) {
  uint64_t first = crc, second = 0, third = 0;
  for (size_t at = 0; at < kBlock; at += 8) {
    first = sum_eight(first, bytes + at);
    second = sum_eight(second, bytes + kBlock + at);
    third = sum_eight(third, bytes + 2 * kBlock + at);
  }
  return move_past_block(move_past_block(uint32_t(first)) ^ uint32_t(second)) ^ uint32_t(third);
}

// As many bytes as make whole threes of blocks.
size_t sum_by_hardware(uint32_t* crc, const unsigned char* bytes, size_t size) {
  size_t done = 0;
  if (!__builtin_cpu_supports("sse4.2")) return done;
  for (; size - done >= 3 * kBlock; done += 3 * kBlock) *crc = sum_blocks(*crc, bytes + done);
  return done;
}

#else

size_t sum_by_hardware(uint32_t*, const unsigned char*, size_t) { return 0; }

#endif

}  // namespace

uint32_t crc32c(const void* data, size_t size, uint32_t previous) {
  const unsigned char* bytes = static_cast<const unsigned char*>(data);
  uint32_t crc = ~previous;
  const size_t done = sum_by_hardware(&crc, bytes, size);
  bytes += done;
  size -= done;
  for (; size >= 8; size -= 8, bytes += 8) crc = fold_eight(crc, bytes);
  for (; size > 0; --size, ++bytes) crc = (crc >> 8) ^ kTables[0][(crc ^ *bytes) & 0xff];
  return ~crc;
}

namespace {

// Polynomials over two elements, the highest power in bit 0, modulo the CRC's.
uint32_t product(uint32_t a, uint32_t b) {
  uint32_t sum = 0;
  for (; a != 0; a <<= 1) {
    if (a & 0x80000000) sum ^= b;
    b = (b >> 1) ^ (b & 1 ? kPolynomial : 0);
  }
  return sum;
}

// x to the power of 8 times `bytes`: what so many bytes multiply the CRC before them by.
uint32_t power_of(size_t bytes) {
  uint32_t power = 0x80000000, square = 0x00800000;  // 1, x^8
  for (; bytes != 0; bytes >>= 1) {
    if (bytes & 1) power = product(power, square);
    square = product(square, square);
  }
  return power;
}

}  // namespace

uint32_t crc32c_of_parts(uint32_t first, uint32_t second, size_t second_size) {
  thread_local size_t size = 0;
  thread_local uint32_t power = 0x80000000;
  if (size != second_size) power = power_of(size = second_size);
  return product(power, first) ^ second;
}

}  // namespace lamella
