// lamella-rigd as it is run: a process, a socket, a twin.
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "fake_twin.h"
#include "rigd_bench.h"
#include "test_host.h"

extern "C" {
#include "crc32c.h"
}

namespace {

lamella_v1_BlobQuery blob_of(const lamella_v1_FrameOffer& offer, uint32_t offset) {
  return {lamella_v1_BlobQuery_Kind_PHOTOGRAPH, offer.burst_id, offer.frame_id, offset};
}

}  // namespace

TEST_F(Rigd, TakesABurstAndHandsOverEveryPhotograph) {
  RigProcess rigd(arguments());
  TestHost host(rigd.port());
  host.ask(hello());
  const uint64_t burst_id = host.run_burst();
  const auto offers = host.offers(burst_id);
  ASSERT_EQ(offers.size(), 40u);
  for (const lamella_v1_FrameOffer& offer : offers) {
    const std::vector<uint8_t> bytes = host.fetch(blob_of(offer, 0));
    ASSERT_EQ(bytes.size(), offer.size_bytes);
    EXPECT_EQ(crc32c_extend(0, bytes.data(), bytes.size()), offer.crc32c);
    lamella_v1_Request ack = request_of(lamella_v1_Request_ack_tag);
    ack.body.ack = {burst_id, offer.frame_id};
    EXPECT_EQ(host.ask(ack).which_body, lamella_v1_Reply_acknowledged_tag);
  }
  EXPECT_TRUE(host.offers(burst_id).empty());
  rigd.signal(SIGTERM);
  EXPECT_EQ(rigd.exit_code(), 0);
}

TEST_F(Rigd, TransferGoesOnWhereItBrokeOnANewConnection) {
  RigProcess rigd(arguments());
  const int port = rigd.port();
  auto first = std::make_unique<TestHost>(port);
  first->ask(hello());
  const uint64_t burst_id = first->run_burst();
  const lamella_v1_FrameOffer offer = first->offers(burst_id)[6];
  lamella_v1_Request request = request_of(lamella_v1_Request_blob_tag);
  request.body.blob = blob_of(offer, 0);
  const lamella_v1_Reply chunk = first->ask(request);  // one chunk, then the cable is pulled
  first.reset();

  TestHost second(port);
  second.ask(hello());
  EXPECT_EQ(second.offers(burst_id).size(), 40u);
  const auto& data = chunk.body.chunk.data;
  std::vector<uint8_t> bytes(data.bytes, data.bytes + data.size);
  const std::vector<uint8_t> rest = second.fetch(blob_of(offer, data.size));
  bytes.insert(bytes.end(), rest.begin(), rest.end());
  EXPECT_EQ(crc32c_extend(0, bytes.data(), bytes.size()), offer.crc32c);
}

TEST_F(Rigd, BurstSurvivesTheLossOfItsHost) {
  RigProcess rigd(arguments({"--clock", "real"}));
  const int port = rigd.port();
  auto first = std::make_unique<TestHost>(port);
  first->ask(hello());
  const lamella_v1_Reply accepted = first->ask(request_of(lamella_v1_Request_burst_tag));
  first.reset();
  TestHost second(port);
  second.ask(hello());
  lamella_v1_Status status;
  do {
    status = second.ask(request_of(lamella_v1_Request_status_tag)).body.status;
  } while (status.state == lamella_v1_RigState_ARMED ||
           status.state == lamella_v1_RigState_RUNNING);
  EXPECT_EQ(status.burst_id, accepted.body.accepted.burst_id);
  if (status.state == lamella_v1_RigState_IDLE) {
    EXPECT_GE(status.frames_held, 40u);  // and what such a machine made be retaken
  } else {                               // a machine too busy for the real clock says so
    EXPECT_STRNE(status.fault, "");
  }
}

TEST_F(Rigd, ABurstThatIsTiedToItsHostEndsWithIt) {
  RigProcess rigd(arguments({"--clock", "real"}));
  const int port = rigd.port();
  auto first = std::make_unique<TestHost>(port);
  first->ask(hello());
  lamella_v1_Request tied = request_of(lamella_v1_Request_burst_tag);
  tied.body.burst.ends_with_host = true;
  first->ask(tied);
  first.reset();
  TestHost second(port);
  second.ask(hello());
  lamella_v1_Status status;
  do {
    status = second.ask(request_of(lamella_v1_Request_status_tag)).body.status;
  } while (status.state == lamella_v1_RigState_ARMED ||
           status.state == lamella_v1_RigState_RUNNING);
  EXPECT_EQ(status.state, lamella_v1_RigState_FAULT);
}

