// The answers of the rig, without sockets: what is refused, and that nothing moves then.
#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "test_host.h"
#include "test_rig.h"

extern "C" {
#include "crc32c.h"
#include "hal_sim.h"
#include "link_answer.h"
#include "store.h"
}

namespace {

class Link : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, kSimNoFaults, nullptr), LAM_OK);
    store_init(&photographs, block.data(), block.size());
    session_init(&session, &rig, &sim.hal, &photographs);
    calibration.resize(100000);
    for (size_t i = 0; i < calibration.size(); i++) calibration[i] = static_cast<uint8_t>(i * 31);
    dialogue.session = &session;
    dialogue.calibration = calibration.data();
    dialogue.calibration_size = calibration.size();
    dialogue.context = this;
    dialogue.send = [](void* self, const lamella_v1_Reply* reply) {
      static_cast<Link*>(self)->replies.push_back(*reply);
      return true;
    };
  }

  void TearDown() override {
    session_close(&session);
    sim.hal.close(&sim);
  }

  bool answer(const std::vector<uint8_t>& message) {
    replies.clear();
    return link_answer(&dialogue, message.data(), message.size());
  }

  bool answer(lamella_v1_Request request) {
    if (request.request_id == 0) request.request_id = 7;
    return answer(encoded(request));
  }

  void greet() { ASSERT_TRUE(answer(hello())); }

  void expect_refusal(lamella_v1_Refusal_Code code, const std::string& says) {
    ASSERT_EQ(replies.size(), 1u);
    ASSERT_EQ(replies[0].which_body, lamella_v1_Reply_refusal_tag);
    EXPECT_EQ(replies[0].body.refusal.code, code);
    EXPECT_NE(std::string(replies[0].body.refusal.reason).find(says), std::string::npos)
        << replies[0].body.refusal.reason;
  }

  // A finished burst with one photograph of `size` bytes.
  void hold_photograph(size_t size) {
    size_t room = 0;
    uint8_t* bytes = store_room(&photographs, &room);
    for (size_t i = 0; i < size; i++) bytes[i] = static_cast<uint8_t>(i * 7);
    struct photograph photograph = {};
    photograph.frame_id = 3;
    photograph.size = size;
    ASSERT_TRUE(store_keep(&photographs, &photograph));
    session.burst_id = session.done.burst_id = 5;
  }

  lamella_v1_Request blob(uint32_t offset, uint32_t frame_id = 3) {
    lamella_v1_Request request = request_of(lamella_v1_Request_blob_tag);
    request.body.blob = {lamella_v1_BlobQuery_Kind_PHOTOGRAPH, 5, frame_id, offset};
    return request;
  }

  struct rig rig = test_rig();
  struct hal_sim sim;
  struct store photographs;
  struct session session;
  struct dialogue dialogue = {};
  std::vector<uint8_t> block = std::vector<uint8_t>(1 << 20);
  std::vector<uint8_t> calibration;
  std::vector<lamella_v1_Reply> replies;
};

}  // namespace

TEST_F(Link, WelcomesAHostOfTheSameVersion) {
  greet();
  ASSERT_EQ(replies.size(), 1u);
  const lamella_v1_Welcome& welcome = replies[0].body.welcome;
  EXPECT_EQ(welcome.protocol_version, 1u);
  EXPECT_EQ(welcome.led_count, 150u);
  EXPECT_STREQ(welcome.hal, "sim");
}

TEST_F(Link, SaysWhatTheProjectorShowsSoThatAHostCanHoldTheCalibrationAgainstIt) {
  rig.pattern_stripe_shift_px = 1.5;
  greet();
  const lamella_v1_Welcome& welcome = replies[0].body.welcome;
  EXPECT_EQ(welcome.projector_width, 1280u);
  EXPECT_EQ(welcome.projector_height, 800u);
  ASSERT_TRUE(welcome.has_patterns);
  ASSERT_EQ(welcome.patterns.fringe.periods_count, 4u);
  EXPECT_EQ(welcome.patterns.fringe.periods[3], 64);
  EXPECT_EQ(welcome.patterns.stripes.period_px, 8);
  EXPECT_EQ(welcome.patterns.stripes.shift_px, 1.5);
  EXPECT_EQ(welcome.patterns.dots.diameter_px, 20);
  EXPECT_EQ(welcome.patterns.dots.offset_px[1], 400);
}

TEST_F(Link, RefusesAnotherVersionAndCloses) {
  lamella_v1_Request request = hello();
  request.body.hello.protocol_version = 2;
  EXPECT_FALSE(answer(request));
  expect_refusal(lamella_v1_Refusal_Code_VERSION, "version 1");
}

