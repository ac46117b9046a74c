#include "io/fake_rig.h"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "io/crc32c.h"
#include "io/fake_session.h"
#include "io/json.h"

namespace lamella::testing {

namespace {

constexpr size_t kChunkBytes = 1000;  // small, so that small photographs need several
constexpr uint64_t kBurstId = 42;
constexpr uint64_t kDamagedId = 41;
constexpr double kPatience_s = 5;

}  // namespace

RawImage fake_raw(uint32_t frame_id, cv::Size size) {
  RawImage image(size);
  int next = int(frame_id) * 101;
  for (auto& pixel : image) {
    for (int c = 0; c < 3; ++c) pixel[c] = uint16_t((next++ * 7) & 0xfff);
  }
  return image;
}

v1::HeldBurst whole_burst() {
  v1::HeldBurst burst;
  burst.set_begun_unix_us(1790000000000000);
  burst.set_whole(true);
  burst.set_frames_expected(40);
  return burst;
}

v1::HeldBurst partial_burst() {
  v1::HeldBurst burst = whole_burst();
  burst.set_whole(false);
  burst.set_why("the power went");
  return burst;
}

FakePhotograph fake_photograph(uint32_t frame_id, cv::Size size) {
  FakePhotograph p;
  p.bytes = pack_rgb12p(fake_raw(frame_id, size));
  p.offer.set_burst_id(kBurstId);
  p.offer.set_frame_id(frame_id);
  p.offer.set_width(uint32_t(size.width));
  p.offer.set_height(uint32_t(size.height));
  p.offer.set_size_bytes(uint32_t(p.bytes.size()));
  p.offer.set_crc32c(crc32c(p.bytes.data(), p.bytes.size()));
  v1::Frame* frame = p.offer.mutable_frame();
  frame->set_step(frame_id);
  frame->set_role(v1::Frame::STRIPES);
  frame->set_index(frame_id);
  frame->set_analyser(v1::Frame::CROSS);
  frame->set_camera("left");
  frame->set_pixel_format(kRgb12p);
  frame->set_black_level_dn(64);
  frame->set_gain_per_dn(1.0 / 4000);
  return p;
}

void load_burst(FakeRig* rig, cv::Size size, const std::set<v1::Frame::Role>& without) {
  const v1::Session calibration = fake_calibration(size);
  rig->set_calibration(to_json(calibration));
  v1::Welcome welcome;
  *welcome.mutable_patterns() = calibration.patterns();
  welcome.set_led_count(uint32_t(calibration.rig().leds_size()));
  welcome.set_projector_width(calibration.rig().projector().width());
  welcome.set_projector_height(calibration.rig().projector().height());
  rig->set_welcome(welcome);
  uint32_t frame_id = 0;
  for (const v1::Frame& frame : fake_frames()) {
    FakePhotograph p = fake_photograph(frame_id++, size);
    const v1::Frame raw = p.offer.frame();
    *p.offer.mutable_frame() = frame;
    p.offer.mutable_frame()->set_pixel_format(raw.pixel_format());
    p.offer.mutable_frame()->set_black_level_dn(raw.black_level_dn());
    p.offer.mutable_frame()->set_gain_per_dn(raw.gain_per_dn());
    if (!without.contains(frame.role())) rig->add(p);
  }
}

FakeRig::FakeRig(FakeRigFaults faults) : faults_(faults) {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  bind(listener_, reinterpret_cast<sockaddr*>(&address), length);
  listen(listener_, 4);
  getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length);
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { serve(); });
}

FakeRig::~FakeRig() {
  stopping_ = true;
  thread_.join();
  close(listener_);
}

void FakeRig::add(FakePhotograph photograph) {
  const std::lock_guard lock(mutex_);
  photographs_.push_back(std::move(photograph));
}

void FakeRig::set_welcome(const v1::Welcome& welcome) {
  const std::lock_guard lock(mutex_);
  welcome_ = welcome;
}

void FakeRig::set_calibration(std::string json) {
  const std::lock_guard lock(mutex_);
  calibration_ = std::move(json);
}

void FakeRig::add_edge(const v1::TimedEdge& edge) {
  const std::lock_guard lock(mutex_);
  edges_.push_back(edge);
}

void FakeRig::hold(const v1::HeldBurst& burst) {
  const std::lock_guard lock(mutex_);
  held_ = burst;
  held_->set_burst_id(kBurstId);
  held_->set_frames_held(uint32_t(photographs_.size()));
}

bool FakeRig::forgot_damaged() const {
  const std::lock_guard lock(mutex_);
  return forgot_damaged_;
}

bool FakeRig::holds_burst() const {
  const std::lock_guard lock(mutex_);
  return held_.has_value();
}