TEST_F(Rigd, TimingListsEveryEdgeWithItsActualTime) {
  RigProcess rigd(arguments());
  TestHost host(rigd.port());
  host.ask(hello());
  lamella_v1_Request request = request_of(lamella_v1_Request_timing_tag);
  request.body.timing.burst_id = host.run_burst();
  uint32_t total = 1;
  double last_us = 0;
  while (request.body.timing.first_edge < total) {
    const lamella_v1_TimingEdges timing = host.ask(request).body.timing;
    ASSERT_GT(timing.edges_count, 0);
    total = timing.total_edges;
    for (int i = 0; i < timing.edges_count; i++) {
      EXPECT_GE(timing.edges[i].planned_us, last_us);
      EXPECT_NEAR(timing.edges[i].actual_us, timing.edges[i].planned_us, 1);
      last_us = timing.edges[i].planned_us;
    }
    request.body.timing.first_edge += timing.edges_count;
  }
  EXPECT_GT(total, 100u);
}

TEST_F(Rigd, MessageOfAnImpossibleLengthEndsTheConnection) {
  RigProcess rigd(arguments());
  const int port = rigd.port();
  for (const std::vector<uint8_t>& prefix :
       {std::vector<uint8_t>{0, 0, 0, 0}, {1, 0, 1, 0}, {0xFF, 0xFF, 0xFF, 0xFF}}) {
    TestHost host(port);
    host.ask(hello());
    host.send_bytes(prefix);
    lamella_v1_Reply reply;
    ASSERT_TRUE(host.receive(&reply));
    EXPECT_EQ(reply.body.refusal.code, lamella_v1_Refusal_Code_BAD_REQUEST);
    EXPECT_FALSE(host.receive(&reply));
  }
  TestHost after(port);
  EXPECT_EQ(after.ask(hello()).which_body, lamella_v1_Reply_welcome_tag);
}

TEST_F(Rigd, MessageInSingleBytesIsUnderstood) {
  RigProcess rigd(arguments());
  TestHost host(rigd.port());
  lamella_v1_Request request = hello();
  request.request_id = 1;
  std::vector<uint8_t> message = encoded(request);
  message.insert(message.begin(), {static_cast<uint8_t>(message.size()), 0, 0, 0});
  for (const uint8_t byte : message) host.send_bytes({byte});
  lamella_v1_Reply reply;
  ASSERT_TRUE(host.receive(&reply));
  EXPECT_EQ(reply.which_body, lamella_v1_Reply_welcome_tag);
}

TEST_F(Rigd, SecondHostIsTurnedAway) {
  RigProcess rigd(arguments());
  const int port = rigd.port();
  TestHost first(port);
  first.ask(hello());
  TestHost second(port);
  second.send(hello());
  lamella_v1_Reply reply;
  ASSERT_TRUE(second.receive(&reply));
  EXPECT_EQ(reply.body.refusal.code, lamella_v1_Refusal_Code_WRONG_STATE);
  EXPECT_FALSE(second.receive(&reply));
  EXPECT_EQ(first.ask(request_of(lamella_v1_Request_status_tag)).which_body,
            lamella_v1_Reply_status_tag);
}

TEST_F(Rigd, SilentConnectionsKeepNobodyOut) {
  RigProcess rigd(arguments());
  const int port = rigd.port();
  const TestHost silent(port), silent_too(port);
  TestHost stutters(port);  // begins a message and leaves it at that
  stutters.send_bytes({40});
  usleep(300000);  // and has the rig by then
  TestHost host(port);
  EXPECT_EQ(host.ask(hello()).which_body, lamella_v1_Reply_welcome_tag);
  lamella_v1_Reply reply;
  ASSERT_TRUE(stutters.receive(&reply));
  EXPECT_STREQ(reply.body.refusal.reason, "a host says hello within 2 s");
  EXPECT_FALSE(stutters.receive(&reply));
}

TEST_F(Rigd, InjectedFaultsReachThePictures) {
  RigProcess rigd(arguments({"--inject", "late-blank:6000"}));
  TestHost host(rigd.port());
  host.ask(hello());
  const lamella_v1_FrameOffer offer = host.offers(host.run_burst())[0];
  EXPECT_TRUE(offer.marked);
  const std::vector<uint8_t> bytes = host.fetch(blob_of(offer, 0));
  EXPECT_NEAR(unpack_first_row(bytes.data())[0], 0.75 * 24 / 30, 0.001);
}

