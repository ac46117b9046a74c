#include "raw_pixels.h"

#include <stdbool.h>
#include <string.h>

enum { kStoredBits = 12 };

#define FOURCC(a, b, c, d) \
  ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)
#define FOUR_ORDERS(bits, suffix, packing, f1, f2, f3, f4)    \
  {"SRGGB" #bits suffix, "RGGB12P", f1, bits, packing},       \
      {"SGRBG" #bits suffix, "GRBG12P", f2, bits, packing},   \
      {"SGBRG" #bits suffix, "GBRG12P", f3, bits, packing}, { \
    "SBGGR" #bits suffix, "BGGR12P", f4, bits, packing        \
  }

static const struct raw_format kFormats[] = {
    {"GREY", "GREY12P", FOURCC('G', 'R', 'E', 'Y'), 8, RAW_BYTES},
    {"Y10", "GREY12P", FOURCC('Y', '1', '0', ' '), 10, RAW_WORDS},
    {"Y10P", "GREY12P", FOURCC('Y', '1', '0', 'P'), 10, RAW_CSI2_10},
    {"Y12", "GREY12P", FOURCC('Y', '1', '2', ' '), 12, RAW_WORDS},
    {"Y12P", "GREY12P", FOURCC('Y', '1', '2', 'P'), 12, RAW_CSI2_12},
    {"Y16", "GREY12P", FOURCC('Y', '1', '6', ' '), 16, RAW_WORDS},
    FOUR_ORDERS(8, "", RAW_BYTES, FOURCC('R', 'G', 'G', 'B'), FOURCC('G', 'R', 'B', 'G'),
                FOURCC('G', 'B', 'R', 'G'), FOURCC('B', 'A', '8', '1')),
    FOUR_ORDERS(10, "", RAW_WORDS, FOURCC('R', 'G', '1', '0'), FOURCC('B', 'A', '1', '0'),
                FOURCC('G', 'B', '1', '0'), FOURCC('B', 'G', '1', '0')),
    FOUR_ORDERS(10, "P", RAW_CSI2_10, FOURCC('p', 'R', 'A', 'A'), FOURCC('p', 'g', 'A', 'A'),
                FOURCC('p', 'G', 'A', 'A'), FOURCC('p', 'B', 'A', 'A')),
    FOUR_ORDERS(12, "", RAW_WORDS, FOURCC('R', 'G', '1', '2'), FOURCC('B', 'A', '1', '2'),
                FOURCC('G', 'B', '1', '2'), FOURCC('B', 'G', '1', '2')),
    FOUR_ORDERS(12, "P", RAW_CSI2_12, FOURCC('p', 'R', 'C', 'C'), FOURCC('p', 'g', 'C', 'C'),
                FOURCC('p', 'G', 'C', 'C'), FOURCC('p', 'B', 'C', 'C')),
    FOUR_ORDERS(16, "", RAW_WORDS, FOURCC('R', 'G', '1', '6'), FOURCC('G', 'R', '1', '6'),
                FOURCC('G', 'B', '1', '6'), FOURCC('B', 'Y', 'R', '2')),
};
enum { kFormatCount = sizeof kFormats / sizeof kFormats[0] };

const struct raw_format* raw_format_find(const char* name) {
  for (size_t i = 0; i < kFormatCount; i++) {
    if (strcmp(kFormats[i].name, name) == 0) return &kFormats[i];
  }
  return NULL;
}

const struct raw_format* raw_format_of_fourcc(uint32_t fourcc) {
  for (size_t i = 0; i < kFormatCount; i++) {
    if (kFormats[i].fourcc == fourcc) return &kFormats[i];
  }
  return NULL;
}

size_t raw_row_bytes(const struct raw_format* format, size_t width) {
  switch (format->packing) {
    case RAW_BYTES:
      return width;
    case RAW_WORDS:
      return width * 2;
    case RAW_CSI2_10:
      return (width + 3) / 4 * 5;
    case RAW_CSI2_12:
      return (width + 1) / 2 * 3;
  }
  return 0;
}

size_t raw_stored_bytes(size_t width, size_t height) { return (width * height + 1) / 2 * 3; }

// One row's samples, of as many bits as the format has.
static void read_row(const struct raw_format* format, const uint8_t* row, size_t width,
                     uint16_t samples[]) {
  for (size_t x = 0; x < width; x++) {
    switch (format->packing) {
      case RAW_BYTES:
        samples[x] = row[x];
        break;
      case RAW_WORDS:
        samples[x] = (uint16_t)(row[2 * x] | row[2 * x + 1] << 8);
        break;
      case RAW_CSI2_10: {
        const uint8_t* group = row + x / 4 * 5;
        samples[x] = (uint16_t)(group[x % 4] << 2 | (group[4] >> 2 * (x % 4) & 3));
        break;
      }
      case RAW_CSI2_12: {
        const uint8_t* group = row + x / 2 * 3;
        samples[x] = (uint16_t)(group[x % 2] << 4 | (group[2] >> 4 * (x % 2) & 15));
        break;
      }
    }
  }
}

// A word may have rubbish above its sample.
static uint16_t to_twelve_bits(const struct raw_format* format, uint16_t sample) {
  if (format->bits >= kStoredBits) return (sample >> (format->bits - kStoredBits)) & 0xfff;
  return (uint16_t)(sample << (kStoredBits - format->bits)) & 0xfff;
}

// Samples run on from row to row: where a row ends in the middle of a pair, the next completes it.
struct packer {
  uint8_t* to;
  bool halfway;
};

static void put_sample(struct packer* packer, uint16_t sample) {
  if (packer->halfway) {
    packer->to[1] |= (uint8_t)(sample << 4);
    packer->to[2] = (uint8_t)(sample >> 4);
    packer->to += 3;
  } else {
    packer->to[0] = (uint8_t)sample;
    packer->to[1] = (uint8_t)(sample >> 8);
    packer->to[2] = 0;
  }
  packer->halfway = !packer->halfway;
}

size_t raw_pack(const struct raw_format* format, const uint8_t* rows, size_t stride_bytes,
                const size_t size[2], uint8_t* stored) {
  uint16_t samples[RAW_MAX_WIDTH_PX];
  struct packer packer = {.to = stored};
  for (size_t y = 0; y < size[1]; y++) {
    read_row(format, rows + y * stride_bytes, size[0], samples);
    for (size_t x = 0; x < size[0]; x++) {
      put_sample(&packer, to_twelve_bits(format, samples[x]));
    }
  }
  return raw_stored_bytes(size[0], size[1]);
}
