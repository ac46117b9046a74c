// The rig's half of pairing, on a clock of ours, against hosts that know the code or do not.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

extern "C" {
#include "link_announce.h"
#include "link_pair.h"
#include "pb_encode.h"
}

namespace {

class Pairing : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/lamella-pair-test-XXXXXX";
    folder = mkdtemp(name);
    char error[400];
    ASSERT_EQ(trust_open(&trust, folder.c_str(), error, sizeof error), LAM_OK);
    struct identity identity = {};
    identity.fingerprint[0] = 9;
    pair_init(&pair, &trust, &identity, "rig");
    pair.context = this;
    pair.send = send;
    host.purpose = LINK_FOR_PAIRING;
    host.fingerprint[0] = 1;
    host.channel[0] = 2;
    pair_begin(&pair, &host, now_us);
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  static bool send(void* self, const lamella_v1_PairReply* reply) {
    static_cast<Pairing*>(self)->reply = *reply;
    return true;
  }

  bool ask(const lamella_v1_PairRequest& request) {
    uint8_t bytes[512];
    pb_ostream_t stream = pb_ostream_from_buffer(bytes, sizeof bytes);
    EXPECT_TRUE(pb_encode(&stream, lamella_v1_PairRequest_fields, &request));
    return pair_answer(&pair, bytes, stream.bytes_written, now_us);
  }

  bool open(double wait_s) {
    lamella_v1_PairRequest request = lamella_v1_PairRequest_init_zero;
    request.which_body = lamella_v1_PairRequest_open_tag;
    request.body.open.protocol_version = 1;
    std::strcpy(request.body.open.host_name, "pc\n\x1b[2J");
    request.body.open.wait_s = wait_s;
    return ask(request);
  }

  // Time passes in steps of 50 ms with the button as it is. False where the rig hung up.
  bool pass(double seconds, bool pressed) {
    for (const double end_us = now_us + seconds * 1e6; now_us < end_us; now_us += 50e3) {
      if (!pair_tick(&pair, pressed, now_us)) return false;
    }
    return true;
  }

  // A host that believes in this digit, on the channel that it sees. False where it was refused.
  bool prove(uint8_t digit, const struct link_peer& seen) {
    struct pair own = pair;
    own.host = seen;
    own.digits[own.digit] = digit;
    const uint8_t nonce[PAIR_NONCE_BYTES] = {5};
    lamella_v1_PairRequest request = lamella_v1_PairRequest_init_zero;
    request.which_body = lamella_v1_PairRequest_commit_tag;
    request.body.commit.commitment.size = PAIR_HASH_BYTES;
    pair_commitment(&own, false, nonce, request.body.commit.commitment.bytes);
    if (!ask(request)) return false;
    uint8_t promised[PAIR_HASH_BYTES];
    std::memcpy(promised, reply.body.commit.commitment.bytes, sizeof promised);
    request = lamella_v1_PairRequest_init_zero;
    request.which_body = lamella_v1_PairRequest_reveal_tag;
    request.body.reveal.nonce.size = PAIR_NONCE_BYTES;
    std::memcpy(request.body.reveal.nonce.bytes, nonce, sizeof nonce);
    ask(request);
    if (reply.which_body != lamella_v1_PairReply_reveal_tag) return false;
    uint8_t expected[PAIR_HASH_BYTES];
    pair_commitment(&own, true, reply.body.reveal.nonce.bytes, expected);
    return std::memcmp(expected, promised, sizeof promised) == 0;
  }

  void expect_refusal(lamella_v1_PairRefusal_Code code) {
    ASSERT_EQ(reply.which_body, lamella_v1_PairReply_refusal_tag);
    EXPECT_EQ(reply.body.refusal.code, code) << reply.body.refusal.reason;
    EXPECT_EQ(trust.count, 0u);
  }

  std::filesystem::path folder;
  struct trust trust;
  struct pair pair;
  struct link_peer host = {};
  double now_us = 1e6;
  lamella_v1_PairReply reply = lamella_v1_PairReply_init_zero;
};

}  // namespace

TEST_F(Pairing, HostThatKnowsEveryDigitIsLetIn) {
  ASSERT_TRUE(open(10));
  ASSERT_TRUE(pass(2, true));
  ASSERT_EQ(reply.which_body, lamella_v1_PairReply_ready_tag);
  const std::vector<uint8_t> code(pair.digits, pair.digits + PAIR_DIGITS);
  for (const uint8_t digit : code) ASSERT_TRUE(prove(digit, host));
  EXPECT_TRUE(trust_knows(&trust, host.fingerprint));
  EXPECT_STREQ(trust.hosts[0].name, "pc___2J");  // nothing that a terminal obeys
}

