#include "io/wire.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

namespace lamella {

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr size_t kPrefixBytes = 4;
constexpr size_t kBufferBytes = 2 * (kPrefixBytes + kMaxWireBytes);
constexpr milliseconds kSlice{100};  // between two looks at `interrupted`

Break failed(const char* what) { return std::string(what) + ": " + std::strerror(errno); }

void put_length(uint32_t length, uint8_t* to) {
  for (int i = 0; i < 4; ++i) to[i] = uint8_t(length >> (8 * i));
}

uint32_t get_length(const uint8_t* from) {
  return from[0] | uint32_t(from[1]) << 8 | uint32_t(from[2]) << 16 | uint32_t(from[3]) << 24;
}

// Without it a short message waits 40 ms for the acknowledgement of the one before. No matter on a
// local socket, which has no such option.
void send_at_once(int fd) {
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

struct HostPort {
  std::string host, port;
};

// Of an address without fault.
HostPort split_address(const std::string& address) {
  const size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  return {host, address.substr(colon + 1)};
}

bool is_port(const std::string& text) {
  unsigned port = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), port);
  return failure == std::errc() && end == text.data() + text.size() && port >= 1 && port <= 65535;
}

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

int look_up(const std::string& address, Addresses* found) {
  const HostPort target = split_address(address);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* first = nullptr;
  const int error = getaddrinfo(target.host.c_str(), target.port.c_str(), &hints, &first);
  found->reset(error == 0 ? first : nullptr);
  return error;
}

// A TLS alert where a message's length is due: as a length it is far over the limit.
bool is_tls_alert(const uint8_t* prefix) { return prefix[0] == 0x15 && prefix[1] == 0x03; }

}  // namespace

std::optional<std::string> address_fault(const std::string& address) {
  const size_t colon = address.rfind(':');
  const std::string host = address.substr(0, colon);
  if (colon == std::string::npos || colon + 1 == address.size() || host.ends_with(':')) {
    return "\"" + address + "\" names no port: give HOST:PORT";
  }
  if (host.empty() || host == "[]") return "\"" + address + "\" names no host: give HOST:PORT";
  if (host.front() != '[' && host.find(':') != std::string::npos) {
    return "\"" + address + "\" has two colons: an IPv6 address is given as [HOST]:PORT";
  }
  const std::string port = address.substr(colon + 1);
  if (!is_port(port)) return "\"" + port + "\" is no port: 1 to 65535, as in HOST:PORT";
  return {};
}

bool names_a_host(const std::string& address) {
  Addresses found(nullptr, freeaddrinfo);
  return look_up(address, &found) != EAI_NONAME;
}

Deadline deadline_in(double seconds) {
  return steady_clock::now() +
         std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(seconds));
}

Socket::Socket(int fd) : fd_(fd) {
  if (fd_ < 0) return;
  fcntl(fd_, F_SETFL, fcntl(fd_, F_GETFL) | O_NONBLOCK);
  send_at_once(fd_);
}

Socket::~Socket() { close(); }

