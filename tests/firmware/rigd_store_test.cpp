// lamella-rigd with a disk, as it is run, stopped and killed.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "fake_twin.h"
#include "store_bench.h"
#include "test_calibration.h"
#include "test_host.h"

extern "C" {
#include "crc32c.h"
}

namespace {

class RigdStore : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder.path() / "calibration.json") << calibration_text();
    std::filesystem::create_directory(store());
    start();
  }

  std::filesystem::path store() const { return folder.path() / "store"; }

  void start(const std::vector<std::string>& more = {}) {
    host.reset();
    rigd.reset();
    std::vector<std::string> arguments{
        "--hal",    "sim",         "--rig",         LAMELLA_BOARD_DIR "/sim.rig",
        "--twin",   twin.path(),   "--calibration", folder.path() / "calibration.json",
        "--listen", "127.0.0.1:0", "--store",       store()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    rigd = std::make_unique<RigProcess>(last_of_each(arguments));
    host = std::make_unique<TestHost>(rigd->port());
    host->ask(hello());
  }

  uint64_t run_burst(const std::string& subject = "") {
    lamella_v1_Request request = request_of(lamella_v1_Request_burst_tag);
    subject.copy(request.body.burst.subject, sizeof request.body.burst.subject - 1);
    const lamella_v1_Reply accepted = host->ask(request);
    EXPECT_EQ(accepted.which_body, lamella_v1_Reply_accepted_tag) << accepted.body.refusal.reason;
    lamella_v1_Reply reply = lamella_v1_Reply_init_zero;
    while (host->receive(&reply) && reply.which_body == lamella_v1_Reply_status_tag) continue;
    EXPECT_EQ(reply.which_body, lamella_v1_Reply_done_tag);
    return accepted.body.accepted.burst_id;
  }

  std::vector<lamella_v1_HeldBurst> held(lamella_v1_HeldEnd* end = nullptr) {
    std::vector<lamella_v1_HeldBurst> bursts;
    lamella_v1_Reply reply = host->ask(request_of(lamella_v1_Request_bursts_tag));
    while (reply.which_body == lamella_v1_Reply_held_tag) {
      bursts.push_back(reply.body.held);
      if (!host->receive(&reply)) break;
    }
    EXPECT_EQ(reply.which_body, lamella_v1_Reply_held_end_tag);
    if (end != nullptr) *end = reply.body.held_end;
    return bursts;
  }

  void take_away(const lamella_v1_FrameOffer& offer) {
    const std::vector<uint8_t> bytes =
        host->fetch({lamella_v1_BlobQuery_Kind_PHOTOGRAPH, offer.burst_id, offer.frame_id, 0});
    EXPECT_EQ(bytes.size(), offer.size_bytes);
    EXPECT_EQ(crc32c_extend(0, bytes.data(), bytes.size()), offer.crc32c);
    lamella_v1_Request ack = request_of(lamella_v1_Request_ack_tag);
    ack.body.ack = {offer.burst_id, offer.frame_id};
    EXPECT_EQ(host->ask(ack).which_body, lamella_v1_Reply_acknowledged_tag);
  }

  const TemporaryFolder folder;
  FakeTwin twin{20};
  std::unique_ptr<RigProcess> rigd;
  std::unique_ptr<TestHost> host;
};

}  // namespace

TEST_F(RigdStore, BurstsOutliveTheDaemonAndGoWithTheirLastAcknowledgement) {
  const uint64_t first = run_burst(), second = run_burst();
  rigd->signal(SIGKILL);
  start();
  lamella_v1_HeldEnd end;
  const auto bursts = held(&end);
  ASSERT_EQ(bursts.size(), 2u);
  EXPECT_TRUE(end.on_disk);
  EXPECT_GT(end.free_bytes, 0u);
  EXPECT_EQ(bursts[0].burst_id, first);
  EXPECT_EQ(bursts[1].burst_id, second);
  for (const lamella_v1_HeldBurst& burst : bursts) {
    EXPECT_TRUE(burst.whole) << burst.why;
    EXPECT_TRUE(burst.flashing_confirmed);
    EXPECT_EQ(burst.frames_held, 40u);
    for (const auto& offer : host->offers(burst.burst_id)) take_away(offer);
  }
  EXPECT_TRUE(held().empty());
  EXPECT_FALSE(std::filesystem::exists(store() / "burst-000001"));
  EXPECT_EQ(run_burst(), second + 1);
}

TEST_F(RigdStore, ABurstIsOfTheSubjectThatItsHostNamedOverAPowerCutToo) {
  const std::string longest(63, 'a');
  run_burst("Ada");
  run_burst();
  run_burst(longest);
  rigd->signal(SIGKILL);
  start();
  const auto bursts = held();
  ASSERT_EQ(bursts.size(), 3u);
  EXPECT_STREQ(bursts[0].subject, "Ada");
  EXPECT_STREQ(bursts[1].subject, "");
  EXPECT_EQ(bursts[2].subject, longest);
}

TEST_F(RigdStore, ADiskThatDoesNotTakeABurstIsAFaultOfTheRigWithItsReasonAndNotFull) {
  std::filesystem::remove_all(store());
  const lamella_v1_Refusal refusal =
      host->ask(request_of(lamella_v1_Request_burst_tag)).body.refusal;
  EXPECT_EQ(refusal.code, lamella_v1_Refusal_Code_RIG_FAULT);
  EXPECT_STREQ(refusal.reason,
               "a burst cannot be begun on the rig's disk: no such folder: make one");
}