std::vector<uint32_t> FakeRig::offsets(uint32_t frame_id) const {
  const std::lock_guard lock(mutex_);
  const auto it = offsets_.find(frame_id);
  return it == offsets_.end() ? std::vector<uint32_t>{} : it->second;
}

std::set<uint32_t> FakeRig::acknowledged() const {
  const std::lock_guard lock(mutex_);
  return acknowledged_;
}

void FakeRig::serve() {
  while (!stopping_ && !dead_) {
    pollfd entry{listener_, POLLIN, 0};
    if (poll(&entry, 1, 20) <= 0) continue;
    const int fd = accept(listener_, nullptr, nullptr);
    if (fd < 0) continue;
    ++connections_;
    converse(Socket(fd), fd);
  }
  shutdown(listener_, SHUT_RDWR);  // who connects now is refused
}

void FakeRig::converse(Socket socket, int fd) {
  socket.set_interrupted([this] { return bool(stopping_); });
  v1::Request request;
  while (socket.is_open()) {
    if (socket.receive(&request, deadline_in(kPatience_s))) return;
    const std::lock_guard lock(mutex_);
    answer(request, &socket, fd);
  }
}

void FakeRig::say(const v1::Request& request, v1::Reply reply, Socket* socket) {
  std::this_thread::sleep_for(std::chrono::duration<double>(faults_.reply_delay_s));
  reply.set_request_id(request.request_id());
  if (socket->send(reply, deadline_in(kPatience_s))) socket->close();
}

void FakeRig::answer(const v1::Request& request, Socket* socket, int fd) {
  v1::Reply reply;
  switch (request.body_case()) {
    case v1::Request::kHello:
      if (faults_.is_busy) {
        reply.mutable_refusal()->set_code(v1::Refusal::WRONG_STATE);
        return say(request, reply, socket);
      }
      *reply.mutable_welcome() = welcome_;
      reply.mutable_welcome()->set_protocol_version(faults_.protocol_version);
      return say(request, reply, socket);
    case v1::Request::kStatus:
      reply.mutable_status()->set_state(faults_.stands_in_fault ? v1::FAULT : v1::IDLE);
      if (faults_.stands_in_fault) reply.mutable_status()->set_fault("a camera missed a trigger");
      reply.mutable_status()->set_burst_id(kBurstId);
      reply.mutable_status()->set_frames_held(uint32_t(photographs_.size()));
      return say(request, reply, socket);
    case v1::Request::kAbort:
      faults_.stands_in_fault = false;
      reply.mutable_status()->set_state(v1::IDLE);
      return say(request, reply, socket);
    case v1::Request::kBurst:
      return answer_burst(request, socket);
    case v1::Request::kFrames:
      return answer_frames(request, socket);
    case v1::Request::kBlob:
      return answer_blob(request, socket, fd);
    case v1::Request::kTiming:
      return answer_timing(request, socket);
    case v1::Request::kAck:
      return answer_ack(request, socket);
    case v1::Request::kBursts:
      return answer_bursts(request, socket);
    case v1::Request::kBurstAck:
      forgot_damaged_ = forgot_damaged_ || request.burst_ack().burst_id() == kDamagedId;
      held_.reset();
      reply.mutable_acknowledged();
      return say(request, reply, socket);
    default:
      reply.mutable_refusal()->set_code(v1::Refusal::BAD_REQUEST);
      return say(request, reply, socket);
  }
}

void FakeRig::answer_burst(const v1::Request& request, Socket* socket) {
  v1::Reply reply;
  if (faults_.refuses_burst) {
    reply.mutable_refusal()->set_code(v1::Refusal::UNSAFE);
    reply.mutable_refusal()->set_reason("step 3 needs a longer settle");
    return say(request, reply, socket);
  }
  reply.mutable_accepted()->set_burst_id(kBurstId);
  reply.mutable_accepted()->set_step_count(uint32_t(photographs_.size()));
  reply.mutable_accepted()->set_planned_us(1e6);
  say(request, reply, socket);
  held_.emplace();
  held_->set_burst_id(kBurstId);
  held_->set_whole(faults_.off_during_burst.empty());
  held_->set_why(faults_.off_during_burst);
  held_->set_frames_held(uint32_t(photographs_.size()));
  dead_ = faults_.dies_in_burst;
  if (faults_.cut_during_burst) return socket->close();
  *reply.mutable_done() = ending();
  say(request, reply, socket);
}

v1::BurstDone FakeRig::ending() const {
  v1::BurstDone done;
  done.set_burst_id(kBurstId);
  done.set_frame_count(uint32_t(photographs_.size()));
  done.set_marked(faults_.lacks);
  if (faults_.lacks) done.set_verdict("MARKED: step 7 dropped by a camera");
  return done;
}

