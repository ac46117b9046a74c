// The rigs that this host is paired with: known_rigs in the configuration folder, a line each,
// "FINGERPRINT ADDRESS NAME". The fingerprint is what is trusted; address and name help people.
#pragma once

#include <string>
#include <vector>

#include "io/identity.h"

namespace lamella {

struct KnownRig {
  Fingerprint fingerprint{};
  std::string address;  // HOST:PORT where it was paired
  std::string name;
};

class KnownRigs {
 public:
  // Throws Error (kBadInput) that names the line that cannot be understood.
  explicit KnownRigs(const fs::path& folder);
  static std::vector<KnownRig> parse(const std::string& text, const std::string& where);

  const std::vector<KnownRig>& rigs() const { return rigs_; }
  const KnownRig* find(const Fingerprint& fingerprint) const;
  const KnownRig* at(const std::string& address) const;

  // A rig at an address takes the place of the one that was known there. On the disk at return.
  void add(const KnownRig& rig);
  void forget(const std::string& address);

 private:
  void write() const;

  fs::path path_;
  std::vector<KnownRig> rigs_;
};

}  // namespace lamella
