#include "io/paired_link.h"

#include "base/error.h"
#include "io/known_rigs.h"

namespace lamella {

bool is_loopback(const std::string& address) {
  return address.starts_with("127.") || address.starts_with("localhost:") ||
         address.starts_with("[::1]:");
}

namespace {

std::string port_of(const std::string& address) { return address.substr(address.rfind(':') + 1); }

// This computer has several names, and a rig on it one port.
const KnownRig* known_at(const KnownRigs& known, const std::string& address) {
  const KnownRig* here = known.at(address);
  if (here || !is_loopback(address)) return here;
  for (const KnownRig& rig : known.rigs()) {
    if (is_loopback(rig.address) && port_of(rig.address) == port_of(address)) return &rig;
  }
  return nullptr;
}

}  // namespace

std::optional<TlsOptions> tls_for(const std::string& address, const fs::path& folder) {
  const KnownRigs known(folder);
  const KnownRig* here = known_at(known, address);
  if (!here && is_loopback(address)) return {};
  if (known.rigs().empty()) {
    throw Error(Fault::kRig, "rig " + address, "not paired with this host",
                "hold its START button and run: lamella rig pair --rig " + address);
  }
  TlsOptions tls;
  tls.identity = std::make_shared<Identity>(folder);
  // A rig whose address is new may be any of the paired ones; one that is known must be itself.
  if (here) {
    tls.accepts = [key = here->fingerprint](const Fingerprint& peer) { return peer == key; };
  } else {
    tls.accepts = [known](const Fingerprint& peer) { return known.find(peer) != nullptr; };
  }
  return tls;
}

}  // namespace lamella
