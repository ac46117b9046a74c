// LinkClient's transfer of calibrations and photographs: chunks in sequence, each checked, gone on
// with over a new connection.
#include "base/error.h"
#include "io/crc32c.h"
#include "io/link_client.h"

namespace lamella {

namespace {

constexpr size_t kMaxBlobBytes = 256u << 20;

}  // namespace

// A transfer under way. `bytes` holds what has arrived and been checked.
struct LinkClient::Blob {
  std::string name;
  v1::BlobQuery query;
  size_t total = 0;  // 0: the first chunk says
  std::vector<uint8_t> bytes;
  uint32_t crc32c = 0;  // of those that came
  std::function<void(std::span<const uint8_t>)> arrived = [](std::span<const uint8_t>) {};
};

std::string LinkClient::calibration(const Burst& burst) {
  Blob blob{"its calibration", {}, 0, {}};
  blob.query.set_kind(v1::BlobQuery::CALIBRATION);
  blob.query.set_burst_id(burst.id);
  fetch(&blob);
  return {blob.bytes.begin(), blob.bytes.end()};
}

std::vector<uint8_t> LinkClient::photograph(const v1::FrameOffer& offer) {
  for (int attempt = 0; attempt <= options_.retries; ++attempt) {
    Blob blob{describe(offer), {}, offer.size_bytes(), {}};
    blob.query.set_kind(v1::BlobQuery::PHOTOGRAPH);
    blob.query.set_burst_id(offer.burst_id());
    blob.query.set_frame_id(offer.frame_id());
    fetch(&blob);
    if (blob.crc32c == offer.crc32c()) return std::move(blob.bytes);
  }
  fail(describe(offer) + " has another CRC32C than the rig announced, each time it was sent",
       "the rig's memory or disk is damaged");
}

void LinkClient::continue_photograph(const v1::FrameOffer& offer, std::vector<uint8_t>* bytes,
                                     const std::function<void(std::span<const uint8_t>)>& arrived) {
  if (bytes->size() >= offer.size_bytes() && !bytes->empty()) return;
  Blob blob{describe(offer), {}, offer.size_bytes(), std::move(*bytes), 0, arrived};
  blob.query.set_kind(v1::BlobQuery::PHOTOGRAPH);
  blob.query.set_burst_id(offer.burst_id());
  blob.query.set_frame_id(offer.frame_id());
  fetch(&blob);
  *bytes = std::move(blob.bytes);
}

void LinkClient::fetch(Blob* blob) {
  persist({[&] { return continue_blob(blob); }, [&] { return blob->bytes.size(); },
           [&] {
             const std::string total = blob->total ? " of " + std::to_string(blob->total) : "";
             return "link cut in " + blob->name + " at byte " + std::to_string(blob->bytes.size()) +
                    total;
           },
           after_a_cut()});
}

Break LinkClient::continue_blob(Blob* blob) {
  v1::Request request;
  *request.mutable_blob() = blob->query;
  request.mutable_blob()->set_offset_bytes(uint32_t(blob->bytes.size()));
  request.set_request_id(++request_id_);
  if (Break broken = socket_.send(request, deadline_in(options_.reply_s))) return broken;
  uint32_t sequence = 0;
  do {
    if (Break broken = next_chunk(blob, sequence++)) return broken;
  } while (blob->bytes.size() < blob->total);
  return {};
}

// The next reply, which is to be a chunk; `reply` is where it lies if libprotobuf had to read it.
Break LinkClient::receive_chunk(ChunkView* chunk, v1::Reply* reply) {
  std::span<const uint8_t> message;
  if (Break broken = socket_.receive(&message, deadline_in(options_.reply_s))) return broken;
  if (view_chunk(message, chunk)) return {};
  if (!reply->ParseFromArray(message.data(), int(message.size()))) return "sent what is no message";
  chunk->request_id = reply->request_id();
  if (reply->request_id() == request_id_ || reply->request_id() == 0) throw_refusal(*reply);
  if (reply->request_id() != request_id_) return {};
  if (!reply->has_chunk()) return "something else came instead of a chunk";
  const v1::Chunk& c = reply->chunk();
  const auto* data = reinterpret_cast<const uint8_t*>(c.data().data());
  *chunk = {reply->request_id(), c.frame_id(), c.sequence(),           c.offset_bytes(),
            c.total_bytes(),     c.crc32c(),   {data, c.data().size()}};
  return {};
}

// A chunk that is not exactly the next one is as good as a broken connection.
Break LinkClient::next_chunk(Blob* blob, uint32_t sequence) {
  v1::Reply reply;
  ChunkView chunk;
  do {  // an event may come first
    if (Break broken = receive_chunk(&chunk, &reply)) return broken;
  } while (chunk.request_id != request_id_);
  if (blob->total == 0) blob->total = chunk.total_bytes;
  if (blob->total > kMaxBlobBytes)
    fail(blob->name + " has " + std::to_string(blob->total) + " bytes");
  if (chunk.total_bytes != blob->total) return "a chunk of something of another size";
  if (chunk.frame_id != blob->query.frame_id()) return "a chunk of another frame";
  if (chunk.sequence != sequence || chunk.offset_bytes != blob->bytes.size()) {
    return "a chunk out of sequence";
  }
  const std::span<const uint8_t> data = chunk.data;
  if (data.empty() || data.size() > blob->total - blob->bytes.size()) return "a chunk of no use";
  if (crc32c(data.data(), data.size()) != chunk.crc32c) return "a damaged chunk";
  if (blob->bytes.empty()) blob->bytes.reserve(blob->total);
  blob->bytes.insert(blob->bytes.end(), data.begin(), data.end());
  blob->crc32c = crc32c_of_parts(blob->crc32c, chunk.crc32c, data.size());
  blob->arrived(data);
  return {};
}

}  // namespace lamella
