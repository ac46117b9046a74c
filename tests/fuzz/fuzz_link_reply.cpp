// A rig that answers anything: raw bytes, or well-formed replies with any numbers in them. The host
// takes what it can use, or gives up with one line.
#include <arpa/inet.h>
#include <fuzzer/FuzzedDataProvider.h>
#include <google/protobuf/stubs/logging.h>
#include <sys/socket.h>

#include <thread>

#include "fuzz_input.h"
#include "io/crc32c.h"
#include "io/link_client.h"

namespace {

using namespace lamella;

void append(const google::protobuf::MessageLite& message, std::string* stream) {
  const uint32_t size = uint32_t(message.ByteSizeLong());
  for (int i = 0; i < 4; ++i) stream->push_back(char(size >> (8 * i)));
  stream->append(message.SerializeAsString());
}

void fill_chunk(FuzzedDataProvider* data, v1::Chunk* chunk) {
  chunk->set_frame_id(data->ConsumeIntegralInRange(0, 2));
  chunk->set_sequence(data->ConsumeIntegralInRange(0, 3));
  chunk->set_offset_bytes(data->ConsumeIntegralInRange(0, 40));
  chunk->set_total_bytes(data->ConsumeBool() ? 20 : data->ConsumeIntegral<uint32_t>());
  chunk->set_data(data->ConsumeRandomLengthString(32));
  chunk->set_crc32c(data->ConsumeBool() ? crc32c(chunk->data().data(), chunk->data().size()) : 7);
}

v1::Reply any_reply(FuzzedDataProvider* data) {
  v1::Reply reply;
  reply.set_request_id(data->ConsumeIntegralInRange(0, 9));
  switch (data->ConsumeIntegralInRange(0, 6)) {
    case 0:
      reply.mutable_accepted()->set_planned_us(data->ConsumeFloatingPoint<double>());
      break;
    case 1:
      reply.mutable_done()->set_frame_count(data->ConsumeIntegral<uint32_t>());
      break;
    case 2:
      reply.mutable_frame()->set_frame_id(data->ConsumeIntegralInRange(0, 2));
      reply.mutable_frame()->set_size_bytes(data->ConsumeIntegralInRange(0, 40));
      break;
    case 3:
      fill_chunk(data, reply.mutable_chunk());
      break;
    case 4:
      reply.mutable_timing()->set_first_edge(data->ConsumeIntegralInRange(0, 3));
      reply.mutable_timing()->set_total_edges(data->ConsumeIntegral<uint32_t>());
      if (data->ConsumeBool()) reply.mutable_timing()->add_edges();
      break;
    case 5:
      reply.mutable_refusal()->set_reason(data->ConsumeRandomLengthString(20));
      break;
    default:
      reply.mutable_status()->set_state(v1::RigState(data->ConsumeIntegralInRange(-1, 6)));
  }
  return reply;
}

std::string stream_of(const uint8_t* bytes, size_t size) {
  FuzzedDataProvider data(bytes, size);
  v1::Reply welcome;
  welcome.set_request_id(1);
  welcome.mutable_welcome()->set_protocol_version(kProtocolVersion);
  std::string stream;
  append(welcome, &stream);
  if (data.ConsumeBool()) return stream + data.ConsumeRemainingBytesAsString();
  while (data.remaining_bytes() > 0) append(any_reply(&data), &stream);
  return stream;
}

// A socket that listens on loopback.
int listener(std::string* address) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof place;
  if (bind(fd, reinterpret_cast<sockaddr*>(&place), length) != 0 || listen(fd, 4) != 0)
    std::abort();
  getsockname(fd, reinterpret_cast<sockaddr*>(&place), &length);
  *address = "127.0.0.1:" + std::to_string(ntohs(place.sin_port));
  return fd;
}

void answer(int listening, const std::string& stream) {
  const int fd = accept(listening, nullptr, nullptr);
  close(listening);  // a second connection is refused at once
  if (fd < 0) std::abort();
  send(fd, stream.data(), stream.size(), MSG_NOSIGNAL);
  shutdown(fd, SHUT_WR);
  char ignored[4096];
  while (recv(fd, ignored, sizeof ignored, 0) > 0) {
  }
  close(fd);
}

void talk(const std::string& address) {
  LinkOptions options;
  options.retries = 0;
  options.backoff_s = 0;
  options.reply_s = 1;
  options.burst_margin_s = 1;
  LinkClient client(address, options);
  const Burst burst = client.run_burst("");
  for (const v1::FrameOffer& offer : client.offers(burst)) client.photograph(offer);
  client.timing(burst);
  client.calibration({});
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  google::protobuf::SetLogHandler(nullptr);  // as the program does
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  std::string address;
  const int listening = listener(&address);
  const std::string stream = stream_of(bytes, size);
  std::thread rig([&] { answer(listening, stream); });
  fuzz::expect_error_or_nothing([&] { talk(address); });
  rig.join();
  return 0;
}
