// A rig that only speaks: answers the link with libprotobuf, from memory, and can be told to break
// off, lie, or dawdle.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "io/link_client.h"
#include "io/raw12.h"
#include "io/wire.h"

namespace lamella::testing {

struct FakePhotograph {
  v1::FrameOffer offer;
  std::vector<uint8_t> bytes;
};

struct FakeRigFaults {
  uint32_t protocol_version = kProtocolVersion;
  int cut_frame = -1;              // this photograph breaks off ...
  size_t cut_at_byte = 0;          // ... before this byte ...
  int cut_times = 0;               // ... so often
  int damaged_chunks = 0;          // so many chunks have a byte flipped
  int chunks_out_of_sequence = 0;  // so many are numbered wrongly
  int overlong_lengths = 0;        // so many chunks announce 1 GB
  bool wrong_frame_crc = false;    // every photograph's own CRC is wrong
  bool cut_during_burst = false;   // the connection breaks, the burst goes on
  std::string off_during_burst;    // the rig too is off meanwhile, and says this of what is left
  bool dies_in_burst = false;      // it does not come back
  bool lacks = false;              // what is added is all of the burst: a photograph was lost
  bool holds_damaged = false;      // before the burst held, another that it cannot read itself
  bool refuses_burst = false;
  bool is_busy = false;
  double reply_delay_s = 0;
  bool stands_in_fault = false;  // until an Abort
  int dies_after_acks = -1;      // it forgets so many photographs and is gone
};

class FakeRig {
 public:
  explicit FakeRig(FakeRigFaults faults = {});
  ~FakeRig();

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  void add(FakePhotograph photograph);
  void set_welcome(const v1::Welcome& welcome);  // but for its protocol's version
  void set_calibration(std::string json);
  void add_edge(const v1::TimedEdge& edge);
  // From now on it holds this burst, whose photographs are those added; it goes with the last one.
  void hold(const v1::HeldBurst& burst);

  int connections() const { return connections_; }
  std::set<uint32_t> acknowledged() const;
  std::vector<uint32_t> offsets(uint32_t frame_id) const;  // from which it was asked for
  bool holds_burst() const;
  bool forgot_damaged() const;

 private:
  v1::BurstDone ending() const;
  void serve();
  void converse(Socket socket, int fd);
  void answer(const v1::Request& request, Socket* socket, int fd);
  void answer_burst(const v1::Request& request, Socket* socket);
  void answer_blob(const v1::Request& request, Socket* socket, int fd);
  void answer_timing(const v1::Request& request, Socket* socket);
  void answer_ack(const v1::Request& request, Socket* socket);
  void answer_frames(const v1::Request& request, Socket* socket);
  void answer_bursts(const v1::Request& request, Socket* socket);
  void say(const v1::Request& request, v1::Reply reply, Socket* socket);
  const FakePhotograph* find(uint32_t frame_id) const;

  FakeRigFaults faults_;
  std::vector<FakePhotograph> photographs_;
  v1::Welcome welcome_;
  std::string calibration_;
  std::vector<v1::TimedEdge> edges_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<int> connections_{0};
  std::atomic<bool> stopping_{false};
  bool dead_ = false;         // of the serving thread
  mutable std::mutex mutex_;  // held while a request is answered, and by whoever loads the rig
  std::set<uint32_t> acknowledged_;
  std::map<uint32_t, std::vector<uint32_t>> offsets_;
  std::optional<v1::HeldBurst> held_;
  bool forgot_damaged_ = false;
  std::thread thread_;
};

// Raw values: a ramp that differs from frame to frame.
RawImage fake_raw(uint32_t frame_id, cv::Size size);

// Calibration and forty photographs of a burst, their values fake_raw(); some roles left out.
void load_burst(FakeRig* rig, cv::Size size, const std::set<v1::Frame::Role>& without = {});

// What such a rig says of it.
v1::HeldBurst whole_burst();
v1::HeldBurst partial_burst();  // "the power went"

// STRIPES of the left camera, its values fake_raw().
FakePhotograph fake_photograph(uint32_t frame_id, cv::Size size);

}  // namespace lamella::testing
