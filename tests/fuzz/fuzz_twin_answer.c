// Any bytes from whoever answers on the twin's socket: a photograph that fits its room and its
// checksum, or a line of text. The last byte says how large the room is.
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "crc32c.h"
#include "hal_sim_twin.h"

static uint8_t room[256];

static void require(bool holds) {
  if (!holds) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static const lamella_v1_ExposureReport kReport = lamella_v1_ExposureReport_init_zero;
  struct hal_photograph photograph = {.bytes = room};
  int ends[2];
  if (size < 1) return 0;
  photograph.capacity = bytes[size - 1];
  require(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
  require(send(ends[1], bytes, size - 1, 0) == (ssize_t)(size - 1));
  shutdown(ends[1], SHUT_WR);
  if (sim_twin_photograph(ends[0], &kReport, &photograph)) {
    const size_t count = photograph.header.size_bytes;
    require(count <= photograph.capacity);
    require(crc32c_extend(0, room, count) == photograph.header.crc32c);
  } else {
    require(photograph.error[0] != '\0');
    require(memchr(photograph.error, '\0', sizeof photograph.error) != NULL);
  }
  close(ends[0]);
  close(ends[1]);
  return 0;
}
