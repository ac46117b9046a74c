#include "io/pairing.h"

#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/sha.h>
#include <unistd.h>

#include <algorithm>
#include <vector>

#include "base/error.h"
#include "pair.pb.h"

namespace lamella {

namespace {

constexpr uint32_t kPairVersion = 1;
constexpr char kCommitLabel[] = "lamella pair commitment 1";

[[noreturn]] void fail(const std::string& address, const std::string& problem,
                       const std::string& remedy = "") {
  throw Error(Fault::kRig, "rig " + address, problem, remedy);
}

std::string own_name() {
  char name[64] = "host";
  gethostname(name, sizeof name - 1);
  return name;
}

// A connection for nothing but pairing.
Socket connect(const std::string& address, TlsOptions tls, const PairingOptions& options) {
  Socket socket;
  socket.set_interrupted(options.interrupted);
  const Deadline end = deadline_in(options.connect_s);
  Break broken = socket.connect_tcp(address, end);
  if (!broken) broken = socket.start_tls(std::move(tls), end);
  if (!broken) return socket;
  fail(address, "cannot be paired with (" + *broken + ")",
       "is lamella-rigd running there, with --state?");
}

struct Conversation {
  Socket socket;
  std::string address;

  v1::PairReply ask(const v1::PairRequest& request, double patience_s) {
    v1::PairReply reply;
    Break broken = socket.send(request, deadline_in(patience_s));
    if (!broken) broken = socket.receive(&reply, deadline_in(patience_s));
    if (broken) fail(address, "pairing broke off (" + *broken + ")", "start again");
    if (!reply.has_refusal()) return reply;
    fail(address, "refused to pair (" + v1::PairRefusal::Code_Name(reply.refusal().code()) +
                      "): " + reply.refusal().reason());
  }
};

std::vector<int> digits_of(const std::string& text) {
  std::vector<int> digits;
  for (const char c : text) {
    if (c == ' ' || c == '-') continue;
    if (c < '1' || c > '6')
      throw_bad_input("code", "digits are 1 to 6, as the rig blinks them",
                      "count its flashes again");
    digits.push_back(c - '0');
  }
  if (int(digits.size()) != kPairDigits)
    throw_bad_input("code", "has five digits, 1 to 6 each", "count its flashes again");
  return digits;
}

// Both ends commit themselves to a digit, then open that: neither can copy the other's.
void prove_digit(Conversation* rig, PairSecret secret, double patience_s) {
  if (RAND_bytes(secret.nonce.data(), int(secret.nonce.size())) != 1) {
    fail(rig->address, "this host has no random numbers");
  }
  const auto commitment = pair_commitment(secret, false);
  v1::PairRequest request;
  request.mutable_commit()->set_commitment(commitment.data(), commitment.size());
  const std::string promised = rig->ask(request, patience_s).commit().commitment();
  request.mutable_reveal()->set_nonce(secret.nonce.data(), secret.nonce.size());
  const std::string opened = rig->ask(request, patience_s).reveal().nonce();
  if (opened.size() != secret.nonce.size()) fail(rig->address, "did not open its commitment");
  std::copy(opened.begin(), opened.end(), secret.nonce.begin());
  const auto expected = pair_commitment(secret, true);
  if (promised.size() != expected.size() ||
      CRYPTO_memcmp(promised.data(), expected.data(), expected.size()) != 0) {
    fail(rig->address, "does not know the code that the rig blinks: somebody is in between",
         "pair on a network of your own");
  }
}

}  // namespace

std::array<uint8_t, 32> pair_commitment(const PairSecret& secret, bool of_rig) {
  std::vector<uint8_t> text(kCommitLabel, kCommitLabel + sizeof kCommitLabel);
  text.insert(text.end(), {uint8_t(of_rig), uint8_t(secret.place), uint8_t(secret.digit)});
  for (const auto& part : {secret.nonce, secret.channel, secret.host, secret.rig}) {
    text.insert(text.end(), part.begin(), part.end());
  }
  std::array<uint8_t, 32> hash;
  SHA256(text.data(), text.size(), hash.data());
  return hash;
}

std::string hold_ceremony(Socket socket, const std::string& address, PairSecret secret,
                          const PairingOptions& options) {
  Conversation rig{std::move(socket), address};
  v1::PairRequest request;
  request.mutable_open()->set_protocol_version(kPairVersion);
  request.mutable_open()->set_host_name(own_name());
  request.mutable_open()->set_wait_s(options.wait_s);
  const v1::PairReply reply = rig.ask(request, options.wait_s + options.reply_s);
  if (!reply.has_ready()) fail(address, "answered a request to pair with something else");
  for (const int digit : digits_of(options.read_code())) {
    secret.digit = digit;
    prove_digit(&rig, secret, options.reply_s);
    ++secret.place;
  }
  return reply.ready().rig_name();
}

KnownRig pair_with_rig(const std::string& address, std::shared_ptr<const Identity> identity,
                       const PairingOptions& options) {
  const TlsOptions tls{identity, kPairProtocol, [](const Fingerprint&) { return true; }};
  Socket socket = connect(address, tls, options);
  if (options.reached) options.reached();
  PairSecret secret;
  secret.channel = socket.tls()->channel();
  secret.host = identity->fingerprint();
  secret.rig = socket.tls()->peer();
  return {secret.rig, address, hold_ceremony(std::move(socket), address, secret, options)};
}

bool be_forgotten(const std::string& address, std::shared_ptr<const Identity> identity,
                  const Fingerprint& rig, const PairingOptions& options) {
  const TlsOptions tls{std::move(identity), kPairProtocol,
                       [rig](const Fingerprint& peer) { return peer == rig; }};
  Conversation conversation{connect(address, tls, options), address};
  v1::PairRequest request;
  request.mutable_forget();
  const v1::PairReply reply = conversation.ask(request, options.reply_s);
  if (!reply.has_forgotten()) fail(address, "answered a farewell with something else");
  return reply.forgotten().knew();
}

}  // namespace lamella
