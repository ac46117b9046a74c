// CRC32C (Castagnoli, reflected): of "123456789" it is 0xE3069283.
#ifndef LAMELLA_FIRMWARE_CRC32C_H
#define LAMELLA_FIRMWARE_CRC32C_H

#include <stddef.h>
#include <stdint.h>

// Goes on from the CRC of what came before; 0 to begin.
uint32_t crc32c_extend(uint32_t crc, const uint8_t* bytes, size_t count);

#endif
