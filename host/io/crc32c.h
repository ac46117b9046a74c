// CRC32C (Castagnoli): of every chunk and every photograph on the link, and of the twin's answers.
#pragma once

#include <cstddef>
#include <cstdint>

namespace lamella {

// CRC of `size` bytes. `previous` is the CRC of the bytes before them, 0 where there are none.
uint32_t crc32c(const void* data, size_t size, uint32_t previous = 0);

// CRC of two parts, from the CRC of each. Quick where the second part is often as long as the last
// time.
uint32_t crc32c_of_parts(uint32_t first, uint32_t second, size_t second_size);

}  // namespace lamella
