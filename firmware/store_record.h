// One message in a file: "LMR1", its length and its bytes, then the CRC32C of all that. What a
// power cut leaves of a file is somebody else's bytes: a torn record is none.
#ifndef LAMELLA_FIRMWARE_STORE_RECORD_H
#define LAMELLA_FIRMWARE_STORE_RECORD_H

#include <pb.h>
#include <stddef.h>
#include <stdint.h>

enum { RECORD_OVERHEAD_BYTES = 12, RECORD_MAX_BYTES = 8192 };

// Size of the record put into `room` bytes at `to`; 0 where it does not fit.
size_t record_put(const pb_msgdesc_t* fields, const void* message, uint8_t* to, size_t room);

// Reads the record at the front of `bytes`. Its size; 0 where there is no whole, sound one.
size_t record_get(const pb_msgdesc_t* fields, void* message, const uint8_t* bytes, size_t size);

#endif
