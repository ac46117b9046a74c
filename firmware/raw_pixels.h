// Sensor values as cameras hand them over, and as the rig keeps them: 12 bits a sample, two samples
// in three bytes (proto/PROTOCOL.md, "Raw photographs"). Fewer bits are shifted up, so that full
// scale is nearly 4095 whatever the sensor; of 16 bits the upper 12 are kept.
#ifndef LAMELLA_FIRMWARE_RAW_PIXELS_H
#define LAMELLA_FIRMWARE_RAW_PIXELS_H

#include <stddef.h>
#include <stdint.h>

enum { RAW_MAX_WIDTH_PX = 16384 };

enum raw_packing {
  RAW_BYTES,    // 8 bits, a byte each
  RAW_WORDS,    // little-endian 16-bit words, the sample in their low bits
  RAW_CSI2_10,  // four samples' high bytes, then a byte with their low bits
  RAW_CSI2_12,  // two samples' high bytes, then a byte with their low bits
};

struct raw_format {
  const char* name;    // as the kernel's V4L2_PIX_FMT_ says it: "Y10P", "SRGGB12"
  const char* stored;  // pixel_format of what raw_pack() makes: "GREY12P", "RGGB12P"
  uint32_t fourcc;     // of V4L2
  uint8_t bits;
  enum raw_packing packing;
};

// NULL where there is no such format.
const struct raw_format* raw_format_find(const char* name);
const struct raw_format* raw_format_of_fourcc(uint32_t fourcc);

// Bytes of one row of `format` that has no padding.
size_t raw_row_bytes(const struct raw_format* format, size_t width);

// Bytes of a stored photograph.
size_t raw_stored_bytes(size_t width, size_t height);

// Packs `height` rows that begin every `stride_bytes`; width is at most RAW_MAX_WIDTH_PX. A row's
// bytes beyond raw_row_bytes() are not read. Returns the bytes written: raw_stored_bytes().
size_t raw_pack(const struct raw_format* format, const uint8_t* rows, size_t stride_bytes,
                const size_t size[2], uint8_t* stored);

#endif
