// Framing on every socket: 4-byte little-endian length, then one protobuf message.
#ifndef LAMELLA_FIRMWARE_WIRE_H
#define LAMELLA_FIRMWARE_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { WIRE_LENGTH_BYTES = 4, WIRE_MAX_MESSAGE_BYTES = 65536 };

static inline void wire_put_length(uint8_t at[WIRE_LENGTH_BYTES], size_t length) {
  for (int i = 0; i < WIRE_LENGTH_BYTES; i++) at[i] = (uint8_t)(length >> (8 * i));
}

// False where no message can be this long; nothing after it on the stream can be understood.
static inline bool wire_get_length(const uint8_t at[WIRE_LENGTH_BYTES], size_t* length) {
  *length = (size_t)at[0] | (size_t)at[1] << 8 | (size_t)at[2] << 16 | (size_t)at[3] << 24;
  return *length > 0 && *length <= WIRE_MAX_MESSAGE_BYTES;
}

#endif
