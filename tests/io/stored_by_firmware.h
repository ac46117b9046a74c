// Bursts on a disk as the firmware itself writes them: frames of `frame_bytes` bytes, each all of
// its own number.
#ifndef LAMELLA_TESTS_IO_STORED_BY_FIRMWARE_H
#define LAMELLA_TESTS_IO_STORED_BY_FIRMWARE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// A burst of so many photographs into `folder`; where `why` is not NULL it is not whole. The first
// `acknowledged` of them are on a host. Its id, or 0.
uint64_t stored_by_firmware(const char* folder, uint32_t frames, size_t frame_bytes,
                            const char* why, uint32_t acknowledged);

// What the daemon says of the burst when it starts: whole and "", or the reason.
int explained_by_firmware(const char* folder, uint64_t burst_id, char why[160]);

#ifdef __cplusplus
}
#endif

#endif
