// lamella-rigd as it is run: a process, a socket, a twin.
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "fake_twin.h"
#include "test_host.h"
#include "test_rig.h"

extern "C" {
#include "crc32c.h"
}

namespace {

class Rigd : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/lamella-rigd-test-XXXXXX";
    folder = mkdtemp(name);
    std::ofstream(folder / "calibration.json") << R"({"format": "lamella.session.v1"})";
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::vector<std::string> arguments(std::vector<std::string> more = {}) {
    std::vector<std::string> all = {
        "--hal",    "sim",        "--rig",         LAMELLA_BOARD_DIR "/sim.rig",
        "--twin",   twin.path(),  "--calibration", folder / "calibration.json",
        "--listen", "127.0.0.1:0"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  void expect_failure(const std::vector<std::string>& more, int code, const std::string& says) {
    RigProcess rigd(arguments(more));
    EXPECT_EQ(rigd.exit_code(), code);
    const std::string errors = rigd.errors();
    EXPECT_NE(errors.find(says), std::string::npos) << errors;
  }

  lamella_v1_BlobQuery photograph(const lamella_v1_FrameOffer& offer, uint32_t offset) {
    return {lamella_v1_BlobQuery_Kind_PHOTOGRAPH, offer.burst_id, offer.frame_id, offset};
  }

  std::filesystem::path folder;
  FakeTwin twin{300};  // photographs of some 200 kB: several chunks each
};

}  // namespace

TEST_F(Rigd, TakesABurstAndHandsOverEveryPhotograph) {
  RigProcess rigd(arguments());
  TestHost host(rigd.port());
  host.ask(hello());
  const uint64_t burst_id = host.run_burst();
  const auto offers = host.offers(burst_id);
  ASSERT_EQ(offers.size(), 40u);
  for (const lamella_v1_FrameOffer& offer : offers) {
    const std::vector<uint8_t> bytes = host.fetch(photograph(offer, 0));
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
  request.body.blob = photograph(offer, 0);
  const lamella_v1_Reply chunk = first->ask(request);  // one chunk, then the cable is pulled
  first.reset();

  TestHost second(port);
  second.ask(hello());
  EXPECT_EQ(second.offers(burst_id).size(), 40u);
  const auto& data = chunk.body.chunk.data;
  std::vector<uint8_t> bytes(data.bytes, data.bytes + data.size);
  const std::vector<uint8_t> rest = second.fetch(photograph(offer, data.size));
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
  const std::vector<uint8_t> bytes = host.fetch(photograph(offer, 0));
  EXPECT_NEAR(unpack_first_row(bytes.data())[0], 0.75 * 24 / 30, 0.001);
}

TEST_F(Rigd, SignalsStopItWithLightsOffEvenInTheMiddleOfABurst) {
  for (const int number : {SIGTERM, SIGINT}) {
    FakeTwin own;
    auto all = arguments({"--clock", "real"});
    all[5] = own.path();
    RigProcess rigd(all);
    TestHost host(rigd.port());
    host.ask(hello());
    host.ask(request_of(lamella_v1_Request_burst_tag));
    rigd.signal(number);
    EXPECT_EQ(rigd.exit_code(), 0);
  }
}

TEST_F(Rigd, RefusesToListenBeyondLoopback) {
  for (const std::string address : {"0.0.0.0:0", "192.168.1.2:7000", "8.8.8.8:1"}) {
    expect_failure({"--listen", address}, 2, "only loopback");
  }
  expect_failure({"--listen", "127.0.0.1"}, 2, "127.0.0.1: no port: give ADDRESS:PORT");
  for (const std::string port : {"99999", "-1", "", "7x", "+7", " 7", "65536"}) {
    expect_failure({"--listen", "127.0.0.1:" + port}, 2, "a port is a number from 0 to 65535");
  }
  for (const std::string address : {"localhost:1", "::1:0", ":1"}) {
    expect_failure({"--listen", address}, 2, "not an IPv4 address");
  }
}

TEST_F(Rigd, BadInputIsOneLineAndExitCodeTwo) {
  expect_failure({"--rig", "/nowhere.rig"}, 2, "/nowhere.rig: cannot be read");
  expect_failure({"--calibration", "/nowhere.json"}, 2, "/nowhere.json: cannot be read");
  expect_failure({"--hal", "linux"}, 2, "the rig file has no linux. keys");
  expect_failure({"--hal", "arduino"}, 2, "there are sim and linux");
  expect_failure({"--clock", "sundial"}, 2, "--clock sundial: there are virtual and real; see");
  expect_failure({"--inject", "flip-bit:9999"}, 2, "--inject flip-bit:9999: no such fault");
  expect_failure({"--inject"}, 2, "--inject: needs a value");
  expect_failure({"--brightness", "7"}, 2, "--brightness: no such option; see lamella-rigd --help");
  expect_failure({"bright"}, 2, "bright: is no option");
  const std::string wrong = folder / "wrong.rig";
  std::ofstream(wrong) << "# a rig\nleds.spi_hz = 99e6\n";
  expect_failure({"--rig", wrong}, 2, wrong + ":2: 'leds.spi_hz' is 99000000");
}

TEST_F(Rigd, HelpFitsOnAScreenAndNamesEveryFaultAndVersionIsOneLine) {
  for (const auto& arguments : {std::vector<std::string>{"--help"}, {"--hal", "sim", "--help"}}) {
    RigProcess rigd(arguments);
    std::istringstream help(rigd.output());
    EXPECT_EQ(rigd.exit_code(), 0);
    size_t lines = 0;
    for (std::string line; std::getline(help, line); lines++) EXPECT_LE(line.size(), 80u) << line;
    EXPECT_LE(lines, 24u);
    EXPECT_NE(help.str().find("swapped-leds:N:M"), std::string::npos);
    EXPECT_EQ(rigd.errors(), "");
  }
  RigProcess rigd({"--version"});
  EXPECT_EQ(rigd.output().find("lamella-rigd 0."), 0u);
  EXPECT_EQ(rigd.exit_code(), 0);
}

TEST_F(Rigd, WhatIsMissingOfARealRigIsToldBeforeAnyHardwareIsTouched) {
  const std::string rig = LAMELLA_BOARD_DIR "/vm.rig";  // its devices are not here
  expect_failure({"--hal", "linux", "--rig", rig, "--calibration", "/nowhere.json"}, 2,
                 "--calibration /nowhere.json: cannot be read");
  expect_failure({"--hal", "linux", "--rig", rig}, 3, "no --state: whoever can log in here");
  const std::string far = folder / "far.rig";
  std::filesystem::copy(LAMELLA_BOARD_DIR "/dome150.leds", folder / "dome150.leds");
  std::string text = board_text("vm.rig");
  const std::string cpu = "linux.cpu                = 0";
  std::ofstream(far) << text.replace(text.find(cpu), cpu.size(), "linux.cpu = 63");
  expect_failure({"--hal", "linux", "--rig", far}, 2, "linux.cpu is 63: this computer has");
}

TEST_F(Rigd, WaitsForNoPipeInPlaceOfAFile) {
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  expect_failure({"--check", "--rig", pipe}, 2, pipe + ": cannot be read: not a plain file");
  expect_failure({"--calibration", pipe}, 2, pipe + ": cannot be read: not a plain file");
  expect_failure({"--led-reference", pipe}, 2, pipe + ": cannot be read: not a plain file");
}

TEST_F(Rigd, CheckNamesEveryWrongKeyOfBothFilesWithItsLine) {
  const std::string wrong = folder / "wrong.rig", leds = folder / "few.leds";
  std::ofstream(wrong) << "leds.spi_mhz = 10\nleds.file = few.leds\ncamera.iso = fast\n";
  std::ofstream(leds) << "led.count = 3\nled.0 = 0 0 0 1 0\nled.1 = 9 0 0 1 0\nled.3 = 1 0 0 1 0\n";
  RigProcess rigd({"--check", "--rig", wrong});
  EXPECT_EQ(rigd.exit_code(), 2);
  const std::string errors = rigd.errors();
  for (const std::string& line :
       {wrong + ":1: unknown key 'leds.spi_mhz'; is 'leds.spi_hz' meant?\n",
        wrong + ":3: 'camera.iso' needs one number, not 'fast'\n",
        wrong + ": missing key 'light.least_share'\n", leds + ":3: 'led.1' is at chip 9",
        leds + ":4: 'led.3' stands where 'led.2' is due"}) {
    EXPECT_NE(errors.find(line), std::string::npos) << line << "\n" << errors;
  }
}

TEST_F(Rigd, LedsAreLookedForBesideTheRigFileAlone) {
  const std::string rig = folder / "some.rig";
  std::ofstream(rig) << "leds.file = none.leds\n";
  expect_failure({"--rig", rig}, 2, (folder / "none.leds").string() + ": cannot be read");
  std::ofstream(rig) << "leds.file = ../none.leds\n";
  expect_failure({"--rig", rig}, 2, "'leds.file' is a file beside this one");
}

TEST_F(Rigd, MissingTwinIsExitCodeThree) {
  expect_failure({"--twin", "/nowhere/socket"}, 3, "no twin answers");
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