TEST_F(Rigd, AHangUpThatWasIgnoredBeforeStaysIgnoredAsUnderNohup) {
  const auto before = signal(SIGHUP, SIG_IGN);
  RigProcess rigd(arguments());
  signal(SIGHUP, before);
  const int port = rigd.port();
  rigd.signal(SIGHUP);
  EXPECT_EQ(TestHost(port).ask(hello()).which_body, lamella_v1_Reply_welcome_tag);
  rigd.signal(SIGTERM);
  EXPECT_EQ(rigd.exit_code(), 0);
}

TEST_F(Rigd, SignalsStopItWithLightsOffEvenInTheMiddleOfABurst) {
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) {
    FakeTwin own;
    const auto before = signal(number, SIG_DFL);  // under nohup it would be ignored
    RigProcess rigd(arguments({"--clock", "real", "--twin", own.path()}));
    signal(number, before);
    TestHost host(rigd.port());
    host.ask(hello());
    host.ask(request_of(lamella_v1_Request_burst_tag));
    rigd.signal(number);
    EXPECT_EQ(rigd.exit_code(), 0);
  }
}

TEST_F(Rigd, ASignalStopsItThoughAHostNeverStopsAsking) {
  RigProcess rigd(arguments());
  TestHost host(rigd.port());
  host.ask(hello());
  std::atomic<bool> ended{false};
  std::thread asks([&] {
    while (!ended) host.send(request_of(lamella_v1_Request_status_tag));
  });
  std::thread hears([&] {
    for (lamella_v1_Reply reply; host.receive(&reply);) continue;
  });
  usleep(300000);
  rigd.signal(SIGTERM);
  EXPECT_EQ(rigd.exit_code(), 0);
  ended = true;
  asks.join();
  hears.join();
}

namespace {

lamella_v1_SelftestResult tested(TestHost* host, const std::vector<std::string>& only) {
  lamella_v1_Request request = request_of(lamella_v1_Request_selftest_tag);
  for (const std::string& part : only) {
    strcpy(request.body.selftest.only[request.body.selftest.only_count++], part.c_str());
  }
  lamella_v1_SelftestResult result = host->ask(request).body.selftest;
  while (result.running) {
    request.body.selftest = lamella_v1_SelftestRequest_init_zero;
    request.body.selftest.report = true;
    result = host->ask(request).body.selftest;
  }
  return result;
}

}  // namespace

TEST_F(Rigd, TestsItselfWhenAHostAsks) {
  RigProcess rigd(arguments({"--inject", "dead-led:17", "--inject", "stuck-actuator"}));
  TestHost host(rigd.port());
  host.ask(hello());
  const lamella_v1_SelftestResult leds = tested(&host, {"leds"});
  EXPECT_EQ(leds.bad, 1u);
  EXPECT_STREQ(leds.readings[0].what, "LED 17 (chip 3 output 2)");
  EXPECT_EQ(leds.readings[0].verdict, lamella_v1_SelftestReading_Verdict_BAD);
  const lamella_v1_SelftestResult all = tested(&host, {});
  EXPECT_EQ(all.bad, 2u);
  lamella_v1_Request wrong = request_of(lamella_v1_Request_selftest_tag);
  wrong.body.selftest.only_count = 1;
  strcpy(wrong.body.selftest.only[0], "engine");
  EXPECT_EQ(host.ask(wrong).body.refusal.code, lamella_v1_Refusal_Code_BAD_REQUEST);
}

TEST_F(Rigd, StatusNamesThePartsThatWereFoundBad) {
  RigProcess rigd(arguments({"--inject", "estop", "--inject", "dead-monostable"}));
  TestHost host(rigd.port());
  host.ask(hello());
  EXPECT_EQ(tested(&host, {"temperature"}).bad, 0u);  // says nothing of others
  const lamella_v1_Status status = host.ask(request_of(lamella_v1_Request_status_tag)).body.status;
  EXPECT_EQ(status.state, lamella_v1_RigState_IDLE);
  ASSERT_EQ(status.unfit_count, 2u);
  EXPECT_STREQ(status.unfit[0],
               "estop: pressed: release the emergency stop; a broken wire reads the same");
  EXPECT_STREQ(status.unfit[1],
               "blank: dark after the last heartbeat: it stays lit when the heart stops: the "
               "monostable, its gate, their wires");
}

