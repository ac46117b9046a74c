// Any bytes as the rows of a camera's frame, of any format and size: packed without a look beyond
// them, to as many bytes as a photograph has.
#include <stdlib.h>
#include <string.h>

#include "raw_pixels.h"

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static const char* const kNames[] = {"GREY", "Y10", "Y10P",     "Y12",
                                       "Y12P", "Y16", "SRGGB10P", "SBGGR12P"};
  if (size < 4) return 0;
  const struct raw_format* format = raw_format_find(kNames[bytes[0] % 8]);
  const size_t shape[2] = {bytes[1] + 1u, bytes[2] % 16 + 1u};
  const size_t row_bytes = raw_row_bytes(format, shape[0]);
  const size_t stride = row_bytes + bytes[3] % 8;
  const size_t needed = stride * (shape[1] - 1) + row_bytes;
  if (size - 4 < needed) return 0;
  // Exactly what is needed, so that a byte beyond it is noticed.
  uint8_t* rows = malloc(needed);
  uint8_t* stored = malloc(raw_stored_bytes(shape[0], shape[1]));
  if (rows == NULL || stored == NULL) abort();
  memcpy(rows, bytes + 4, needed);
  if (raw_pack(format, rows, stride, shape, stored) != raw_stored_bytes(shape[0], shape[1])) {
    abort();
  }
  free(stored);
  free(rows);
  return 0;
}
