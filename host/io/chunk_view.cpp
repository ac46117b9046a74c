#include "io/chunk_view.h"

#include <google/protobuf/io/coded_stream.h>

#include "link.pb.h"

namespace lamella {

namespace {

using google::protobuf::io::CodedInputStream;

constexpr uint32_t kVarint = 0, kBytes = 2;

constexpr uint32_t tag(int field, uint32_t type) { return uint32_t(field) << 3 | type; }

// The rest of the input as bytes after their length; false where the length is another.
bool read_rest(std::span<const uint8_t> all, CodedInputStream* input,
               std::span<const uint8_t>* rest) {
  uint32_t size = 0;
  if (!input->ReadVarint32(&size)) return false;
  const size_t at = size_t(input->CurrentPosition());
  *rest = all.subspan(at);
  return rest->size() == size;
}

// Where a field that is a number goes; `ignored` for one that nobody asks for.
uint32_t* place_of(uint32_t field, ChunkView* chunk, uint32_t* ignored) {
  switch (field) {
    case tag(v1::Chunk::kBurstIdFieldNumber, kVarint):
      return ignored;
    case tag(v1::Chunk::kFrameIdFieldNumber, kVarint):
      return &chunk->frame_id;
    case tag(v1::Chunk::kSequenceFieldNumber, kVarint):
      return &chunk->sequence;
    case tag(v1::Chunk::kOffsetBytesFieldNumber, kVarint):
      return &chunk->offset_bytes;
    case tag(v1::Chunk::kTotalBytesFieldNumber, kVarint):
      return &chunk->total_bytes;
    case tag(v1::Chunk::kCrc32CFieldNumber, kVarint):
      return &chunk->crc32c;
    default:
      return nullptr;
  }
}

bool view_fields(std::span<const uint8_t> bytes, ChunkView* chunk) {
  CodedInputStream input(bytes.data(), int(bytes.size()));
  uint32_t ignored = 0;
  while (const uint32_t field = input.ReadTag()) {
    if (field == tag(v1::Chunk::kDataFieldNumber, kBytes)) {
      return read_rest(bytes, &input, &chunk->data);
    }
    uint32_t* place = place_of(field, chunk, &ignored);
    if (!place || !input.ReadVarint32(place)) return false;
  }
  return input.ConsumedEntireMessage();
}

}  // namespace

bool view_chunk(std::span<const uint8_t> reply, ChunkView* chunk) {
  CodedInputStream input(reply.data(), int(reply.size()));
  *chunk = {};
  std::span<const uint8_t> inside;
  return input.ReadTag() == tag(v1::Reply::kRequestIdFieldNumber, kVarint) &&
         input.ReadVarint32(&chunk->request_id) &&
         input.ReadTag() == tag(v1::Reply::kChunkFieldNumber, kBytes) &&
         read_rest(reply, &input, &inside) && view_fields(inside, chunk);
}

}  // namespace lamella