TEST_F(Rigd, StatusOfAGoodRigNamesNoPart) {
  RigProcess rigd(arguments());
  TestHost host(rigd.port());
  host.ask(hello());
  EXPECT_EQ(host.ask(request_of(lamella_v1_Request_status_tag)).body.status.unfit_count, 0u);
}

TEST_F(Rigd, AFailedSelfTestAtItsStartIsSaidAndAHostMayStillAsk) {
  RigProcess rigd(arguments({"--inject", "flip-bit:5"}));
  TestHost host(rigd.port());
  host.ask(hello());
  EXPECT_EQ(host.offers(host.run_burst()).size(), 40u);
  rigd.signal(SIGTERM);
  EXPECT_EQ(rigd.exit_code(), 0);
  EXPECT_NE(rigd.errors().find("self-test: chain: wrong bits"), std::string::npos);
}

TEST_F(Rigd, ButtonToSessionOnDiskWithNoHost) {
  const std::filesystem::path store = folder / "store";
  std::filesystem::create_directory(store);
  RigProcess rigd(arguments(
      {"--store", store, "--standalone", "--inject", "press:1e6:1e5", "--clock", "virtual"}));
  const int port = rigd.port();
  ASSERT_GT(port, 0);
  lamella_v1_Status status = lamella_v1_Status_init_zero;
  for (int i = 0; i < 600 && status.frames_held < 40; i++) {
    usleep(50000);
    TestHost host(port);  // looks in and goes away again: it does not have the rig by that
    host.ask(hello());
    status = host.ask(request_of(lamella_v1_Request_status_tag)).body.status;
  }
  EXPECT_EQ(status.frames_held, 40u);
  rigd.signal(SIGTERM);
  EXPECT_EQ(rigd.exit_code(), 0);
}

// What the service manager would hear, on a socket of our own.
TEST_F(Rigd, TellsTheServiceManagerThatItIsReadyAndAlive) {
  const std::string path = folder / "notify";
  const int socket_fd = socket(AF_UNIX, SOCK_DGRAM, 0);
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  strcpy(address.sun_path, path.c_str());
  ASSERT_EQ(bind(socket_fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  const timeval patience = {10, 0};
  setsockopt(socket_fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setenv("NOTIFY_SOCKET", path.c_str(), 1);
  setenv("WATCHDOG_USEC", "400000", 1);
  std::string heard;
  int alive = 0;
  {
    RigProcess rigd(arguments({"--clock", "real"}));
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    ASSERT_GT(rigd.port(), 0);
    char text[512];
    while (alive < 8) {
      const ssize_t size = recv(socket_fd, text, sizeof text, 0);
      ASSERT_GT(size, 0) << "it fell silent after " << heard;
      const std::string message(text, static_cast<size_t>(size));
      heard += message + "|";
      if (message == "WATCHDOG=1") alive++;
    }
    // A loop that hangs feeds nothing: what comes is no more than what was on its way.
    rigd.signal(SIGSTOP);
    usleep(200000);
    while (recv(socket_fd, text, sizeof text, MSG_DONTWAIT) > 0) continue;
    usleep(600000);
    EXPECT_LT(recv(socket_fd, text, sizeof text, MSG_DONTWAIT), 0);
    rigd.signal(SIGCONT);
    rigd.signal(SIGTERM);
    EXPECT_EQ(rigd.exit_code(), 0);
    while (recv(socket_fd, text, sizeof text, MSG_DONTWAIT) > 0) heard += text;
  }
  close(socket_fd);
  const size_t ready = heard.find("READY=1\nSTATUS=ready");
  EXPECT_NE(ready, std::string::npos) << heard;
  // Its self-test was given time: to start, and for a piece of it that is longer than WatchdogSec.
  const size_t extended = heard.find("EXTEND_TIMEOUT_USEC=60000000");
  const size_t longer = heard.find("WATCHDOG_USEC=60000000");
  const size_t usual = heard.find("WATCHDOG_USEC=400000|");
  EXPECT_LT(extended, ready) << heard;
  EXPECT_LT(longer, usual) << heard;
  EXPECT_LT(usual, ready) << heard;
  EXPECT_EQ(heard.find("EXTEND_TIMEOUT_USEC", ready), std::string::npos) << heard;
  EXPECT_NE(heard.find("STOPPING=1"), std::string::npos) << heard;
}
