#include "test_host.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <pb_decode.h>
#include <pb_encode.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

extern "C" {
#include "crc32c.h"
#include "wire.h"
}

extern char** environ;

lamella_v1_Request request_of(pb_size_t body) {
  lamella_v1_Request request = lamella_v1_Request_init_zero;
  request.which_body = body;
  if (body == lamella_v1_Request_burst_tag) request.body.burst.flashing_confirmed = true;
  return request;
}

lamella_v1_Request hello() {
  lamella_v1_Request request = request_of(lamella_v1_Request_hello_tag);
  request.body.hello.protocol_version = 1;
  std::strcpy(request.body.hello.host_name, "test");
  return request;
}

std::vector<uint8_t> encoded(const lamella_v1_Request& request) {
  std::vector<uint8_t> bytes(lamella_v1_Request_size);
  pb_ostream_t stream = pb_ostream_from_buffer(bytes.data(), bytes.size());
  EXPECT_TRUE(pb_encode(&stream, lamella_v1_Request_fields, &request));
  bytes.resize(stream.bytes_written);
  return bytes;
}

TestHost::TestHost(int port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  const timeval patience = {10, 0};
  setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
}

TestHost::~TestHost() { close(socket_); }

void TestHost::send_bytes(const std::vector<uint8_t>& bytes) {
  ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

void TestHost::send(lamella_v1_Request request) {
  request.request_id = ++request_id_;
  const std::vector<uint8_t> message = encoded(request);
  std::vector<uint8_t> framed(WIRE_LENGTH_BYTES);
  wire_put_length(framed.data(), message.size());
  framed.insert(framed.end(), message.begin(), message.end());
  send_bytes(framed);
}

bool TestHost::receive(lamella_v1_Reply* reply) {
  uint8_t prefix[WIRE_LENGTH_BYTES];
  size_t length = 0;
  if (recv(socket_, prefix, sizeof prefix, MSG_WAITALL) != sizeof prefix) return false;
  if (!wire_get_length(prefix, &length)) return false;
  std::vector<uint8_t> message(length);
  if (recv(socket_, message.data(), length, MSG_WAITALL) != static_cast<ssize_t>(length)) {
    return false;
  }
  pb_istream_t stream = pb_istream_from_buffer(message.data(), length);
  return pb_decode(&stream, lamella_v1_Reply_fields, reply);
}

lamella_v1_Reply TestHost::ask(lamella_v1_Request request) {
  send(request);
  lamella_v1_Reply reply = lamella_v1_Reply_init_zero;
  do {
    if (!receive(&reply)) {
      ADD_FAILURE() << "the rig closed the connection or fell silent";
      return lamella_v1_Reply_init_zero;
    }
  } while (reply.request_id != request_id_);
  return reply;
}

std::vector<uint8_t> TestHost::fetch(const lamella_v1_BlobQuery& query) {
  lamella_v1_Request request = request_of(lamella_v1_Request_blob_tag);
  request.body.blob = query;
  lamella_v1_Reply reply = ask(request);
  std::vector<uint8_t> bytes;
  for (uint32_t sequence = 0; reply.which_body == lamella_v1_Reply_chunk_tag; sequence++) {
    const lamella_v1_Chunk& chunk = reply.body.chunk;
    EXPECT_EQ(chunk.sequence, sequence);
    EXPECT_EQ(chunk.offset_bytes, query.offset_bytes + bytes.size());
    EXPECT_EQ(chunk.crc32c, crc32c_extend(0, chunk.data.bytes, chunk.data.size));
    bytes.insert(bytes.end(), chunk.data.bytes, chunk.data.bytes + chunk.data.size);
    if (query.offset_bytes + bytes.size() == chunk.total_bytes) return bytes;
    if (!receive(&reply)) break;
  }
  ADD_FAILURE() << "the answer broke off after " << bytes.size() << " bytes";
  return bytes;
}

uint64_t TestHost::run_burst() {
  const lamella_v1_Reply accepted = ask(request_of(lamella_v1_Request_burst_tag));
  EXPECT_EQ(accepted.which_body, lamella_v1_Reply_accepted_tag);
  lamella_v1_Reply done = lamella_v1_Reply_init_zero;
  uint32_t held = 0;
  while (receive(&done) && done.which_body == lamella_v1_Reply_status_tag) {
    EXPECT_GE(done.body.status.frames_held, held);
    held = done.body.status.frames_held;
  }
  EXPECT_EQ(done.which_body, lamella_v1_Reply_done_tag);
  EXPECT_EQ(done.request_id, 0u);
  return accepted.body.accepted.burst_id;
}

std::vector<lamella_v1_FrameOffer> TestHost::offers(uint64_t burst_id) {
  lamella_v1_Request request = request_of(lamella_v1_Request_frames_tag);
  request.body.frames.burst_id = burst_id;
  std::vector<lamella_v1_FrameOffer> offers;
  lamella_v1_Reply reply = ask(request);
  while (reply.which_body == lamella_v1_Reply_frame_tag) {
    offers.push_back(reply.body.frame);
    if (!receive(&reply)) break;
  }
  EXPECT_EQ(reply.which_body, lamella_v1_Reply_done_tag);
  return offers;
}

std::vector<std::string> last_of_each(std::vector<std::string> arguments) {
  for (size_t i = 0; i + 1 < arguments.size();) {
    const std::string option = arguments[i];
    const bool one_value =
        option.starts_with("--") && option != "--inject" && !arguments[i + 1].starts_with("--");
    const auto later = std::find(arguments.begin() + long(i) + 1, arguments.end(), option);
    if (one_value && later != arguments.end()) {
      arguments.erase(arguments.begin() + long(i), arguments.begin() + long(i) + 2);
    } else {
      ++i;
    }
  }
  return arguments;
}

RigProcess::RigProcess(std::vector<std::string> arguments) {
  int out[2], err[2];
  EXPECT_EQ(pipe2(out, O_CLOEXEC), 0);
  EXPECT_EQ(pipe2(err, O_CLOEXEC), 0);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  arguments.insert(arguments.begin(), LAMELLA_RIGD);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  // Whoever runs the tests in the background of a script ignores SIGINT, and the daemon would too.
  posix_spawnattr_t as_from_a_terminal;
  posix_spawnattr_init(&as_from_a_terminal);
  sigset_t heard;
  sigemptyset(&heard);
  sigaddset(&heard, SIGINT);
  posix_spawnattr_setsigdefault(&as_from_a_terminal, &heard);
  posix_spawnattr_setflags(&as_from_a_terminal, POSIX_SPAWN_SETSIGDEF);
  EXPECT_EQ(posix_spawn(&pid_, LAMELLA_RIGD, &actions, &as_from_a_terminal, argv.data(), environ),
            0);
  posix_spawnattr_destroy(&as_from_a_terminal);
  posix_spawn_file_actions_destroy(&actions);
  close(out[1]);
  close(err[1]);
  out_ = out[0];
  err_ = err[0];
}

RigProcess::~RigProcess() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  close(out_);
  close(err_);
}

int RigProcess::port() {
  std::string line;
  for (char c = 0; read(out_, &c, 1) == 1 && c != '\n';) line += c;
  int port = 0;
  return std::sscanf(line.c_str(), "listening on 127.0.0.1:%d", &port) == 1 ? port : 0;
}

void RigProcess::signal(int number) { kill(pid_, number); }

int RigProcess::exit_code() {
  constexpr int kPatience_ms = 30000;
  int status = 0;
  for (int ms = 0; ms < kPatience_ms && waitpid(pid_, &status, WNOHANG) == 0; ms++) usleep(1000);
  if (waitpid(pid_, nullptr, WNOHANG) == 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status, 0);
  }
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static std::string read_to_end(int fd) {
  std::string text;
  for (char c = 0; read(fd, &c, 1) == 1;) text += c;
  return text;
}

std::string RigProcess::errors() { return read_to_end(err_); }

std::string RigProcess::output() { return read_to_end(out_); }

std::string RigProcess::error_line(const std::string& part) {
  std::string line;
  for (char c = 0; read(err_, &c, 1) == 1;) {
    if (c != '\n') line += c;
    if (c == '\n' && line.find(part) != std::string::npos) return line;
    if (c == '\n') line.clear();
  }
  return "";
}
