// Stands between a host and a rig: hands every byte on, remembers it, and can cut the line.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace lamella::testing {

class RecordingProxy {
 public:
  explicit RecordingProxy(int rig_port);
  ~RecordingProxy();
  RecordingProxy(const RecordingProxy&) = delete;
  RecordingProxy& operator=(const RecordingProxy&) = delete;

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

  // Every connection from now on is cut after so many bytes from the rig, `times` times.
  void cut_after(size_t bytes, int times);

  int connections() const { return connections_; }
  std::vector<uint8_t> from_host() const;  // over all connections
  std::vector<uint8_t> from_rig() const;

 private:
  void serve();
  void carry(int host, int rig);

  int rig_port_, listener_, port_;
  std::atomic<bool> stopping_{false};
  std::atomic<int> connections_{0}, cuts_left_{0};
  std::atomic<size_t> cut_after_{0};
  mutable std::mutex mutex_;
  std::vector<uint8_t> from_host_, from_rig_;
  std::thread thread_;
};

// A TCP connection to a port of this machine.
int connect_to(int port);

// Sends all, then reads until the other end closes or nothing comes for `patience_s`.
std::vector<uint8_t> say(int port, const std::vector<uint8_t>& bytes, double patience_s);

// Content types of the TLS records in a stream, in order: 22 handshake, 23 anything encrypted.
struct Record {
  int type;
  size_t size;
};
std::vector<Record> records(const std::vector<uint8_t>& stream);

}  // namespace lamella::testing
