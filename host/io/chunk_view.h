// A chunk of a photograph, read where it lies: what a message of libprotobuf would copy is most of
// what comes over the link.
#pragma once

#include <cstdint>
#include <span>

namespace lamella {

struct ChunkView {
  uint32_t request_id = 0;
  uint32_t frame_id = 0, sequence = 0, offset_bytes = 0, total_bytes = 0, crc32c = 0;
  std::span<const uint8_t> data;
};

// False where the message is no Reply with a chunk and nothing else, its fields known and in order:
// libprotobuf may still make sense of it.
bool view_chunk(std::span<const uint8_t> reply, ChunkView* chunk);

}  // namespace lamella
