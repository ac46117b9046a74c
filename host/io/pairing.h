// The host's half of pairing (proto/pair.proto, PROTOCOL.md): both ends prove that they know the
// code that the rig blinks while its button is held, without telling it to whoever may be in
// between.
#pragma once

#include <functional>
#include <string>

#include "io/known_rigs.h"
#include "io/wire.h"

namespace lamella {

inline constexpr int kPairDigits = 5;

struct PairingOptions {
  double connect_s = 5;
  double reply_s = 10;
  double wait_s = 60;                      // for the button
  std::function<void()> reached;           // the rig is there: the button may be held
  std::function<std::string()> read_code;  // asked once the rig blinks
  std::function<bool()> interrupted;
};

// The rig that is paired with this host from now on. Throws Error (kRig) with what went wrong, or
// (kBadInput) for a code that is none.
KnownRig pair_with_rig(const std::string& address, std::shared_ptr<const Identity> identity,
                       const PairingOptions& options);

// Asks the rig with this key to let this host in no longer. False: it did not know this host.
bool be_forgotten(const std::string& address, std::shared_ptr<const Identity> identity,
                  const Fingerprint& rig, const PairingOptions& options);

// What binds one side to one digit.
struct PairSecret {
  int place = 0;
  int digit = 0;
  std::array<uint8_t, 32> nonce{}, channel{};
  Fingerprint host{}, rig{};
};
std::array<uint8_t, 32> pair_commitment(const PairSecret& secret, bool of_rig);

// What pair_with_rig() does once there is a connection; the rig's name. `secret` has the channel
// and both keys.
std::string hold_ceremony(Socket socket, const std::string& address, PairSecret secret,
                          const PairingOptions& options);

}  // namespace lamella
