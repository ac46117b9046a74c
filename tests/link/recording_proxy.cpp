#include "link/recording_proxy.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace lamella::testing {

namespace {

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(uint16_t(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

bool send_all(int fd, const uint8_t* bytes, size_t size) {
  while (size > 0) {
    const ssize_t sent = send(fd, bytes, size, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes += sent;
    size -= size_t(sent);
  }
  return true;
}

}  // namespace

int connect_to(int port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = loopback(port);
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  if (connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  close(fd);
  return -1;
}

std::vector<uint8_t> say(int port, const std::vector<uint8_t>& bytes, double patience_s) {
  const int fd = connect_to(port);
  std::vector<uint8_t> heard;
  if (fd < 0) return heard;
  send_all(fd, bytes.data(), bytes.size());
  pollfd entry{fd, POLLIN, 0};
  std::array<uint8_t, 4096> part;
  while (poll(&entry, 1, int(patience_s * 1000)) > 0) {
    const ssize_t got = recv(fd, part.data(), part.size(), 0);
    if (got <= 0) break;
    heard.insert(heard.end(), part.begin(), part.begin() + got);
  }
  close(fd);
  return heard;
}

std::vector<Record> records(const std::vector<uint8_t>& stream) {
  std::vector<Record> found;
  for (size_t at = 0; at + 5 <= stream.size();) {
    const size_t size = size_t(stream[at + 3]) << 8 | stream[at + 4];
    found.push_back({stream[at], size});
    at += 5 + size;
  }
  return found;
}

RecordingProxy::RecordingProxy(int rig_port)
    : rig_port_(rig_port), listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  bind(listener_, reinterpret_cast<sockaddr*>(&address), size);
  listen(listener_, 4);
  getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { serve(); });
}

RecordingProxy::~RecordingProxy() {
  stopping_ = true;
  thread_.join();
  close(listener_);
}

void RecordingProxy::cut_after(size_t bytes, int times) {
  cut_after_ = bytes;
  cuts_left_ = times;
}

std::vector<uint8_t> RecordingProxy::from_host() const {
  const std::lock_guard lock(mutex_);
  return from_host_;
}

std::vector<uint8_t> RecordingProxy::from_rig() const {
  const std::lock_guard lock(mutex_);
  return from_rig_;
}

void RecordingProxy::serve() {
  while (!stopping_) {
    pollfd entry{listener_, POLLIN, 0};
    if (poll(&entry, 1, 20) <= 0) continue;
    const int host = accept(listener_, nullptr, nullptr);
    const int rig = connect_to(rig_port_);
    ++connections_;
    if (host >= 0 && rig >= 0) carry(host, rig);
    close(host);
    close(rig);
  }
}

void RecordingProxy::carry(int host, int rig) {
  size_t carried = 0;
  const int on = 1;
  setsockopt(host, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  std::array<uint8_t, 16384> part;
  while (!stopping_) {
    std::array<pollfd, 2> entries{pollfd{host, POLLIN, 0}, pollfd{rig, POLLIN, 0}};
    if (poll(entries.data(), entries.size(), 20) <= 0) continue;
    for (const bool is_host : {true, false}) {
      if (entries[is_host ? 0 : 1].revents == 0) continue;
      size_t room = part.size();
      if (!is_host && cuts_left_ > 0) room = std::min(room, cut_after_ - carried);
      const ssize_t got = recv(is_host ? host : rig, part.data(), room, 0);
      if (got <= 0) return;
      {
        const std::lock_guard lock(mutex_);
        auto& stream = is_host ? from_host_ : from_rig_;
        stream.insert(stream.end(), part.begin(), part.begin() + got);
      }
      if (!send_all(is_host ? rig : host, part.data(), size_t(got))) return;
      if (!is_host) carried += size_t(got);
      if (!is_host && cuts_left_ > 0 && carried >= cut_after_) {
        --cuts_left_;
        return;
      }
    }
  }
}

}  // namespace lamella::testing