const FakePhotograph* FakeRig::find(uint32_t frame_id) const {
  const auto it = std::find_if(photographs_.begin(), photographs_.end(),
                               [&](const auto& p) { return p.offer.frame_id() == frame_id; });
  return it == photographs_.end() ? nullptr : &*it;
}

void FakeRig::answer_blob(const v1::Request& request, Socket* socket, int fd) {
  const v1::BlobQuery& query = request.blob();
  std::string bytes = calibration_;
  if (query.kind() == v1::BlobQuery::PHOTOGRAPH) {
    const FakePhotograph* p = find(query.frame_id());
    bytes.assign(p->bytes.begin(), p->bytes.end());
    offsets_[query.frame_id()].push_back(query.offset_bytes());
  }
  const bool cut = query.kind() == v1::BlobQuery::PHOTOGRAPH &&
                   int(query.frame_id()) == faults_.cut_frame && faults_.cut_times > 0;
  v1::Reply reply;
  v1::Chunk* chunk = reply.mutable_chunk();
  chunk->set_frame_id(query.frame_id());
  chunk->set_total_bytes(uint32_t(bytes.size()));
  uint32_t sequence = 0;
  for (size_t at = query.offset_bytes(); at < bytes.size() && socket->is_open();) {
    size_t size = std::min(kChunkBytes, bytes.size() - at);
    if (cut && at < faults_.cut_at_byte) size = std::min(size, faults_.cut_at_byte - at);
    if (cut && at >= faults_.cut_at_byte) {
      --faults_.cut_times;
      return socket->close();
    }
    chunk->set_offset_bytes(uint32_t(at));
    chunk->set_sequence(sequence++);
    if (faults_.chunks_out_of_sequence > 0 && faults_.chunks_out_of_sequence--) {
      chunk->set_sequence(sequence + 5);
    }
    chunk->set_data(bytes.substr(at, size));
    chunk->set_crc32c(crc32c(chunk->data().data(), size));
    if (faults_.damaged_chunks > 0 && faults_.damaged_chunks--) {
      (*chunk->mutable_data())[size / 2] ^= 0x10;
    }
    if (faults_.overlong_lengths > 0 && faults_.overlong_lengths--) {
      const std::array<uint8_t, 4> gigabyte{0, 0, 0, 0x40};
      send(fd, gigabyte.data(), gigabyte.size(), MSG_NOSIGNAL);
      return;
    }
    say(request, reply, socket);
    at += size;
  }
}

void FakeRig::answer_timing(const v1::Request& request, Socket* socket) {
  v1::Reply reply;
  v1::TimingEdges* timing = reply.mutable_timing();
  const size_t first = request.timing().first_edge();
  timing->set_first_edge(uint32_t(first));
  timing->set_total_edges(uint32_t(edges_.size()));
  timing->mutable_latency()->set_lead_us(1.5);
  for (size_t i = first; i < std::min(first + 64, edges_.size()); ++i) {
    *timing->add_edges() = edges_[i];
  }
  say(request, reply, socket);
}

void FakeRig::answer_frames(const v1::Request& request, Socket* socket) {
  v1::Reply reply;
  if (faults_.holds_damaged && request.frames().burst_id() == kDamagedId) {
    reply.mutable_refusal()->set_code(v1::Refusal::NOT_FOUND);
    reply.mutable_refusal()->set_reason("its disk cannot read burst 41");
    return say(request, reply, socket);
  }
  for (const FakePhotograph& p : photographs_) {
    if (held_ && acknowledged_.contains(p.offer.frame_id())) continue;
    *reply.mutable_frame() = p.offer;
    if (faults_.wrong_frame_crc) reply.mutable_frame()->set_crc32c(p.offer.crc32c() ^ 1);
    say(request, reply, socket);
  }
  *reply.mutable_done() = ending();
  say(request, reply, socket);
}

void FakeRig::answer_bursts(const v1::Request& request, Socket* socket) {
  v1::Reply reply;
  std::vector<v1::HeldBurst> all;
  if (held_) all.push_back(*held_);
  if (held_ && faults_.holds_damaged) {
    all.insert(all.begin(), *held_);
    all.front().set_burst_id(kDamagedId);
  }
  for (const v1::HeldBurst& held : all) {
    *reply.mutable_held() = held;
    say(request, reply, socket);
  }
  reply.mutable_held_end()->set_bursts(uint32_t(all.size()));
  say(request, reply, socket);
}

void FakeRig::answer_ack(const v1::Request& request, Socket* socket) {
  dead_ = dead_ || int(acknowledged_.size()) == faults_.dies_after_acks;
  if (dead_) return socket->close();
  acknowledged_.insert(request.ack().frame_id());
  if (acknowledged_.size() == photographs_.size()) held_.reset();
  v1::Reply reply;
  reply.mutable_acknowledged()->set_frame_id(request.ack().frame_id());
  say(request, reply, socket);
}

}  // namespace lamella::testing
