#include "store_record.h"

#include <pb_decode.h>
#include <pb_encode.h>
#include <string.h>

#include "crc32c.h"

enum { kHeadBytes = 8, kCrcBytes = 4 };
static const uint8_t kMagic[4] = {'L', 'M', 'R', '1'};

static void put_u32(uint8_t at[4], uint32_t value) {
  for (int i = 0; i < 4; i++) at[i] = (uint8_t)(value >> (8 * i));
}

static uint32_t get_u32(const uint8_t at[4]) {
  return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

size_t record_put(const pb_msgdesc_t* fields, const void* message, uint8_t* to, size_t room) {
  if (room < RECORD_OVERHEAD_BYTES) return 0;
  pb_ostream_t stream = pb_ostream_from_buffer(to + kHeadBytes, room - RECORD_OVERHEAD_BYTES);
  if (!pb_encode(&stream, fields, message)) return 0;
  memcpy(to, kMagic, sizeof kMagic);
  put_u32(to + sizeof kMagic, (uint32_t)stream.bytes_written);
  const size_t checked = kHeadBytes + stream.bytes_written;
  put_u32(to + checked, crc32c_extend(0, to, checked));
  return checked + kCrcBytes;
}

size_t record_get(const pb_msgdesc_t* fields, void* message, const uint8_t* bytes, size_t size) {
  if (size < RECORD_OVERHEAD_BYTES || memcmp(bytes, kMagic, sizeof kMagic) != 0) return 0;
  const uint32_t length = get_u32(bytes + sizeof kMagic);
  if (length > size - RECORD_OVERHEAD_BYTES) return 0;
  const size_t checked = kHeadBytes + length;
  if (get_u32(bytes + checked) != crc32c_extend(0, bytes, checked)) return 0;
  pb_istream_t stream = pb_istream_from_buffer(bytes + kHeadBytes, length);
  return pb_decode(&stream, fields, message) ? checked + kCrcBytes : 0;
}
