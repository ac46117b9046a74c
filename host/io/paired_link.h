// Which rigs this host talks to, and how: over TLS with a paired rig's key pinned, or in the clear
// on loopback.
#pragma once

#include <optional>
#include <string>

#include "io/tls.h"

namespace lamella {

// How to talk to the rig at `address`, by the pairings in `folder`. nullopt: in the clear, as it is
// on loopback and not paired there. Throws Error (kRig) for a rig elsewhere while none is paired.
std::optional<TlsOptions> tls_for(const std::string& address, const fs::path& folder);

bool is_loopback(const std::string& address);

}  // namespace lamella