TEST_F(Link, AnswersNothingBeforeHello) {
  EXPECT_TRUE(answer(request_of(lamella_v1_Request_burst_tag)));
  expect_refusal(lamella_v1_Refusal_Code_BAD_REQUEST, "hello first");
  EXPECT_EQ(session.state, lamella_v1_RigState_IDLE);
}

TEST_F(Link, RefusesBytesThatAreNoRequest) {
  greet();
  EXPECT_TRUE(answer(std::vector<uint8_t>{0xFF, 0xFF, 0xFF, 0xFF}));
  expect_refusal(lamella_v1_Refusal_Code_BAD_REQUEST, "not a request");
}

TEST_F(Link, RefusesAStringLongerThanItsBound) {
  // Request {hello {host_name: 200 characters}}, by hand: nanopb would not encode it.
  std::vector<uint8_t> message = {0x08, 0x01, 0x12, 0xCB, 0x01, 0x12, 0xC8, 0x01};
  message.resize(message.size() + 200, 'x');
  EXPECT_TRUE(answer(message));
  expect_refusal(lamella_v1_Refusal_Code_BAD_REQUEST, "too long");
}

TEST_F(Link, RefusesRequestIdZero) {
  lamella_v1_Request request = hello();
  EXPECT_TRUE(answer(encoded(request)));
  expect_refusal(lamella_v1_Refusal_Code_BAD_REQUEST, "request_id 0");
}

TEST_F(Link, RefusesARequestWithoutABody) {
  greet();
  EXPECT_TRUE(answer(request_of(0)));
  expect_refusal(lamella_v1_Refusal_Code_BAD_REQUEST, "does not know");
}

TEST_F(Link, SurvivesTruncationAndNoiseOfEveryRequest) {
  greet();
  std::mt19937 random(3);
  for (int tag = lamella_v1_Request_hello_tag; tag <= lamella_v1_Request_frames_tag; tag++) {
    lamella_v1_Request request = request_of(static_cast<pb_size_t>(tag));
    request.request_id = 9;
    const std::vector<uint8_t> whole = encoded(request);
    for (int round = 0; round < 200; round++) {
      std::vector<uint8_t> message = whole;
      message.resize(random() % (whole.size() + 8));
      for (uint8_t& byte : message) {
        if (random() % 4 == 0) byte = static_cast<uint8_t>(random());
      }
      answer(message);
      ASSERT_FALSE(replies.empty());
      session_abort(&session);
    }
  }
}

TEST_F(Link, PhotographIsFetchedFromAnyOffset) {
  greet();
  const size_t size = 3 * 32768 + 17;
  hold_photograph(size);
  for (const size_t offset :
       {size_t(0), size_t(1), size_t(32767), size_t(32768), size_t(40000), size - 1, size}) {
    ASSERT_TRUE(answer(blob(static_cast<uint32_t>(offset))));
    size_t at = offset;
    for (size_t i = 0; i < replies.size(); i++) {
      const lamella_v1_Chunk& chunk = replies[i].body.chunk;
      EXPECT_EQ(chunk.sequence, i);
      EXPECT_EQ(chunk.offset_bytes, at);
      EXPECT_EQ(chunk.total_bytes, size);
      EXPECT_EQ(chunk.crc32c, crc32c_extend(0, block.data() + at, chunk.data.size));
      at += chunk.data.size;
    }
    EXPECT_EQ(at, size);
    EXPECT_EQ(replies.size(), std::max<size_t>(1, (size - offset + 32639) / 32640));
  }
}

TEST_F(Link, OffsetBeyondTheEndIsRefused) {
  greet();
  hold_photograph(100);
  EXPECT_TRUE(answer(blob(101)));
  expect_refusal(lamella_v1_Refusal_Code_BAD_REQUEST, "beyond the end");
}

TEST_F(Link, UnknownPhotographBurstAndKindAreRefused) {
  greet();
  hold_photograph(100);
  answer(blob(0, 4));
  expect_refusal(lamella_v1_Refusal_Code_NOT_FOUND, "no such photograph");
  lamella_v1_Request request = blob(0);
  request.body.blob.burst_id = 6;
  answer(request);
  expect_refusal(lamella_v1_Refusal_Code_NOT_FOUND, "no such burst");
  request.body.blob.kind = lamella_v1_BlobQuery_Kind_KIND_UNSPECIFIED;
  answer(request);
  expect_refusal(lamella_v1_Refusal_Code_BAD_REQUEST, "kind");
}

