#include "io/link_client.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "io/fake_rig.h"

namespace lamella {
namespace {

using testing::fake_photograph;
using testing::FakeRig;
using testing::FakeRigFaults;

const cv::Size kPhotograph(40, 30);  // 5400 bytes

LinkOptions quick() {
  LinkOptions options;
  options.connect_s = 1;
  options.reply_s = 1;
  options.burst_margin_s = 2;
  options.backoff_s = 0.002;
  return options;
}

void load(FakeRig* rig, int photographs) {
  rig->set_calibration(std::string(3500, 'c'));
  for (int i = 0; i < photographs; ++i) rig->add(fake_photograph(uint32_t(i), kPhotograph));
}

// What a LinkClient says when `act` fails: its one line. It must be the rig's fault.
template <class Act>
std::string failure(const Act& act) {
  try {
    act();
  } catch (const Error& e) {
    EXPECT_EQ(e.fault(), Fault::kRig);
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
    return e.what();
  }
  return "nothing failed";
}

::testing::AssertionResult says(const std::string& line, const std::string& part) {
  if (line.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "\"" << line << "\" lacks \"" << part << "\"";
}

// A rig with such faults whose burst is taken and listed, not yet fetched.
struct OfferedBurst {
  FakeRig rig;
  LinkClient client;
  std::vector<v1::FrameOffer> offers;

  OfferedBurst(const FakeRigFaults& faults, int photographs)
      : rig(faults), client(loaded(&rig, photographs), quick()) {
    offers = client.offers(client.run_burst("sphere"));
  }

  static std::string loaded(FakeRig* rig, int photographs) {
    load(rig, photographs);
    return rig->address();
  }
};

TEST(LinkClient, ReceivesEveryPhotographAsItWas) {
  FakeRig rig;
  load(&rig, 3);
  LinkClient client(rig.address(), quick());
  EXPECT_EQ(client.calibration({}), std::string(3500, 'c'));
  const Burst burst = client.run_burst("sphere");
  const auto offers = client.offers(burst);
  ASSERT_EQ(offers.size(), 3u);
  for (const v1::FrameOffer& offer : offers) {
    EXPECT_EQ(client.photograph(offer), fake_photograph(offer.frame_id(), kPhotograph).bytes);
    client.acknowledge(offer);
  }
  EXPECT_EQ(rig.acknowledged(), (std::set<uint32_t>{0, 1, 2}));
  EXPECT_EQ(rig.connections(), 1);
}

TEST(LinkClient, CollectsTheTimingInParts) {
  FakeRig rig;
  load(&rig, 1);
  for (int i = 0; i < 150; ++i) {
    v1::TimedEdge edge;
    edge.set_planned_us(i);
    rig.add_edge(edge);
  }
  LinkClient client(rig.address(), quick());
  const v1::TimingEdges timing = client.timing(client.run_burst("sphere"));
  ASSERT_EQ(timing.edges_size(), 150);
  EXPECT_EQ(timing.edges(149).planned_us(), 149);
  EXPECT_EQ(timing.latency().lead_us(), 1.5);
}

TEST(LinkClient, GoesOnFromTheByteItHadReachedAfterACut) {
  FakeRigFaults faults;
  faults.cut_frame = 1;
  faults.cut_at_byte = 2345;
  faults.cut_times = 1;
  OfferedBurst burst(faults, 2);
  EXPECT_EQ(burst.client.photograph(burst.offers[1]), fake_photograph(1, kPhotograph).bytes);
  EXPECT_EQ(burst.rig.connections(), 2);
}

TEST(LinkClient, NamesFrameAndByteOfACutThatDoesNotMend) {
  FakeRigFaults faults;
  faults.cut_frame = 1;
  faults.cut_at_byte = 2345;
  faults.cut_times = 1000;
  OfferedBurst burst(faults, 2);
  const std::string line = failure([&] { burst.client.photograph(burst.offers[1]); });
  EXPECT_TRUE(says(line, "frame 1 (left STRIPES 1 CROSS) at byte 2345 of 5400"));
  EXPECT_TRUE(says(line, "connection closed"));
  EXPECT_TRUE(burst.rig.acknowledged().empty());
}

TEST(LinkClient, AsksAgainForADamagedChunk) {
  FakeRigFaults faults;
  faults.damaged_chunks = 1;
  OfferedBurst burst(faults, 1);
  EXPECT_EQ(burst.client.photograph(burst.offers[0]), fake_photograph(0, kPhotograph).bytes);
  EXPECT_EQ(burst.rig.connections(), 2);
}

TEST(LinkClient, AsksAgainForAChunkOutOfSequence) {
  FakeRigFaults faults;
  faults.chunks_out_of_sequence = 1;
  OfferedBurst burst(faults, 1);
  EXPECT_EQ(burst.client.photograph(burst.offers[0]), fake_photograph(0, kPhotograph).bytes);
}

TEST(LinkClient, NeverAllocatesWhatAnOverlongLengthAnnounces) {
  FakeRigFaults faults;
  faults.overlong_lengths = 100;
  OfferedBurst burst(faults, 1);
  EXPECT_TRUE(
      says(failure([&] { burst.client.photograph(burst.offers[0]); }), "over the limit of 65536"));
}

TEST(LinkClient, RefusesAPhotographWhoseOwnCrcDisagrees) {
  FakeRigFaults faults;
  faults.wrong_frame_crc = true;
  OfferedBurst burst(faults, 1);
  EXPECT_TRUE(says(failure([&] { burst.client.photograph(burst.offers[0]); }), "another CRC32C"));
}

TEST(LinkClient, SaysWhereNoRigAnswers) {
  std::string address;
  { address = FakeRig().address(); }  // a port that was just given back
  const std::string line = failure([&] { LinkClient(address, quick()); });
  EXPECT_TRUE(says(line, address));
  EXPECT_TRUE(says(line, "no rig answers"));
}

TEST(LinkClient, SaysOfABusyRigThatItIsBusyAndNotThatNoneAnswers) {
  FakeRigFaults faults;
  faults.is_busy = true;
  FakeRig rig(faults);
  const std::string line = failure([&] { LinkClient(rig.address(), quick()); });
  EXPECT_TRUE(says(line, "busy with another host"));
  EXPECT_FALSE(says(line, "no rig answers"));
}

TEST(LinkClient, TellsBothProtocolVersionsWhereTheyDisagree) {
  FakeRigFaults faults;
  faults.protocol_version = 7;
  FakeRig rig(faults);
  const std::string line = failure([&] { LinkClient(rig.address(), quick()); });
  EXPECT_TRUE(says(line, "version 7"));
}

TEST(LinkClient, PassesOnWhyABurstWasRefused) {
  FakeRigFaults faults;
  faults.refuses_burst = true;
  FakeRig rig(faults);
  LinkClient client(rig.address(), quick());
  const std::string line = failure([&] { client.run_burst("sphere"); });
  EXPECT_TRUE(says(line, "UNSAFE"));
  EXPECT_TRUE(says(line, "step 3 needs a longer settle"));
}

TEST(LinkClient, FindsTheBurstAgainWhenTheLinkBreaksDuringIt) {
  FakeRigFaults faults;
  faults.cut_during_burst = true;
  FakeRig rig(faults);
  load(&rig, 2);
  LinkClient client(rig.address(), quick());
  const Burst burst = client.run_burst("sphere");
  EXPECT_EQ(burst.frame_count, 2u);
  EXPECT_EQ(client.offers(burst).size(), 2u);
}

TEST(LinkClient, OfARigThatWasOffDuringTheBurstSaysWhatIsLeftAndHowToHaveIt) {
  FakeRigFaults faults;
  faults.cut_during_burst = true;
  faults.off_during_burst = "13 of 40 photographs are whole";
  FakeRig rig(faults);
  load(&rig, 2);
  LinkClient client(rig.address(), quick());
  const std::string line = failure([&] { client.run_burst("sphere"); });
  EXPECT_TRUE(says(line, "link cut during burst 42"));
  EXPECT_TRUE(says(line, "13 of 40 photographs are whole"));
  EXPECT_TRUE(says(line, "lamella rig recover --rig " + rig.address()));
  EXPECT_TRUE(says(line, "lamella rig sync --rig " + rig.address()));
}

TEST(LinkClient, OfARigThatStaysAwaySaysThatTheLinkWasCutInTheBurst) {
  FakeRigFaults faults;
  faults.cut_during_burst = faults.dies_in_burst = true;
  FakeRig rig(faults);
  load(&rig, 2);
  LinkOptions options = quick();
  options.retries = 2;
  LinkClient client(rig.address(), options);
  const std::string line = failure([&] { client.run_burst("sphere"); });
  EXPECT_TRUE(says(line, "link cut during burst 42 (connection closed), and not mended"));
  EXPECT_TRUE(says(line, "lamella rig recover --rig " + rig.address()));
}

TEST(LinkClient, OfASimulatedRigThatDiedNobodyIsSentLookingForItsBurst) {
  FakeRigFaults faults;
  faults.cut_during_burst = faults.dies_in_burst = true;
  FakeRig rig(faults);
  load(&rig, 1);
  LinkOptions options = quick();
  options.retries = 1;
  options.outlives_us = false;
  LinkClient client(rig.address(), options);
  const std::string line = failure([&] { client.run_burst("sphere"); });
  EXPECT_TRUE(says(line, "the simulated rig is gone"));
  EXPECT_FALSE(says(line, "rig sync"));
}

TEST(LinkClient, GivesUpOnARigThatDawdles) {
  FakeRigFaults faults;
  faults.reply_delay_s = 0.4;
  FakeRig rig(faults);
  LinkOptions options = quick();
  options.reply_s = 0.1;
  options.retries = 1;
  const std::string line = failure([&] { LinkClient(rig.address(), options); });
  EXPECT_TRUE(says(line, "no answer in time"));
  EXPECT_TRUE(says(line, "a rig that starts first tests itself for some seconds: try again"));
}

TEST(LinkClient, StopsAtOnceWhenInterrupted) {
  FakeRig rig;
  load(&rig, 1);
  bool interrupted = false;
  LinkOptions options = quick();
  options.interrupted = [&] { return interrupted; };
  LinkClient client(rig.address(), options);
  interrupted = true;
  EXPECT_TRUE(says(failure([&] { client.run_burst("sphere"); }), "interrupted"));
}

}  // namespace
}  // namespace lamella
