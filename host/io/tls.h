// The host's end of TLS 1.3 on a socket that does not block: both ends certified, the rig's key
// pinned. proto/PROTOCOL.md says what the two protocols are.
#pragma once

#include <openssl/types.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "io/identity.h"

namespace lamella {

inline constexpr char kBurstProtocol[] = "lamella/1";
inline constexpr char kPairProtocol[] = "lamella-pair/1";

// Why a handshake failed, where somebody knows what to do about it.
inline constexpr char kAnswersInTheClear[] = "it answers in the clear, and was spoken to in TLS";
inline constexpr char kNotPaired[] = "it is not paired with this host";
inline constexpr char kAnotherKey[] = "its key is not that of a rig that this host is paired with";

struct TlsOptions {
  std::shared_ptr<const Identity> identity;
  std::string protocol = kBurstProtocol;            // ALPN
  std::function<bool(const Fingerprint&)> accepts;  // the rig's key; asked before anything is sent
};

class Tls {
 public:
  struct Line;  // the socket below

  enum class Progress { kDone, kWantsRead, kWantsWrite, kClosed };

  // `fd` stays the caller's.
  Tls(int fd, TlsOptions options);
  ~Tls();
  Tls(const Tls&) = delete;
  Tls& operator=(const Tls&) = delete;

  // Each does as much as it can now; `done` says how many bytes that was.
  Progress shake_hands();
  Progress write(const uint8_t* bytes, size_t size, size_t* done);
  Progress read(uint8_t* bytes, size_t room, size_t* done);

  // Why it is kClosed, in words.
  const std::string& reason() const { return reason_; }

  // After the handshake.
  const Fingerprint& peer() const { return peer_; }
  std::array<uint8_t, 32> channel() const;  // the same at both ends, known to nobody else

 private:
  struct Free {
    void operator()(SSL_CTX* context) const;
    void operator()(SSL* tls) const;
  };

  static int verify(X509_STORE_CTX* store, void* self);
  Progress judge(int result);

  TlsOptions options_;
  std::unique_ptr<Line> line_;
  std::unique_ptr<SSL_CTX, Free> context_;
  std::unique_ptr<SSL, Free> tls_;
  Fingerprint peer_{};
  bool refused_peer_ = false;
  std::string reason_;
};

}  // namespace lamella
