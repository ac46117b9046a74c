// Host and rig as they meet on a network: the firmware's daemon, the host's client, TLS between
// them, and somebody who listens to the wire.
#include <gtest/gtest.h>
#include <openssl/ssl.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "base/error.h"
#include "firmware/test_calibration.h"
#include "io/crc32c.h"
#include "io/known_rigs.h"
#include "io/link_client.h"
#include "io/paired_link.h"
#include "io/pairing.h"
#include "link/recording_proxy.h"
#include "link/rig_process.h"

namespace lamella {
namespace {

using testing::RecordingProxy;
using testing::RigUnderTest;
using testing::say;

constexpr int kHandshake = 22, kEncrypted = 23;

class Wire : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/lamella-wire-test-XXXXXX";
    folder = mkdtemp(name);
    fs::create_directory(state());
    fs::permissions(state(), fs::perms::owner_all);
    std::ofstream(folder / "calibration.json") << calibration_text();
  }
  void TearDown() override { fs::remove_all(folder); }

  fs::path state() const { return folder / "rig"; }
  fs::path paired_hosts() const { return state() / "paired_hosts"; }

  std::vector<std::string> arguments(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all = {
        "--twin",   twin.path(),   "--calibration", folder / "calibration.json",
        "--listen", "127.0.0.1:0", "--state",       state(),
        "--name",   "the rig"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  std::shared_ptr<const Identity> identity(const std::string& of) const {
    return std::make_shared<const Identity>(folder / of);
  }

  // As if they had been paired before the daemon was started.
  void pair_by_hand(const Identity& host) const {
    write_private_file(paired_hosts(), to_hex(host.fingerprint()) + " by hand\n");
  }

  // The rig's key, which it would make by itself.
  Fingerprint rig_key() const { return Identity(state()).fingerprint(); }

  LinkOptions link(const std::string& of, const Fingerprint& rig) const {
    LinkOptions options;
    options.reply_s = 5;
    options.backoff_s = 0.01;
    options.tls = TlsOptions{identity(of), kBurstProtocol,
                             [rig](const Fingerprint& peer) { return peer == rig; }};
    return options;
  }

  // Runs the ceremony; `spoil` may change the code on its way through the operator's head.
  KnownRig pair(RigUnderTest* rigd, const std::string& address, const std::string& of,
                const std::function<void(std::string*)>& spoil = {}) const {
    PairingOptions options;
    options.wait_s = 5;
    options.read_code = [&] {
      std::string line = rigd->error_line("START is held");
      std::string code = line.substr(line.find_last_of(' ') + 1);
      if (spoil) spoil(&code);
      return code;
    };
    return pair_with_rig(address, identity(of), options);
  }

  fs::path folder;
  testing::TestTwin twin{300};
};

const std::vector<std::string> kHeld = {"--inject", "press:0:9e8"};

template <class Act>
std::string failure(const Act& act) {
  try {
    act();
  } catch (const Error& e) {
    return e.what();
  }
  return "nothing failed";
}

::testing::AssertionResult says(const std::string& line, const std::string& part) {
  if (line.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "\"" << line << "\" lacks \"" << part << "\"";
}

TEST_F(Wire, PairedHostTakesABurstAndNothingOfItIsReadableOnTheWire) {
  pair_by_hand(*identity("host"));
  RigUnderTest rigd(arguments());
  RecordingProxy proxy(rigd.port());
  LinkClient client(proxy.address(), link("host", rig_key()));
  EXPECT_NE(client.calibration({}).find("lamella.session.v1"), std::string::npos);
  const auto offers = client.offers(client.run_burst("sphere", false, true));
  ASSERT_EQ(offers.size(), 40u);
  for (const v1::FrameOffer& offer : offers) client.acknowledge(offer);
  for (const auto& stream : {proxy.from_rig(), proxy.from_host()}) {
    const std::string text(stream.begin(), stream.end());
    EXPECT_EQ(text.find("lamella.session"), std::string::npos);
    for (const auto& record : testing::records(stream)) EXPECT_LE(record.size, 16384u + 256);
  }
}

TEST_F(Wire, TransferGoesOnAtAnyByteThatTheLineIsCutAt) {
  pair_by_hand(*identity("host"));
  RigUnderTest rigd(arguments());
  RecordingProxy proxy(rigd.port());
  LinkClient client(proxy.address(), link("host", rig_key()));
  const auto offers = client.offers(client.run_burst("sphere", false, true));
  const std::vector<uint8_t> whole = client.photograph(offers[3]);
  // In the handshake, in a record's first byte, in the middle of a chunk, between two.
  for (const size_t cut : {1u, 300u, 900u, 1500u, 20000u, 33000u, 70001u, 100000u}) {
    const int before = proxy.connections();
    proxy.cut_after(cut, 3);
    EXPECT_EQ(client.photograph(offers[3]), whole) << cut;
    EXPECT_EQ(proxy.connections(), before + 3) << cut;
  }
}

TEST_F(Wire, EachEndThatIsInTheClearWhereTheOtherIsInTlsIsToldWhichAndWhatToDo) {
  pair_by_hand(*identity("host"));
  RigUnderTest in_tls(arguments());
  LinkOptions clear = link("host", rig_key());
  clear.tls.reset();
  const std::string of_tls = failure([&] { LinkClient(in_tls.address(), clear); });
  EXPECT_TRUE(says(of_tls, "it answers in TLS, and was spoken to in the clear"));
  EXPECT_TRUE(says(of_tls, "lamella rig pair --rig " + in_tls.address()));
  RigUnderTest in_the_clear({"--twin", twin.path(), "--calibration", folder / "calibration.json",
                             "--listen", "127.0.0.1:0"});
  const std::string of_clear =
      failure([&] { LinkClient(in_the_clear.address(), link("host", rig_key())); });
  EXPECT_TRUE(says(of_clear, "it answers in the clear, and was spoken to in TLS"));
  EXPECT_TRUE(says(of_clear, "start its lamella-rigd with --state"));
}

TEST_F(Wire, APairedHostThatSaysNothingIsPutOutSoThatOthersGetIn) {
  pair_by_hand(*identity("host"));
  RigUnderTest rigd(arguments());
  Socket silent;
  ASSERT_FALSE(silent.connect_tcp(rigd.address(), deadline_in(5)));
  ASSERT_FALSE(silent.start_tls(*link("host", rig_key()).tls, deadline_in(5)));
  LinkClient client(rigd.address(), link("host", rig_key()));
  EXPECT_EQ(client.status().state(), v1::IDLE);
  v1::Reply reply;
  ASSERT_FALSE(silent.receive(&reply, deadline_in(5)));
  EXPECT_EQ(reply.refusal().reason(), "a host says hello within 2 s");
}

TEST_F(Wire, ADaemonKilledInMidBurstIsACutLinkAndItsPartOfTheBurstIsNamed) {
  pair_by_hand(*identity("host"));
  const testing::TestTwin slow(3000);  // photographs of 2 MB
  const fs::path store = folder / "store";
  fs::create_directory(store);
  const std::vector<std::string> more{"--twin", slow.path(), "--store", store};
  RigUnderTest first(arguments(more));
  const std::string address = first.address();
  LinkOptions patient = link("host", rig_key());
  patient.backoff_s = 0.1;
  LinkClient client(address, patient);
  std::unique_ptr<RigUnderTest> second;
  std::thread power([&] {
    while (!fs::exists(store / "burst-000001.partial" / "frame-05.record")) usleep(1000);
    first.kill();
    std::vector<std::string> again = more;
    again.insert(again.end(), {"--listen", address});
    second = std::make_unique<RigUnderTest>(arguments(again));
  });
  const std::string line = failure([&] { client.run_burst("sphere", false, true); });
  power.join();
  EXPECT_TRUE(says(line, "link cut during burst 1 ("));
  EXPECT_TRUE(says(line, "the rig was off meanwhile, and has a part of it (power or the daemon"));
  EXPECT_TRUE(says(line, "lamella rig sync --rig " + address));
}

TEST_F(Wire, TheNewestBurstOfWhichPhotographsAreHeldIsFetchedAlthoughANewerOneIsGone) {
  pair_by_hand(*identity("host"));
  fs::create_directory(folder / "store");
  const Fingerprint key = rig_key();  // before the rig looks for one, or both would make it
  RigUnderTest rigd(arguments({"--store", folder / "store"}));
  LinkClient client(rigd.address(), link("host", key));
  const Burst first = client.run_burst("sphere", false, true);
  const Burst second = client.run_burst("sphere", false, true);
  for (const v1::FrameOffer& offer : client.offers(second)) client.acknowledge(offer);
  EXPECT_EQ(client.held_burst().id, first.id);
}

TEST_F(Wire, HostThatIsNotPairedGetsAnAlertAndNothingElse) {
  pair_by_hand(*identity("host"));
  RigUnderTest rigd(arguments());
  RecordingProxy proxy(rigd.port());
  const std::string line =
      failure([&] { LinkClient(proxy.address(), link("stranger", rig_key())); });
  EXPECT_TRUE(says(line, "not paired with this host"));
  // After the rig's handshake flight: its alert, of two bytes, sealed.
  const auto records = testing::records(proxy.from_rig());
  ASSERT_FALSE(records.empty());
  EXPECT_EQ(records.back().type, kEncrypted);
  EXPECT_EQ(records.back().size, 2u + 1 + 16);
  EXPECT_TRUE(says(rigd.error_line("refused"), "certificate"));
}

TEST_F(Wire, RigWithAnotherKeyIsToldNothing) {
  pair_by_hand(*identity("host"));
  RigUnderTest rigd(arguments());
  RecordingProxy proxy(rigd.port());
  const Fingerprint expected = identity("another rig")->fingerprint();
  const std::string line = failure([&] { LinkClient(proxy.address(), link("host", expected)); });
  EXPECT_TRUE(says(line, "not that of a rig that this host is paired with"));
  const auto records = testing::records(proxy.from_host());
  ASSERT_FALSE(records.empty());
  EXPECT_EQ(records.front().type, kHandshake);
  for (size_t i = 1; i < records.size(); ++i) EXPECT_LE(records[i].size, 2u + 1 + 16);
}

TEST_F(Wire, SecondPairedHostIsTurnedAwayWhileTheFirstIsThere) {
  pair_by_hand(*identity("host"));
  RigUnderTest rigd(arguments());
  const std::string address = rigd.address();
  LinkClient first(address, link("host", rig_key()));
  EXPECT_TRUE(says(failure([&] { LinkClient(address, link("host", rig_key())); }), "busy"));
  EXPECT_EQ(first.status().state(), v1::IDLE);
}

TEST_F(Wire, SilentGuestsKeepNobodyOut) {
  pair_by_hand(*identity("host"));
  RigUnderTest rigd(arguments());
  const int port = rigd.port();
  std::vector<int> silent;
  for (int i = 0; i < 6; ++i) silent.push_back(testing::connect_to(port));
  LinkClient client(rigd.address(), link("host", rig_key()));
  EXPECT_EQ(client.status().state(), v1::IDLE);
  for (const int fd : silent) close(fd);
}

TEST_F(Wire, PlainBytesAndOlderTlsAreRefused) {
  RigUnderTest rigd(arguments());
  const int port = rigd.port();
  EXPECT_TRUE(say(port, {5, 0, 0, 0, 8, 1, 18, 1, 8}, 2).size() <= 7);  // an alert at most
  SSL_CTX* context = SSL_CTX_new(TLS_client_method());
  SSL_CTX_set_max_proto_version(context, TLS1_2_VERSION);
  SSL* tls = SSL_new(context);
  const int fd = testing::connect_to(port);
  SSL_set_fd(tls, fd);
  EXPECT_LE(SSL_connect(tls), 0);
  SSL_free(tls);
  SSL_CTX_free(context);
  close(fd);
}

TEST_F(Wire, HeldButtonAndItsCodePairHostAndRig) {
  RigUnderTest rigd(arguments(kHeld));
  const std::string address = rigd.address();
  const KnownRig rig = pair(&rigd, address, "host");
  EXPECT_EQ(rig.name, "the rig");
  EXPECT_EQ(rig.fingerprint, rig_key());
  EXPECT_EQ(LinkClient(address, link("host", rig_key())).status().state(), v1::IDLE);
  EXPECT_EQ(fs::status(state() / "key.pem").permissions(), fs::perms(0600));
  EXPECT_EQ(fs::status(paired_hosts()).permissions(), fs::perms(0600));

  EXPECT_TRUE(be_forgotten(address, identity("host"), rig_key(), {}));
  EXPECT_TRUE(says(failure([&] { LinkClient(address, link("host", rig_key())); }), "not paired"));
  EXPECT_FALSE(be_forgotten(address, identity("host"), rig_key(), {}));
}

TEST_F(Wire, ARigInFaultIsPairedWithAllTheSame) {
  pair_by_hand(*identity("host"));
  std::vector<std::string> broken = kHeld;
  broken.insert(broken.end(), {"--inject", "spi-error:1"});
  RigUnderTest rigd(arguments(broken));
  const std::string address = rigd.address();
  LinkClient client(address, link("host", rig_key()));
  EXPECT_TRUE(says(failure([&] { client.run_burst("sphere", false, true); }), "fault"));
  EXPECT_EQ(client.status().state(), v1::FAULT);
  EXPECT_EQ(pair(&rigd, address, "another host").fingerprint, rig_key());
}

TEST_F(Wire, AnAbortWhoseAnswerIsLostIsAskedAgainAndAnsweredAsItWas) {
  RigUnderTest rigd({"--twin", twin.path(), "--calibration", folder / "calibration.json",
                     "--listen", "127.0.0.1:0", "--inject", "spi-error:1"});
  LinkOptions options;
  options.reply_s = 5;
  options.backoff_s = 0.01;
  {
    LinkClient client(rigd.address(), options);
    EXPECT_TRUE(says(failure([&] { client.run_burst("sphere", false, true); }), "fault"));
  }
  RecordingProxy proxy(rigd.port());
  size_t greeting = 0;
  {
    LinkClient client(proxy.address(), options);
    EXPECT_EQ(client.status().state(), v1::FAULT);
    greeting = proxy.from_rig().size();
  }
  proxy.cut_after(greeting + 1, 1);
  LinkClient client(proxy.address(), options);
  EXPECT_EQ(client.status().state(), v1::FAULT);
  EXPECT_EQ(client.abort().state(), v1::IDLE);
  EXPECT_EQ(proxy.connections(), 3);
  EXPECT_TRUE(says(failure([&] { client.abort(); }), "there is no burst to abort"));
}

TEST_F(Wire, PairingOutlivesTheDaemon) {
  {
    RigUnderTest rigd(arguments(kHeld));
    pair(&rigd, rigd.address(), "host");
  }
  RigUnderTest rigd(arguments());
  EXPECT_EQ(LinkClient(rigd.address(), link("host", rig_key())).status().state(), v1::IDLE);
}

TEST_F(Wire, ButtonThatIsNotHeldPairsNobody) {
  RigUnderTest rigd(arguments());
  PairingOptions options;
  options.wait_s = 0.2;
  const std::string address = rigd.address();
  const std::string line = failure([&] { pair_with_rig(address, identity("host"), options); });
  EXPECT_TRUE(says(line, "BUTTON"));
  EXPECT_FALSE(fs::exists(paired_hosts()));
  EXPECT_TRUE(says(failure([&] { LinkClient(address, link("host", rig_key())); }), "not paired"));
}

TEST_F(Wire, WrongCodePairsNobody) {
  RigUnderTest rigd(arguments(kHeld));
  const std::string address = rigd.address();
  for (const size_t place : {0u, 4u}) {
    const std::string line = failure([&] {
      pair(&rigd, address, "host", [&](std::string* code) {
        char& digit = (*code)[place];
        digit = digit == '6' ? '1' : char(digit + 1);
      });
    });
    EXPECT_TRUE(says(line, "WRONG_CODE"));
    EXPECT_FALSE(fs::exists(paired_hosts()));
  }
}

TEST_F(Wire, ReplayedPairingIsRefused) {
  RigUnderTest rigd(arguments(kHeld));
  const int port = rigd.port();
  std::vector<uint8_t> recorded;
  {
    RecordingProxy proxy(port);
    pair(&rigd, proxy.address(), "host");
    recorded = proxy.from_host();
  }
  ASSERT_GT(recorded.size(), 1000u);
  be_forgotten(rigd.address(), identity("host"), rig_key(), {});
  // The rig answers the ClientHello with another key share: what follows it is not sealed for that.
  const std::vector<uint8_t> answer = say(port, recorded, 3);
  ASSERT_FALSE(answer.empty());
  EXPECT_TRUE(says(rigd.error_line("refused"), "refused"));
  EXPECT_EQ(fs::file_size(paired_hosts()), 0u);
  EXPECT_TRUE(
      says(failure([&] { LinkClient(rigd.address(), link("host", rig_key())); }), "not paired"));
}

TEST_F(Wire, AttemptsToPairAreFewAMinute) {
  RigUnderTest rigd(arguments());
  const std::string address = rigd.address();
  PairingOptions options;
  options.wait_s = 0;
  std::string line;
  for (int i = 0; i < 8; ++i) {
    line = failure([&] { pair_with_rig(address, identity("host"), options); });
  }
  EXPECT_TRUE(says(line, "TOO_OFTEN"));
}

TEST_F(Wire, ARigOnThisComputerIsTheSameByAnyOfItsNames) {
  KnownRigs known(folder / "host");
  known.add({rig_key(), "127.0.0.1:7420", "near"});
  for (const char* address : {"localhost:7420", "127.1:7420", "[::1]:7420"}) {
    const auto here = tls_for(address, folder / "host");
    ASSERT_TRUE(here) << address;
    EXPECT_TRUE(here->accepts(rig_key()));
    EXPECT_FALSE(here->accepts(identity("another rig")->fingerprint()));
  }
  EXPECT_FALSE(tls_for("localhost:7421", folder / "host"));
}

TEST_F(Wire, BeyondLoopbackOnlyPairedRigsAreSpokenTo) {
  EXPECT_TRUE(says(failure([&] { tls_for("192.0.2.1:7420", folder / "host"); }), "not paired"));
  EXPECT_FALSE(tls_for("127.0.0.1:7420", folder / "host"));
  KnownRigs known(folder / "host");
  known.add({rig_key(), "192.0.2.1:7420", "far"});
  const auto here = tls_for("192.0.2.1:7420", folder / "host");
  ASSERT_TRUE(here);
  EXPECT_TRUE(here->accepts(rig_key()));
  EXPECT_FALSE(here->accepts(identity("another rig")->fingerprint()));
}

}  // namespace
}  // namespace lamella