TEST_F(Pairing, ManInTheMiddleOfTwoChannelsFailsAtTheFirstDigitAlthoughItIsRight) {
  open(10);
  ASSERT_TRUE(pass(2, true));
  struct link_peer other = host;
  other.channel[0] ^= 1;  // what the real host has with him
  EXPECT_FALSE(prove(pair.digits[0], other));
  expect_refusal(lamella_v1_PairRefusal_Code_WRONG_CODE);
}

TEST_F(Pairing, AnotherHostsKeyFailsOnTheSameChannel) {
  open(10);
  ASSERT_TRUE(pass(2, true));
  struct link_peer other = host;
  other.fingerprint[0] ^= 1;
  EXPECT_FALSE(prove(pair.digits[0], other));
  expect_refusal(lamella_v1_PairRefusal_Code_WRONG_CODE);
}

TEST_F(Pairing, RigsOwnCommitmentCannotBeSentBackToIt) {
  open(10);
  ASSERT_TRUE(pass(2, true));
  lamella_v1_PairRequest request = lamella_v1_PairRequest_init_zero;
  request.which_body = lamella_v1_PairRequest_commit_tag;
  request.body.commit.commitment.size = PAIR_HASH_BYTES;
  ASSERT_TRUE(ask(request));
  request.which_body = lamella_v1_PairRequest_reveal_tag;
  request.body.reveal.nonce.size = PAIR_NONCE_BYTES;
  EXPECT_FALSE(ask(request));
  expect_refusal(lamella_v1_PairRefusal_Code_WRONG_CODE);
}

TEST_F(Pairing, NameAsLongAsAMachinesMayBeReachesTheHostInLettersThatItCanShow) {
  struct identity identity = {};
  pair_init(&pair, &trust, &identity, ("Z\xC3\xBCrich\n" + std::string(80, 'n')).c_str());
  pair.context = this;
  pair.send = send;
  pair_begin(&pair, &host, now_us);
  open(10);
  ASSERT_TRUE(pass(2, true));
  uint8_t bytes[512];
  pb_ostream_t stream = pb_ostream_from_buffer(bytes, sizeof bytes);
  EXPECT_TRUE(pb_encode(&stream, lamella_v1_PairReply_fields, &reply));
  EXPECT_EQ(reply.body.ready.rig_name, "Z__rich_" + std::string(56, 'n'));
}

TEST_F(Pairing, ButtonMustBeHeldForASecondWithinTheWait) {
  open(3);
  EXPECT_TRUE(pass(0.8, true));  // a click
  EXPECT_FALSE(pass(4, false));
  expect_refusal(lamella_v1_PairRefusal_Code_BUTTON);
}

TEST_F(Pairing, WithoutAWaitTheButtonMustBeDownAlready) {
  open(0);
  EXPECT_FALSE(pass(0.1, false));
  expect_refusal(lamella_v1_PairRefusal_Code_BUTTON);
}

TEST_F(Pairing, WindowClosesAfterTwoMinutes) {
  open(3);
  ASSERT_TRUE(pass(2, true));
  EXPECT_FALSE(pass(125, false));
  expect_refusal(lamella_v1_PairRefusal_Code_LATE);
}

TEST_F(Pairing, NobodyIsPairedDuringABurst) {
  pair.is_busy = true;
  EXPECT_FALSE(open(3));
  expect_refusal(lamella_v1_PairRefusal_Code_BUSY);
}

TEST_F(Pairing, NothingIsRevealedBeforeTheCodeIsShown) {
  lamella_v1_PairRequest request = lamella_v1_PairRequest_init_zero;
  request.which_body = lamella_v1_PairRequest_commit_tag;
  request.body.commit.commitment.size = PAIR_HASH_BYTES;
  EXPECT_FALSE(ask(request));
  expect_refusal(lamella_v1_PairRefusal_Code_BAD_REQUEST);
}

TEST_F(Pairing, AttemptsComeBackWithTime) {
  for (int i = 0; i < 6; i++) {
    EXPECT_TRUE(open(0)) << i;
    pair_begin(&pair, &host, now_us);
  }
  EXPECT_FALSE(open(0));
  expect_refusal(lamella_v1_PairRefusal_Code_TOO_OFTEN);
  now_us += 11e6;
  pair_begin(&pair, &host, now_us);
  EXPECT_TRUE(open(0));
}