Socket::Socket(Socket&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      tls_(std::move(other.tls_)),
      buffer_(std::move(other.buffer_)),
      begin_(std::exchange(other.begin_, 0)),
      end_(std::exchange(other.end_, 0)),
      interrupted_(std::move(other.interrupted_)) {}

Socket& Socket::operator=(Socket&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(tls_, other.tls_);
  std::swap(buffer_, other.buffer_);
  std::swap(begin_, other.begin_);
  std::swap(end_, other.end_);
  std::swap(interrupted_, other.interrupted_);
  return *this;
}

void Socket::close() {
  tls_.reset();
  begin_ = end_ = 0;
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

Break Socket::wait(short events, Deadline deadline) {
  if (fd_ < 0) return "not connected";
  while (true) {
    if (interrupted_ && interrupted_()) return "interrupted";
    const auto left = std::chrono::ceil<milliseconds>(deadline - steady_clock::now());
    if (left.count() <= 0) return "no answer in time";
    pollfd entry{fd_, events, 0};
    const int ready = poll(&entry, 1, int(std::min(left, kSlice).count()));
    if (ready > 0) return {};
    if (ready < 0 && errno != EINTR) return failed("poll");
  }
}

Break Socket::start_tls(TlsOptions options, Deadline deadline) {
  tls_ = std::make_unique<Tls>(fd_, std::move(options));
  while (true) {
    const Tls::Progress progress = tls_->shake_hands();
    if (progress == Tls::Progress::kDone) return {};
    if (Break broken = wait_for(progress, deadline)) return broken;
  }
}

Break Socket::wait_for(Tls::Progress progress, Deadline deadline) {
  if (progress == Tls::Progress::kClosed) return tls_->reason();
  return wait(progress == Tls::Progress::kWantsRead ? POLLIN : POLLOUT, deadline);
}

// Sends what there is room for, waiting until there is some.
Break Socket::send_some(const uint8_t* bytes, size_t size, Deadline deadline, size_t* sent) {
  if (tls_) {
    const Tls::Progress progress = tls_->write(bytes, size, sent);
    return progress == Tls::Progress::kDone ? Break{} : wait_for(progress, deadline);
  }
  *sent = 0;
  if (Break broken = wait(POLLOUT, deadline)) return broken;
  const ssize_t count = ::send(fd_, bytes, size, MSG_NOSIGNAL);
  if (count < 0 && errno != EAGAIN && errno != EINTR) return failed("send");
  *sent = size_t(std::max<ssize_t>(count, 0));
  return {};
}

Break Socket::send_bytes(const uint8_t* bytes, size_t size, Deadline deadline) {
  if (fd_ < 0) return "not connected";
  while (size > 0) {
    size_t sent = 0;
    if (Break broken = send_some(bytes, size, deadline, &sent)) return broken;
    bytes += sent;
    size -= sent;
  }
  return {};
}

// Receives what is there, waiting until there is something.
Break Socket::receive_some(uint8_t* bytes, size_t room, Deadline deadline, size_t* got) {
  if (tls_) {
    const Tls::Progress progress = tls_->read(bytes, room, got);
    return progress == Tls::Progress::kDone ? Break{} : wait_for(progress, deadline);
  }
  *got = 0;
  if (Break broken = wait(POLLIN, deadline)) return broken;
  const ssize_t count = ::recv(fd_, bytes, room, 0);
  if (count == 0) return "connection closed";
  if (count < 0 && errno != EAGAIN && errno != EINTR) return failed("receive");
  *got = size_t(std::max<ssize_t>(count, 0));
  return {};
}

// Until `size` bytes lie at begin_. What comes with them stays for later.
Break Socket::fill(size_t size, Deadline deadline) {
  if (fd_ < 0) return "not connected";
  if (buffer_.empty()) buffer_.resize(kBufferBytes);
  if (begin_ == end_) begin_ = end_ = 0;
  if (begin_ + size > buffer_.size()) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  while (end_ - begin_ < size) {
    size_t got = 0;
    if (Break broken = receive_some(buffer_.data() + end_, buffer_.size() - end_, deadline, &got))
      return broken;
    end_ += got;
  }
  return {};
}

Break Socket::receive_bytes(uint8_t* bytes, size_t size, Deadline deadline) {
  if (fd_ < 0) return "not connected";
  const size_t kept = std::min(size, end_ - begin_);
  std::copy_n(buffer_.data() + begin_, kept, bytes);
  begin_ += kept;
  for (size_t at = kept; at < size;) {
    size_t got = 0;
    if (Break broken = receive_some(bytes + at, size - at, deadline, &got)) return broken;
    at += got;
  }
  return {};
}

Break Socket::send(const google::protobuf::MessageLite& message, Deadline deadline) {
  const size_t size = message.ByteSizeLong();
  if (size > kMaxWireBytes) return "a message of " + std::to_string(size) + " bytes is too long";
  std::vector<uint8_t> bytes(4 + size);
  put_length(uint32_t(size), bytes.data());
  message.SerializeToArray(bytes.data() + 4, int(size));
  return send_bytes(bytes.data(), bytes.size(), deadline);
}

Break Socket::receive(std::span<const uint8_t>* message, Deadline deadline) {
  if (Break broken = fill(kPrefixBytes, deadline)) return broken;
  const uint32_t size = get_length(buffer_.data() + begin_);
  if (size == 0) return "announced a message of no bytes";
  if (!tls_ && is_tls_alert(buffer_.data() + begin_)) return kAnswersInTls;
  if (size > kMaxWireBytes) {
    return "announced a message of " + std::to_string(size) + " bytes, over the limit of 65536";
  }
  if (Break broken = fill(kPrefixBytes + size, deadline)) return broken;
  *message = {buffer_.data() + begin_ + kPrefixBytes, size};
  begin_ += kPrefixBytes + size;
  return {};
}

Break Socket::receive(google::protobuf::MessageLite* message, Deadline deadline) {
  std::span<const uint8_t> bytes;
  if (Break broken = receive(&bytes, deadline)) return broken;
  if (!message->ParseFromArray(bytes.data(), int(bytes.size())))
    return "sent what is not a message";
  return {};
}

Break Socket::connect_tcp(const std::string& address, Deadline deadline) {
  if (const auto fault = address_fault(address)) return *fault;
  Addresses owned(nullptr, freeaddrinfo);
  const int error = look_up(address, &owned);
  if (error == EAI_NONAME) return kNoSuchHost;
  if (error != 0) return "looking up its name: " + std::string(gai_strerror(error));
  Break broken = kNoSuchHost;
  for (const addrinfo* a = owned.get(); a; a = a->ai_next) {
    fd_ = ::socket(a->ai_family, a->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, a->ai_protocol);
    if (fd_ < 0) return failed("socket");
    broken = {};
    if (::connect(fd_, a->ai_addr, a->ai_addrlen) != 0) {
      broken = errno == EINPROGRESS ? finish_connecting(deadline) : failed("connect");
    }
    if (!broken) break;
    close();
  }
  if (!broken) send_at_once(fd_);
  return broken;
}

Break Socket::finish_connecting(Deadline deadline) {
  if (Break broken = wait(POLLOUT, deadline)) return broken;
  int error = 0;
  socklen_t length = sizeof error;
  getsockopt(fd_, SOL_SOCKET, SO_ERROR, &error, &length);
  if (error != 0) return std::string("connect: ") + std::strerror(error);
  return {};
}

}  // namespace lamella
