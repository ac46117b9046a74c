// Rigs on this network, found by mDNS through the Avahi daemon. Nothing that is found this way is
// trusted: it is a list of places to try.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace lamella {

struct FoundRig {
  std::string name;
  std::string address;      // HOST:PORT, an IPv4 number
  std::string version;      // of the protocol
  std::string fingerprint;  // the first 16 digits of its key's
};

// Listens for so long. Throws Error (kRig) where there is no Avahi daemon.
std::vector<FoundRig> find_rigs(double seconds, const std::function<bool()>& interrupted = {});

}  // namespace lamella