TEST_F(Pairing, SeventeenthHostIsRefused) {
  char error[400];
  for (uint8_t i = 0; i < TRUST_MAX_HOSTS; i++) {
    const uint8_t fingerprint[FINGERPRINT_BYTES] = {100, i};
    ASSERT_EQ(trust_add(&trust, fingerprint, "another", error, sizeof error), LAM_OK) << error;
  }
  EXPECT_EQ(trust_add(&trust, host.fingerprint, "one more", error, sizeof error), LAM_STORE_FULL);
  struct trust again;
  ASSERT_EQ(trust_open(&again, folder.c_str(), error, sizeof error), LAM_OK);
  EXPECT_EQ(again.count, static_cast<size_t>(TRUST_MAX_HOSTS));
}

TEST_F(Pairing, LightBlinksEachDigitAsOften) {
  open(10);
  ASSERT_TRUE(pass(1.2, true));
  const uint8_t code[PAIR_DIGITS] = {3, 1, 6, 2, 5};
  std::memcpy(pair.digits, code, sizeof code);
  std::vector<int> counted;
  double dark_since_us = pair.shown_us;
  bool lit = false;
  for (double t_us = pair.shown_us; counted.size() <= PAIR_DIGITS; t_us += 10e3) {
    const bool light = pair_light(&pair, t_us);
    if (light && !lit) {
      if (t_us - dark_since_us > 700e3) counted.push_back(0);
      counted.back()++;
    }
    if (!light && lit) dark_since_us = t_us;
    lit = light;
  }
  counted.resize(PAIR_DIGITS);
  EXPECT_EQ(counted, (std::vector<int>{3, 1, 6, 2, 5}));
}

TEST_F(Pairing, ListOfHostsThatCannotBeUnderstoodIsRefusedByLine) {
  const std::string good(64, 'a');
  const std::vector<std::pair<std::string, int>> texts = {
      {"", 0},
      {good + " pc\n", 0},
      {good + " pc", 1},
      {good + " pc\n\n", 2},
      {good + " pc\n" + good + " twice\n", 2},
      {std::string(64, 'A') + " pc\n", 1},
      {good + "\n", 1},
      {good + " \x1b[2J\n", 1},
      {good + " " + std::string(65, 'x') + "\n", 1}};
  for (const auto& [text, line] : texts) {
    EXPECT_EQ(trust_parse(&trust, text.data(), text.size()), line) << text;
  }
}

TEST_F(Pairing, KeyThatOthersMayReadIsRefused) {
  struct identity identity;
  char error[400];
  ASSERT_EQ(identity_open(&identity, folder.c_str(), error, sizeof error), LAM_OK) << error;
  const std::vector<uint8_t> made(identity.fingerprint, identity.fingerprint + FINGERPRINT_BYTES);
  identity_close(&identity);
  ASSERT_EQ(identity_open(&identity, folder.c_str(), error, sizeof error), LAM_OK) << error;
  EXPECT_EQ(std::memcmp(made.data(), identity.fingerprint, made.size()), 0);
  identity_close(&identity);
  std::filesystem::permissions(folder / "key.pem", std::filesystem::perms(0640));
  EXPECT_EQ(identity_open(&identity, folder.c_str(), error, sizeof error), LAM_BAD_INPUT);
  EXPECT_NE(std::string(error).find("chmod 600"), std::string::npos) << error;
  std::filesystem::permissions(folder / "key.pem", std::filesystem::perms(0600));
  std::ofstream(folder / "key.pem") << "no key\n";
  EXPECT_EQ(identity_open(&identity, folder.c_str(), error, sizeof error), LAM_BAD_INPUT);
}

TEST_F(Pairing, AnnouncementNamesPortAndKeyAndNothingThatXmlCouldMistake) {
  char error[400];
  const std::string file = folder / "lamella.service", state = folder;
  struct link_place place = {"0.0.0.0:7391", state.c_str(), "studio rig"};
  ASSERT_EQ(announce_write(file.c_str(), &place, error, sizeof error), LAM_OK) << error;
  std::ifstream stream(file);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_NE(text.find("<name replace-wildcards=\"no\">studio rig</name>"), std::string::npos);
  EXPECT_NE(text.find("<port>7391</port>"), std::string::npos);
  place.name = "<rig>";
  EXPECT_EQ(announce_write(file.c_str(), &place, error, sizeof error), LAM_BAD_INPUT);
  place = {"0.0.0.0:0", state.c_str(), nullptr};
  EXPECT_EQ(announce_write(file.c_str(), &place, error, sizeof error), LAM_BAD_INPUT);
}
