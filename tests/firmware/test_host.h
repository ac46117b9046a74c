// The host's side of the link for the firmware's tests: nanopb both ways, no patience.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

extern "C" {
#include "proto/link.pb.h"
}

lamella_v1_Request hello();
lamella_v1_Request request_of(pb_size_t body);
std::vector<uint8_t> encoded(const lamella_v1_Request& request);

class TestHost {
 public:
  explicit TestHost(int port);
  ~TestHost();
  TestHost(const TestHost&) = delete;
  TestHost& operator=(const TestHost&) = delete;

  void send(lamella_v1_Request request);
  void send_bytes(const std::vector<uint8_t>& bytes);
  // False where the rig closed the connection, or nothing came for some seconds.
  bool receive(lamella_v1_Reply* reply);
  // Sends and returns the first reply that is no event.
  lamella_v1_Reply ask(lamella_v1_Request request);
  // Every chunk of a photograph (or the calibration) from an offset on, checked as it comes.
  std::vector<uint8_t> fetch(const lamella_v1_BlobQuery& query);
  uint64_t run_burst();
  std::vector<lamella_v1_FrameOffer> offers(uint64_t burst_id);

 private:
  int socket_;
  uint32_t request_id_ = 0;
};

// Of an option of lamella-rigd that is given twice, but for --inject, the last: what a test asks
// for in place of what its bench does.
std::vector<std::string> last_of_each(std::vector<std::string> arguments);

// lamella-rigd as a process of its own.
class RigProcess {
 public:
  explicit RigProcess(std::vector<std::string> arguments);
  ~RigProcess();
  RigProcess(const RigProcess&) = delete;
  RigProcess& operator=(const RigProcess&) = delete;

  int port();               // waits for "listening on 127.0.0.1:PORT"; 0 where it ends instead
  int exit_code();          // waits for the end; -1 where it was killed, or did not come in 30 s
  void signal(int number);  // SIGTERM, SIGINT
  pid_t pid() const { return pid_; }
  std::string errors();  // what it said on stderr, once it has ended
  std::string output();  // the rest of what it says on stdout, until it ends
  // Waits for a line on stderr that has this in it; "" where it ends instead.
  std::string error_line(const std::string& part);

 private:
  pid_t pid_;
  int out_, err_;
};
