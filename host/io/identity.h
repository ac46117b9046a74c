// Who this host is on a TLS connection: a private key of its own, and what a peer's key is known
// by, the SHA-256 of its public half (SubjectPublicKeyInfo). Certificates only wrap keys here: they
// are self-signed, and no authority, name or date in them counts.
#pragma once

#include <openssl/types.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace lamella {

namespace fs = std::filesystem;

using Fingerprint = std::array<uint8_t, 32>;

std::string to_hex(const Fingerprint& fingerprint);
std::optional<Fingerprint> fingerprint_from_hex(const std::string& hex);  // 64 lower-case digits

// nullopt where the key is of no kind that the link uses (Ed25519, P-256).
std::optional<Fingerprint> fingerprint_of(const X509* certificate);
// The same of one DER certificate and nothing after it.
std::optional<Fingerprint> fingerprint_of_der(const uint8_t* bytes, size_t size);

// $XDG_CONFIG_HOME/lamella, else ~/.config/lamella.
fs::path config_folder();

// Throws Error (kBadInput) for a file of the folder that others may read or write, is no plain
// file, or is over 64 KiB. nullopt: there is none.
std::optional<std::string> read_private_file(const fs::path& path);
// Whole or not at all, mode 0600; its folder is made, mode 0700.
void write_private_file(const fs::path& path, const std::string& text);

class Identity {
 public:
  // Reads `folder`/key.pem, or makes a key and writes it there. Throws Error (kBadInput).
  explicit Identity(const fs::path& folder);
  ~Identity();
  Identity(const Identity&) = delete;
  Identity& operator=(const Identity&) = delete;

  const Fingerprint& fingerprint() const { return fingerprint_; }
  EVP_PKEY* key() const { return key_.get(); }
  X509* certificate() const { return certificate_.get(); }

 private:
  struct Free {
    void operator()(EVP_PKEY* key) const;
    void operator()(X509* certificate) const;
  };

  std::unique_ptr<EVP_PKEY, Free> key_;
  std::unique_ptr<X509, Free> certificate_;
  Fingerprint fingerprint_{};
};

}  // namespace lamella