TEST_F(RigdStore, AHostsBurstIsRefusedWhereLightsWouldNotGoOffByThemselves) {
  start({"--inject", "dead-monostable"});
  const lamella_v1_Refusal refusal =
      host->ask(request_of(lamella_v1_Request_burst_tag)).body.refusal;
  EXPECT_EQ(refusal.code, lamella_v1_Refusal_Code_RIG_FAULT);
  EXPECT_NE(std::string(refusal.reason).find("it stays lit when the heart stops"),
            std::string::npos)
      << refusal.reason;
}

// A twin answers one rig at a time: this one waits for photographs of its self-test.
TEST_F(RigdStore, ADaemonThatWaitsForATwinThatAnotherHasEndsWithTheSignal) {
  const std::string calibration = folder.path() / "calibration.json", other = folder.path() / "b";
  std::filesystem::create_directory(other);
  RigProcess second({"--hal", "sim", "--rig", LAMELLA_BOARD_DIR "/sim.rig", "--twin", twin.path(),
                     "--calibration", calibration, "--listen", "127.0.0.1:0", "--store", other,
                     "--standalone"});
  usleep(500'000);
  second.signal(SIGTERM);
  EXPECT_EQ(second.exit_code(), 0) << "it still waited";
}

TEST_F(RigdStore, WhatWasTakenAgainIsMarkedOnDiskTooAndOutlivesTheDaemon) {
  start({"--inject", "late-blank:60:3"});
  const uint64_t burst = run_burst();
  rigd->signal(SIGKILL);
  start();
  const auto offers = host->offers(burst);
  size_t marked = 0, replaced = 0;
  for (const auto& offer : offers) {
    replaced += offer.frame.has_replaced_by;
    marked += offer.marked;
    if (offer.marked) {
      EXPECT_TRUE(offer.frame.has_replaced_by);
    }
  }
  EXPECT_EQ(marked, 2u);  // both cameras saw the late light
  EXPECT_EQ(offers.size(), 40 + replaced);
}

TEST_F(RigdStore, TimingAndCalibrationOfAnOlderBurstAreItsOwn) {
  const uint64_t first = run_burst();
  lamella_v1_Request request = request_of(lamella_v1_Request_timing_tag);
  request.body.timing = {first, 70};
  const lamella_v1_TimingEdges before = host->ask(request).body.timing;
  const std::string another = calibration_text(160, 120, "another");
  std::ofstream(folder.path() / "calibration.json") << another;
  start();
  run_burst();
  const lamella_v1_TimingEdges after = host->ask(request).body.timing;
  EXPECT_EQ(after.first_edge, 70u);
  ASSERT_EQ(after.edges_count, before.edges_count);
  EXPECT_EQ(after.edges[0].actual_us, before.edges[0].actual_us);
  const auto text = [&](uint64_t burst_id) {
    const auto bytes = host->fetch({lamella_v1_BlobQuery_Kind_CALIBRATION, burst_id, 0, 0});
    return std::string(bytes.begin(), bytes.end());
  };
  EXPECT_EQ(text(first), calibration_text());
  EXPECT_EQ(text(0), another);
}

TEST_F(RigdStore, AnAcknowledgementIsAnsweredAgainWhereItsAnswerWasLost) {
  const auto offers = host->offers(run_burst());
  take_away(offers[3]);
  start();
  take_away(offers[4]);
  lamella_v1_Request ack = request_of(lamella_v1_Request_ack_tag);
  ack.body.ack = {offers[3].burst_id, offers[3].frame_id};
  EXPECT_EQ(host->ask(ack).which_body, lamella_v1_Reply_acknowledged_tag);
  ack.body.ack.frame_id = 60;
  EXPECT_EQ(host->ask(ack).body.refusal.code, lamella_v1_Refusal_Code_NOT_FOUND);
  EXPECT_EQ(held()[0].frames_held, 38u);
}

TEST_F(RigdStore, StatusTellsTheNewestBurstEvenWhereOnlyAnOlderOneIsHeld) {
  run_burst();
  const uint64_t second = run_burst();
  for (const auto& offer : host->offers(second)) take_away(offer);
  start();
  const lamella_v1_Status status = host->ask(request_of(lamella_v1_Request_status_tag)).body.status;
  EXPECT_EQ(status.burst_id, second);
  EXPECT_EQ(status.frames_held, 0u);
  EXPECT_EQ(status.bursts_held, 1u);
}

TEST_F(RigdStore, ADaemonKilledInTheMiddleLeavesAPlainlyPartialBurstThatItExplains) {
  host->send(request_of(lamella_v1_Request_burst_tag));
  lamella_v1_Reply reply = lamella_v1_Reply_init_zero;
  uint32_t told = 0;
  while (told < 5 && host->receive(&reply)) {
    if (reply.which_body == lamella_v1_Reply_status_tag) told = reply.body.status.frames_held;
    if (reply.which_body == lamella_v1_Reply_done_tag) break;
  }
  rigd->signal(SIGKILL);
  start();
  const auto bursts = held();
  ASSERT_EQ(bursts.size(), 1u);
  EXPECT_GE(bursts[0].frames_held, told);
  EXPECT_EQ(bursts[0].whole, bursts[0].why[0] == '\0');
  for (const auto& offer : host->offers(bursts[0].burst_id)) take_away(offer);
  EXPECT_TRUE(held().empty());
}
