#include "io/identity.h"

#include <fcntl.h>
#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/sha.h>
#include <openssl/x509.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "base/error.h"
#include "io/whole_file.h"

namespace lamella {

namespace {

constexpr size_t kMaxFileBytes = 64 << 10;

using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;

std::string pem_of(EVP_PKEY* key, const fs::path& path) {
  const Bio bio(BIO_new(BIO_s_secmem()), &BIO_free);
  if (!bio || PEM_write_bio_PrivateKey(bio.get(), key, nullptr, nullptr, 0, nullptr, nullptr) != 1)
    throw_bad_input(path.string(), "OpenSSL cannot make a key");
  char* text = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &text);
  return {text, size_t(size)};
}

EVP_PKEY* parse_key(const std::string& text) {
  const Bio bio(BIO_new_mem_buf(text.data(), int(text.size())), &BIO_free);
  char no_passphrase[] = "";  // else OpenSSL asks for one on the terminal
  return PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, no_passphrase);
}

bool is_p256(const EVP_PKEY* key) {
  char group[32];
  return EVP_PKEY_is_a(key, "EC") &&
         EVP_PKEY_get_group_name(key, group, sizeof group, nullptr) == 1 &&
         std::strcmp(group, "prime256v1") == 0;
}

bool fill_certificate(X509* certificate, EVP_PKEY* key) {
  X509_NAME* name = X509_get_subject_name(certificate);
  const auto* common_name = reinterpret_cast<const unsigned char*>("lamella");
  const EVP_MD* digest = EVP_PKEY_is_a(key, "ED25519") ? nullptr : EVP_sha256();
  return X509_set_version(certificate, X509_VERSION_3) == 1 &&
         ASN1_INTEGER_set(X509_get_serialNumber(certificate), 1) == 1 &&
         ASN1_TIME_set_string(X509_getm_notBefore(certificate), "19700101000000Z") == 1 &&
         ASN1_TIME_set_string(X509_getm_notAfter(certificate), "99991231235959Z") == 1 &&
         X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, common_name, -1, -1, 0) == 1 &&
         X509_set_issuer_name(certificate, name) == 1 && X509_set_pubkey(certificate, key) == 1 &&
         X509_sign(certificate, key, digest) > 0;
}

}  // namespace

std::string to_hex(const Fingerprint& fingerprint) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const uint8_t byte : fingerprint) hex += {kDigits[byte >> 4], kDigits[byte & 15]};
  return hex;
}

std::optional<Fingerprint> fingerprint_from_hex(const std::string& hex) {
  Fingerprint fingerprint;
  if (hex.size() != 2 * fingerprint.size()) return {};
  const auto value = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
  };
  for (size_t i = 0; i < fingerprint.size(); ++i) {
    const int high = value(hex[2 * i]), low = value(hex[2 * i + 1]);
    if (high < 0 || low < 0) return {};
    fingerprint[i] = uint8_t(high << 4 | low);
  }
  return fingerprint;
}

std::optional<Fingerprint> fingerprint_of(const X509* certificate) {
  const EVP_PKEY* key = X509_get0_pubkey(certificate);
  if (!key || !(EVP_PKEY_is_a(key, "ED25519") || is_p256(key))) return {};
  unsigned char* der = nullptr;
  const int size = i2d_X509_PUBKEY(X509_get_X509_PUBKEY(certificate), &der);
  if (size <= 0) return {};
  Fingerprint fingerprint;
  SHA256(der, size_t(size), fingerprint.data());
  OPENSSL_free(der);
  return fingerprint;
}

std::optional<Fingerprint> fingerprint_of_der(const uint8_t* bytes, size_t size) {
  const unsigned char* at = bytes;
  const std::unique_ptr<X509, decltype(&X509_free)> certificate(d2i_X509(nullptr, &at, long(size)),
                                                                &X509_free);
  if (!certificate || at != bytes + size) return {};
  return fingerprint_of(certificate.get());
}

fs::path config_folder() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  if (config && *config == '/') return fs::path(config) / "lamella";
  const char* home = std::getenv("HOME");
  if (home && *home == '/') return fs::path(home) / ".config" / "lamella";
  const passwd* user = getpwuid(getuid());
  if (!user) throw_bad_input("HOME", "not set", "set it, or XDG_CONFIG_HOME");
  return fs::path(user->pw_dir) / ".config" / "lamella";
}

std::optional<std::string> read_private_file(const fs::path& path) {
  struct stat state;
  if (stat(path.c_str(), &state) != 0) {
    if (errno == ENOENT) return {};
    throw_bad_input(path.string(), std::strerror(errno));
  }
  if (!S_ISREG(state.st_mode))
    throw_bad_input(path.string(), "not a plain file", "move it away, and a new one is made");
  if ((state.st_mode & 077) != 0) {
    throw_bad_input(path.string(), "others may read or write it", "chmod 600");
  }
  return read_text(path, kMaxFileBytes);
}

void write_private_file(const fs::path& path, const std::string& text) {
  std::error_code error;
  fs::create_directories(path.parent_path().parent_path(), error);
  mkdir(path.parent_path().c_str(), 0700);
  write_whole_file(path, [&](const fs::path& temporary) {
    const int fd = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    const bool written = fd >= 0 && fchmod(fd, 0600) == 0 &&
                         write(fd, text.data(), text.size()) == ssize_t(text.size()) &&
                         fsync(fd) == 0;
    const int cause = errno;
    if (fd >= 0) close(fd);
    if (!written) throw_bad_input(path.string(), std::strerror(cause));
  });
}

void Identity::Free::operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
void Identity::Free::operator()(X509* certificate) const { X509_free(certificate); }

Identity::Identity(const fs::path& folder) {
  const fs::path path = folder / "key.pem";
  if (const std::optional<std::string> text = read_private_file(path)) {
    key_.reset(parse_key(*text));
    if (!key_) throw_bad_input(path.string(), "no private key", "remove it, and pair again");
  } else {
    key_.reset(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
    write_private_file(path, pem_of(key_.get(), path));
  }
  certificate_.reset(X509_new());
  std::optional<Fingerprint> own;
  if (fill_certificate(certificate_.get(), key_.get())) own = fingerprint_of(certificate_.get());
  if (!own)
    throw_bad_input(path.string(), "neither an Ed25519 nor a P-256 key",
                    "move it away, and a new one is made");
  fingerprint_ = *own;
}

Identity::~Identity() = default;

}  // namespace lamella