TEST_F(Link, CalibrationIsServedAsItWasFound) {
  greet();
  lamella_v1_Request request = request_of(lamella_v1_Request_blob_tag);
  request.body.blob.kind = lamella_v1_BlobQuery_Kind_CALIBRATION;
  request.body.blob.offset_bytes = 50000;
  ASSERT_TRUE(answer(request));
  std::vector<uint8_t> bytes;
  for (const lamella_v1_Reply& reply : replies) {
    const auto& data = reply.body.chunk.data;
    bytes.insert(bytes.end(), data.bytes, data.bytes + data.size);
  }
  EXPECT_EQ(bytes, std::vector<uint8_t>(calibration.begin() + 50000, calibration.end()));
}

TEST_F(Link, CalibrationOfABurstIsThatBurstsOrNone) {
  greet();
  hold_photograph(100);
  lamella_v1_Request request = request_of(lamella_v1_Request_blob_tag);
  request.body.blob.kind = lamella_v1_BlobQuery_Kind_CALIBRATION;
  request.body.blob.burst_id = 5;
  answer(request);
  ASSERT_EQ(replies[0].which_body, lamella_v1_Reply_chunk_tag);
  EXPECT_EQ(replies[0].body.chunk.burst_id, 5u);
  request.body.blob.burst_id = 6;
  answer(request);
  expect_refusal(lamella_v1_Refusal_Code_NOT_FOUND, "no such burst");
}

TEST_F(Link, PhotographIsForgottenAfterItsAckAndNotBefore) {
  greet();
  hold_photograph(100);
  answer(blob(0));
  EXPECT_EQ(store_held(&photographs), 1u);
  lamella_v1_Request ack = request_of(lamella_v1_Request_ack_tag);
  ack.body.ack = {5, 3};
  answer(ack);
  ASSERT_EQ(replies[0].which_body, lamella_v1_Reply_acknowledged_tag);
  EXPECT_EQ(replies[0].body.acknowledged.frame_id, 3u);
  EXPECT_EQ(store_held(&photographs), 0u);
  answer(blob(0));
  expect_refusal(lamella_v1_Refusal_Code_NOT_FOUND, "no such photograph");
}

TEST_F(Link, AnAcknowledgementIsAnsweredAgainWhereItsAnswerWasLost) {
  greet();
  hold_photograph(100);
  lamella_v1_Request ack = request_of(lamella_v1_Request_ack_tag);
  ack.body.ack = {5, 3};
  for (int i = 0; i < 2; i++) {
    answer(ack);
    ASSERT_EQ(replies[0].which_body, lamella_v1_Reply_acknowledged_tag);
    EXPECT_EQ(replies[0].body.acknowledged.frame_id, 3u);
  }
  ack.body.ack.frame_id = 4;
  answer(ack);
  expect_refusal(lamella_v1_Refusal_Code_NOT_FOUND, "no such photograph");
}

TEST_F(Link, WhatIsAskedOfABurstThatEndedInFaultIsNotFoundAndNotUnderWay) {
  greet();
  answer(request_of(lamella_v1_Request_burst_tag));
  while (session_work(&session)) continue;  // there is no twin
  ASSERT_EQ(session.state, lamella_v1_RigState_FAULT);
  lamella_v1_Request frames = request_of(lamella_v1_Request_frames_tag);
  frames.body.frames.burst_id = session.burst_id;
  answer(frames);
  expect_refusal(lamella_v1_Refusal_Code_NOT_FOUND, "no such burst");
}

TEST_F(Link, ThePartialBurstsVerdictGivesItsWholeReason) {
  greet();
  photographs.on_disk = true;
  photographs.burst_count = 1;
  struct held_burst* burst = &photographs.bursts[0];
  burst->id = 8;
  burst->expected = 40;
  lamella_v1_BurstEnd end = lamella_v1_BurstEnd_init_zero;
  memset(end.why, 'w', 100);
  burst_explain(burst, &end);
  lamella_v1_Request frames = request_of(lamella_v1_Request_frames_tag);
  frames.body.frames.burst_id = 8;
  answer(frames);
  ASSERT_EQ(replies.back().which_body, lamella_v1_Reply_done_tag);
  EXPECT_EQ(std::string(replies.back().body.done.verdict),
            "PARTIAL: " + std::string(100, 'w') + "; 0 of 40 photographs are whole");
}

TEST_F(Link, ABurstThatFlashesNeedsTheOperatorsWordForThisSubject) {
  greet();
  lamella_v1_Request request = request_of(lamella_v1_Request_burst_tag);
  request.body.burst.flashing_confirmed = false;
  ASSERT_TRUE(answer(request));
  expect_refusal(lamella_v1_Refusal_Code_UNSAFE, "8 flashes in a second: more than 3 need");
  EXPECT_EQ(session.state, lamella_v1_RigState_IDLE);
  request.body.burst.flashing_confirmed = true;
  ASSERT_TRUE(answer(request));
  EXPECT_EQ(replies[0].which_body, lamella_v1_Reply_accepted_tag);
}

