// One protobuf message after another on a stream socket, each after its length (4 bytes, little
// endian, 1 to 65536). What goes wrong with a connection is a result here, not an exception:
// the caller knows whether it can be mended.
#pragma once

#include <google/protobuf/message_lite.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/tls.h"

namespace lamella {

inline constexpr size_t kMaxWireBytes = 65536;

using Deadline = std::chrono::steady_clock::time_point;

Deadline deadline_in(double seconds);

// Why a connection is of no more use, in words; nullopt: all is well.
using Break = std::optional<std::string>;

// Two of them that say what to do: the name is mistyped, or the other end speaks TLS and we do not.
inline constexpr char kNoSuchHost[] = "no such host";
inline constexpr char kAnswersInTls[] = "it answers in TLS, and was spoken to in the clear";

// What is wrong with an address that is to be HOST:PORT or [HOST]:PORT; nullopt: nothing.
std::optional<std::string> address_fault(const std::string& address);

// False where an address without fault names a host that nobody knows; a name server that does not
// answer says nothing of that.
bool names_a_host(const std::string& address);

class Socket {
 public:
  Socket() = default;
  explicit Socket(int fd);  // takes over a connected stream socket
  ~Socket();
  Socket(Socket&& other) noexcept;
  Socket& operator=(Socket&& other) noexcept;

  // TLS from here on, or a Break: then nothing of ours was sent but the handshake.
  [[nodiscard]] Break start_tls(TlsOptions options, Deadline deadline);
  const Tls* tls() const { return tls_.get(); }

  bool is_open() const { return fd_ >= 0; }
  void close();

  // Asked about ten times a second while anything is waited for; true ends the wait with a Break.
  void set_interrupted(std::function<bool()> interrupted) { interrupted_ = std::move(interrupted); }

  [[nodiscard]] Break send(const google::protobuf::MessageLite& message, Deadline deadline);
  [[nodiscard]] Break receive(google::protobuf::MessageLite* message, Deadline deadline);
  // The bytes of one message, where they lie until the next call.
  [[nodiscard]] Break receive(std::span<const uint8_t>* message, Deadline deadline);

  // Bytes that follow a message without a length of their own.
  [[nodiscard]] Break send_bytes(const uint8_t* bytes, size_t size, Deadline deadline);

  // Exactly `size` bytes that are not framed, some of which may have come with the last message:
  // who reads the descriptor itself misses those.
  [[nodiscard]] Break receive_bytes(uint8_t* bytes, size_t size, Deadline deadline);

  // `address` is HOST:PORT or [HOST]:PORT. The socket must be closed.
  [[nodiscard]] Break connect_tcp(const std::string& address, Deadline deadline);

 private:
  Break wait(short events, Deadline deadline);
  Break fill(size_t size, Deadline deadline);
  Break finish_connecting(Deadline deadline);
  Break wait_for(Tls::Progress progress, Deadline deadline);
  Break send_some(const uint8_t* bytes, size_t size, Deadline deadline, size_t* sent);
  Break receive_some(uint8_t* bytes, size_t room, Deadline deadline, size_t* got);

  int fd_ = -1;
  std::unique_ptr<Tls> tls_;
  // Received and not yet given out: [begin_, end_) of the buffer.
  std::vector<uint8_t> buffer_;
  size_t begin_ = 0, end_ = 0;
  std::function<bool()> interrupted_;
};

}  // namespace lamella
