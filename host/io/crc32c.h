// CRC32C (Castagnoli): of every chunk and every photograph on the link, and of the twin's answers.
#pragma once

#include <cstddef>
#include <cstdint>

namespace lamella {

// CRC of `size` bytes. `previous` is the CRC of the bytes before them, 0 where there are none.
uint32_t crc32c(const void* data, size_t size, uint32_t previous = 0);

}  // namespace lamella