// A host could not read the list of bursts any more.
TEST_F(Link, ASubjectsNameThatIsNoUtf8IsRefused) {
  greet();
  lamella_v1_Request request = request_of(lamella_v1_Request_burst_tag);
  std::strcpy(request.body.burst.subject, "Ad\xe4");
  ASSERT_TRUE(answer(request));
  expect_refusal(lamella_v1_Refusal_Code_BAD_REQUEST, "the subject's name is not UTF-8");
  EXPECT_EQ(session.state, lamella_v1_RigState_IDLE);
  std::strcpy(request.body.burst.subject, "Ad\xc3\xa4");
  ASSERT_TRUE(answer(request));
  EXPECT_EQ(replies[0].which_body, lamella_v1_Reply_accepted_tag);
}

TEST_F(Link, WhileABurstIsPlayedOnlyHelloStatusAndAbortAreHeard) {
  greet();
  ASSERT_TRUE(answer(request_of(lamella_v1_Request_burst_tag)));
  ASSERT_EQ(replies[0].which_body, lamella_v1_Reply_accepted_tag);
  for (int i = 0; i < 20; i++) session_work(&session);
  ASSERT_EQ(session.state, lamella_v1_RigState_RUNNING);
  for (const int tag :
       {lamella_v1_Request_burst_tag, lamella_v1_Request_blob_tag, lamella_v1_Request_ack_tag,
        lamella_v1_Request_timing_tag, lamella_v1_Request_frames_tag}) {
    answer(request_of(static_cast<pb_size_t>(tag)));
    expect_refusal(lamella_v1_Refusal_Code_WRONG_STATE, "under way");
  }
  answer(request_of(lamella_v1_Request_status_tag));
  EXPECT_EQ(replies[0].body.status.state, lamella_v1_RigState_RUNNING);
  answer(request_of(lamella_v1_Request_abort_tag));
  EXPECT_EQ(replies[0].body.status.state, lamella_v1_RigState_IDLE);
}

TEST_F(Link, AbortWhileIdleIsRefused) {
  greet();
  answer(request_of(lamella_v1_Request_abort_tag));
  expect_refusal(lamella_v1_Refusal_Code_WRONG_STATE, "no burst to abort");
}

TEST_F(Link, AnAbortThatIsAskedAgainIsAnsweredAsItWasAndEndsNothingNewer) {
  greet();
  lamella_v1_Request abort = request_of(lamella_v1_Request_abort_tag);
  abort.body.abort.attempt = 77;
  ASSERT_TRUE(answer(request_of(lamella_v1_Request_burst_tag)));
  answer(abort);
  EXPECT_EQ(replies[0].body.status.state, lamella_v1_RigState_IDLE);
  greet();  // over another connection
  answer(abort);
  ASSERT_EQ(replies[0].which_body, lamella_v1_Reply_status_tag);
  EXPECT_EQ(replies[0].body.status.state, lamella_v1_RigState_IDLE);
  while (session_work(&session)) continue;
  ASSERT_TRUE(answer(request_of(lamella_v1_Request_burst_tag)));
  answer(abort);
  EXPECT_EQ(replies[0].body.status.state, lamella_v1_RigState_ARMED);
  abort.body.abort.attempt = 78;
  answer(abort);
  EXPECT_EQ(replies[0].body.status.state, lamella_v1_RigState_IDLE);
  abort.body.abort.attempt = 79;
  answer(abort);
  expect_refusal(lamella_v1_Refusal_Code_WRONG_STATE, "no burst to abort");
}

TEST_F(Link, UnsafeBurstIsRefusedWithTheRuleItBreaks) {
  greet();
  rig.leds_highest_duty = 0.05;
  answer(request_of(lamella_v1_Request_burst_tag));
  expect_refusal(lamella_v1_Refusal_Code_UNSAFE, "leds.highest_duty");
}

TEST_F(Link, FaultIsTold) {
  greet();
  answer(request_of(lamella_v1_Request_burst_tag));
  while (session_work(&session)) continue;  // there is no twin
  replies.clear();
  EXPECT_TRUE(link_tell_news(&dialogue));
  ASSERT_EQ(replies.size(), 1u);
  EXPECT_EQ(replies[0].request_id, 0u);
  EXPECT_EQ(replies[0].body.status.state, lamella_v1_RigState_FAULT);
  EXPECT_NE(std::string(replies[0].body.status.fault).find("no twin"), std::string::npos);
}
