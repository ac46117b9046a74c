// lamella rig sync and what it shares with rig recover, run as a user runs them.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "apps/burst_fetch.h"
#include "apps/resumed_source.h"
#include "apps/run_lamella.h"
#include "base/error.h"
#include "calib/same_rig.h"
#include "io/fake_rig.h"
#include "io/fake_session.h"
#include "io/json.h"
#include "io/json_tree.h"
#include "io/session.h"
#include "io/shortfall.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using testing::FakeRig;
using testing::FakeRigFaults;
using testing::Outcome;
using testing::run_lamella;

using testing::partial_burst;
using testing::whole_burst;

class RigBursts : public ::testing::Test {
 protected:
  Outcome sync(const FakeRig& rig) {
    return run_lamella({"rig", "sync", "--rig", rig.address(), "--out", out.string(), "--json"});
  }

  static LinkOptions quick() {
    LinkOptions options;
    options.retries = 2;
    options.backoff_s = 0.002;
    return options;
  }

  // Frame 5 breaks off at a byte until the link gives up, and no longer.
  static FakeRigFaults cut_for_good() {
    FakeRigFaults faults;
    faults.cut_frame = 5;
    faults.cut_at_byte = 700;
    faults.cut_times = quick().retries + 2;
    return faults;
  }

  apps::FetchedBurst fetch(const FakeRig& rig) {
    LinkClient client(rig.address(), quick());
    apps::ResumedSource source(&client, out / ".fetching");
    return apps::fetch_burst(&source, client.held().at(0), out);
  }

  testing::ScratchFolder scratch;
  fs::path out = scratch.path() / "sessions";
};

TEST_F(RigBursts, SyncMakesASessionAndOnlyThenTheRigForgetsTheBurst) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  const Outcome outcome = sync(rig);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NO_THROW(require_burst(read_session(out / "burst-000042")));
  EXPECT_EQ(rig.acknowledged().size(), 40u);
  EXPECT_FALSE(rig.holds_burst());
  EXPECT_FALSE(fs::exists(out / ".fetching"));
  const auto report = json_tree(outcome.out);
  EXPECT_EQ(report["bursts"][0]["photographs_held"], 40);
  EXPECT_EQ(report["bursts"][0]["session"], (out / "burst-000042").string());
  EXPECT_EQ(sync(rig).exit_code, 0);  // nothing is held
}

TEST_F(RigBursts, ACaptureNamesItsSubjectInTheSession) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  const auto capture = [&](const std::string& name) {
    return run_lamella({"capture", "--rig", rig.address(), "--out", (out / "s").string(),
                        "--flashing-confirmed", "--subject", name});
  };
  for (const std::string& name : {std::string(64, 'a'), std::string("J\xfc")}) {
    const Outcome refused = capture(name);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.err.find("--subject"), std::string::npos) << refused.err;
  }
  const Outcome outcome = capture("Alice");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(read_session(out / "s").subject, "Alice");
}

TEST_F(RigBursts, ARunThatWasCutOffIsTakenUpAtTheByteThatItHadReached) {
  FakeRig rig(cut_for_good());
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  EXPECT_THROW(fetch(rig), Error);
  EXPECT_FALSE(fs::exists(out / "burst-000042"));
  const size_t asked = rig.offsets(5).size();
  EXPECT_EQ(fetch(rig).offers.size(), 40u);
  EXPECT_EQ(rig.offsets(4).size(), 1u);  // frame 4 came whole the first time
  ASSERT_EQ(rig.offsets(5).size(), asked + 1);
  EXPECT_EQ(rig.offsets(5).back(), 700u);
}

TEST_F(RigBursts, BytesThatWereSpoiltBetweenTwoRunsAreFetchedAgain) {
  FakeRig rig(cut_for_good());
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  EXPECT_THROW(fetch(rig), Error);
  for (const auto& entry : fs::directory_iterator(out / ".fetching")) {
    std::fstream(entry.path(), std::ios::in | std::ios::out).put('?');
  }
  EXPECT_EQ(fetch(rig).offers.size(), 40u);
  EXPECT_EQ(rig.offsets(4).size(), 2u);
  EXPECT_EQ(rig.offsets(5).back(), 0u);
}

TEST_F(RigBursts, ASessionThatIsThereAlreadyIsAcknowledgedAndNotFetchedAgain) {
  FakeRig first;
  load_burst(&first, testing::kFakeSize);
  first.hold(whole_burst());
  ASSERT_EQ(sync(first).exit_code, 0);
  FakeRig same;  // the host went down before its acknowledgements left
  load_burst(&same, testing::kFakeSize);
  same.hold(whole_burst());
  EXPECT_EQ(sync(same).exit_code, 0);
  EXPECT_TRUE(same.offsets(5).empty());
  EXPECT_EQ(same.acknowledged().size(), 40u);
  FakeRig other;  // another rig counts from 1 too
  load_burst(&other, testing::kFakeSize);
  v1::HeldBurst later = whole_burst();
  later.set_begun_unix_us(1790000000000001);
  other.hold(later);
  EXPECT_EQ(sync(other).exit_code, 0);
  EXPECT_TRUE(fs::exists(out / "burst-000042-2" / "session.json"));
}

// While its first photograph is on the way another run does `meanwhile`.
class OvertakenSource : public apps::ResumedSource {
 public:
  OvertakenSource(LinkClient* rig, const fs::path& folder, std::function<void()> meanwhile)
      : ResumedSource(rig, folder), meanwhile_(std::move(meanwhile)) {}

  std::vector<uint8_t> photograph(const v1::FrameOffer& offer) override {
    if (const auto once = std::exchange(meanwhile_, nullptr)) once();
    return ResumedSource::photograph(offer);
  }

 private:
  std::function<void()> meanwhile_;
};

TEST_F(RigBursts, OfTwoRunsThatFetchOneBurstAtOnceTheLaterFindsItThere) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  LinkClient client(rig.address(), quick());
  const v1::HeldBurst held = client.held().at(0);
  apps::ResumedSource first(&client, out / ".fetching");
  OvertakenSource later(&client, out / ".fetching",
                        [&] { EXPECT_FALSE(apps::fetch_burst(&first, held, out).was_there); });
  const apps::FetchedBurst fetched = apps::fetch_burst(&later, held, out);
  EXPECT_TRUE(fetched.was_there);
  EXPECT_EQ(fetched.folder, out / "burst-000042");
  EXPECT_EQ(fetched.offers.size(), 40u);
  EXPECT_NO_THROW(require_burst(read_session(out / "burst-000042")));
  EXPECT_FALSE(fs::exists(out / "burst-000042-2"));
}

TEST_F(RigBursts, TwoRigsThatAreFetchedAtOnceLoseNoBurstThoughTheyCountAlike) {
  FakeRig rig, other;
  v1::HeldBurst of_other = whole_burst();
  of_other.set_begun_unix_us(1790000000000001);
  for (FakeRig* each : {&rig, &other}) load_burst(each, testing::kFakeSize);
  rig.hold(whole_burst());
  other.hold(of_other);
  LinkClient client(rig.address(), quick());
  OvertakenSource later(&client, out / ".fetching", [&] { fetch(other); });
  const apps::FetchedBurst fetched = apps::fetch_burst(&later, client.held().at(0), out);
  EXPECT_FALSE(fetched.was_there);
  EXPECT_EQ(fetched.folder, out / "burst-000042-2");
  EXPECT_EQ(json_tree(read_text(out / "burst-000042" / "burst.json"))["begun_unix_us"],
            of_other.begun_unix_us());
  EXPECT_NO_THROW(require_burst(read_session(fetched.folder)));
}

TEST_F(RigBursts, ABurstThatTheRigCannotReadStaysThereAndDoesNotKeepTheNextFromBeingFetched) {
  FakeRigFaults faults;
  faults.holds_damaged = true;
  FakeRig rig(faults);
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  const Outcome outcome = sync(rig);
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  const auto bursts = json_tree(outcome.out)["bursts"];
  ASSERT_EQ(bursts.size(), 2u);
  EXPECT_NE(bursts[0]["failed"].get<std::string>().find("cannot read burst 41"), std::string::npos);
  EXPECT_EQ(bursts[1]["failed"], "");
  EXPECT_NO_THROW(require_burst(read_session(out / "burst-000042")));
  EXPECT_EQ(rig.acknowledged().size(), 40u);
  EXPECT_FALSE(rig.forgot_damaged());
  EXPECT_FALSE(fs::exists(out / "burst-000041"));
}

TEST_F(RigBursts, ABurstThatIsHeldIsOfTheRigThatTookItWhateverThatHasBecome) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  v1::Welcome now = rig_of(testing::fake_calibration(testing::kFakeSize));
  now.mutable_patterns()->mutable_stripes()->set_period_px(16);
  now.set_led_count(now.led_count() + 1);
  rig.set_welcome(now);
  EXPECT_EQ(sync(rig).exit_code, 0);
  EXPECT_EQ(rig.acknowledged().size(), 40u);
}

TEST_F(RigBursts, SyncOfABurstThatTheRigMarkedKeepsWhatThereIsAndSaysThatItCannotBeFitted) {
  FakeRigFaults faults;
  faults.lacks = true;
  FakeRig rig(faults);
  load_burst(&rig, testing::kFakeSize, {v1::Frame::DOTS});
  v1::HeldBurst held = whole_burst();
  held.set_flashing_confirmed(true);
  rig.hold(held);
  const Outcome outcome = sync(rig);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  const auto report = json_tree(outcome.out)["bursts"][0];
  EXPECT_NE(report["unfit"].get<std::string>().find("no DOTS CROSS"), std::string::npos);
  EXPECT_EQ(read_shortfall(out / "burst-000042"), "MARKED: step 7 dropped by a camera");
  v1::Session manifest;
  read_json(out / "burst-000042" / "session.json", &manifest);
  EXPECT_TRUE(manifest.flashing_confirmed());
  EXPECT_FALSE(rig.holds_burst());
}

// The rest is where the capture that was cut off put it.
TEST_F(RigBursts, SyncOfARestAsksForAnotherBurstOnlyWhereNoOtherFolderHasThisOneWhole) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize, {v1::Frame::DOTS});
  v1::HeldBurst held = whole_burst();
  held.set_frames_acknowledged(2);
  rig.hold(held);
  const auto report = json_tree(sync(rig).out)["bursts"][0];
  EXPECT_NE(report["unfit"].get<std::string>().find(
                "2 of its photographs went to a host before; if no other folder has the burst "
                "whole, take it again"),
            std::string::npos)
      << report["unfit"];
}

// The calibration of load_burst() with regions, of which a rig has no picture.
std::string calibration_with_regions() {
  v1::Session calibration = testing::fake_calibration(testing::kFakeSize);
  calibration.mutable_regions()->set_file("regions.png");
  calibration.mutable_regions()->add_names("background");
  calibration.mutable_regions()->add_names("skin");
  return to_json(calibration);
}

TEST_F(RigBursts, RegionsInACalibrationAreLeftOutWithAWarningByCaptureAndBySync) {
  for (const bool is_sync : {false, true}) {
    SCOPED_TRACE(is_sync ? "sync" : "capture");
    FakeRig rig;
    load_burst(&rig, testing::kFakeSize);
    rig.set_calibration(calibration_with_regions());
    rig.hold(whole_burst());
    const fs::path session = is_sync ? out / "burst-000042" : out / "captured";
    const Outcome outcome =
        is_sync ? sync(rig)
                : run_lamella({"capture", "--rig", rig.address(), "--out", session.string()});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NE(outcome.err.find("warning: rig " + rig.address() +
                               ": burst 42: its calibration names regions (regions.png)"),
              std::string::npos)
        << outcome.err;
    ASSERT_TRUE(fs::exists(session / "session.json"));
    EXPECT_TRUE(read_session(session).regions_file.empty());
  }
}

TEST_F(RigBursts, WhatCannotBeFittedIsNamedByItsPlaceAndNotByTheFolderItWasMadeIn) {
  FakeRigFaults faults;
  faults.lacks = true;
  FakeRig rig(faults);
  load_burst(&rig, testing::kFakeSize, {v1::Frame::DOTS});
  rig.hold(whole_burst());
  const auto report = nlohmann::json::parse(sync(rig).out)["bursts"][0];
  const fs::path manifest = out / "burst-000042" / "session.json";
  EXPECT_EQ(report["unfit"].get<std::string>().find(manifest.string()), 0u) << report["unfit"];
}

TEST_F(RigBursts, ABurstThatIsRefusedNamesItsRigAndItsNumberAndNoFolderThatIsGone) {
  for (const bool is_sync : {false, true}) {
    SCOPED_TRACE(is_sync ? "sync" : "capture");
    FakeRig rig;
    load_burst(&rig, testing::kFakeSize, {v1::Frame::DOTS});
    rig.hold(whole_burst());
    const Outcome outcome =
        is_sync ? sync(rig)
                : run_lamella({"capture", "--rig", rig.address(), "--out", (out / "s").string()});
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_NE(outcome.err.find("rig " + rig.address() +
                               ": burst 42: session.json: frames: no DOTS CROSS of the left"),
              std::string::npos)
        << outcome.err;
    EXPECT_EQ(outcome.err.find(".part-"), std::string::npos) << outcome.err;
  }
}

// What a run that was killed in the middle of `place` leaves.
fs::path killed_run_of(const fs::path& place) {
  fs::create_directories(place.parent_path());
  const pid_t gone = fork();
  if (gone == 0) _exit(0);
  waitpid(gone, nullptr, 0);
  const std::string name = "." + place.filename().string() + ".part-" + std::to_string(gone) + "-0";
  fs::create_directories(place.parent_path() / name / "frames");
  std::ofstream(place.parent_path() / name / ".lock");
  return place.parent_path() / name;
}

TEST_F(RigBursts, WhatAKilledRunLeftIsRemovedByTheNextAndWhatItHadFetchedIsNot) {
  FakeRig rig(cut_for_good());
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  EXPECT_THROW(fetch(rig), Error);
  const fs::path left = killed_run_of(out / "burst-000042");
  const Outcome outcome = sync(rig);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("removed 1 half-written output that a run that was killed"),
            std::string::npos)
      << outcome.err;
  EXPECT_FALSE(fs::exists(left));
  EXPECT_EQ(rig.offsets(4).size(), 1u);
  EXPECT_EQ(rig.offsets(5).back(), 700u);
  EXPECT_EQ(sync(rig).err, "");
}

TEST_F(RigBursts, ACaptureThatIsCutOffAsTheRigForgetsSaysThatItsSessionIsWholeAndWhatIsLeftToDo) {
  FakeRigFaults faults;
  faults.dies_after_acks = 10;
  FakeRig rig(faults);
  load_burst(&rig, testing::kFakeSize);
  const fs::path session = out / "mine";
  const Outcome outcome =
      run_lamella({"capture", "--rig", rig.address(), "--out", session.string(), "--json"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.complaints().size(), 1u) << outcome.err;
  EXPECT_EQ(outcome.err.find("try again"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("the session is whole in " + session.string() +
                             "; the rig may still hold 30 of its 40 photographs: once it is back, "
                             "lamella rig sync --rig " +
                             rig.address() + " --out " + out.string() + " lets it forget them"),
            std::string::npos)
      << outcome.err;
  EXPECT_NO_THROW(require_burst(read_session(session)));
  EXPECT_EQ(json_tree(outcome.out)["session"], session.string());
}

TEST_F(RigBursts, CaptureTellsTheLargestErrorOfAllEdgesAsTheRigsVerdictDoes) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  for (const double error_us : {3812.0, 3633.5}) {
    v1::TimedEdge edge;
    edge.set_actual_us(error_us);
    edge.set_replaced(error_us > 3800);
    rig.add_edge(edge);
  }
  const Outcome outcome =
      run_lamella({"capture", "--rig", rig.address(), "--out", (out / "s").string(), "--json"});
  EXPECT_EQ(json_tree(outcome.out)["largest_edge_error_us"], 3812.0) << outcome.err;
}

TEST_F(RigBursts, SyncFindsWhatACaptureSavedBesideAndMakesNoStumpOfIt) {
  FakeRig cut([] {
    FakeRigFaults faults;
    faults.dies_after_acks = 0;
    return faults;
  }());
  load_burst(&cut, testing::kFakeSize);
  const fs::path session = out / "mine";
  run_lamella({"capture", "--rig", cut.address(), "--out", session.string()});
  FakeRig rig;  // the same, back, with what it had not forgotten
  v1::HeldBurst held = whole_burst();
  held.set_begun_unix_us(0);
  load_burst(&rig, testing::kFakeSize);
  rig.hold(held);
  const Outcome outcome = sync(rig);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json_tree(outcome.out)["bursts"][0]["session"], session.string());
  EXPECT_TRUE(rig.offsets(5).empty());
  EXPECT_EQ(rig.acknowledged().size(), 40u);
  EXPECT_FALSE(fs::exists(out / "burst-000042"));
}

TEST_F(RigBursts, CaptureRemovesWhatAKilledCaptureLeftThere) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  const fs::path left = killed_run_of(out / "first");
  const Outcome outcome =
      run_lamella({"capture", "--rig", rig.address(), "--out", (out / "second/").string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(fs::exists(left));
}

TEST_F(RigBursts, SyncOfAPartialBurstKeepsWhatIsWholeWithTheReasonAndSaysSo) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize, {v1::Frame::DOTS});
  rig.hold(partial_burst());
  EXPECT_EQ(sync(rig).exit_code, 1);
  EXPECT_TRUE(fs::exists(out / "burst-000042.partial" / "session.json"));
  const std::string note = read_text(out / "burst-000042.partial" / "burst.json");
  EXPECT_EQ(json_tree(note)["why"], "the power went");
  EXPECT_FALSE(rig.holds_burst());
}

TEST_F(RigBursts, ABurstOfWhichNothingIsWholeIsExplainedAndReleased) {
  FakeRig rig;
  rig.hold(partial_burst());
  const Outcome outcome = sync(rig);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_NE(outcome.out.find("the power went"), std::string::npos);
  EXPECT_FALSE(rig.holds_burst());
}

TEST_F(RigBursts, AnInterruptionSaysWhatIsSoNowAndAdvisesNothingElse) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> commands = {
      {{"sync", "--out", out.string()}, "what the rig holds stays there; lamella rig sync"},
      {{"recover"}, "nothing was changed there; recover again to see the rest\n"},
      {{"selftest"}, "the rig ends its test by itself; test again to see what it finds\n"}};
  for (const auto& [command, says] : commands) {
    SCOPED_TRACE(command[0]);
    FakeRigFaults faults;
    faults.reply_delay_s = 3;
    FakeRig rig(faults);
    std::vector<std::string> arguments{"rig"};
    arguments.insert(arguments.end(), command.begin(), command.end());
    arguments.insert(arguments.end(), {"--rig", rig.address()});
    const Outcome outcome =
        testing::interrupt_lamella(arguments, [&] { return rig.connections() > 0; });
    EXPECT_EQ(outcome.exit_code, 3);
    EXPECT_NE(outcome.err.find("rig " + rig.address() + ": interrupted; " + says),
              std::string::npos)
        << outcome.err;
  }
}

TEST_F(RigBursts, APlaceForSessionsThatIsNoFolderIsRefusedThoughNothingIsHeld) {
  const fs::path link = scratch.path() / "link";
  write_whole_text(out, "a letter");
  fs::create_symlink(scratch.path() / "gone", link);
  FakeRig rig;
  for (const std::string command : {"sync", "recover"}) {
    for (const auto& [place, says] :
         {std::pair(out, "exists and is not a folder"), {link, "is a link to"}}) {
      const Outcome outcome =
          run_lamella({"rig", command, "--rig", rig.address(), "--out", place.string()});
      EXPECT_EQ(outcome.exit_code, 2) << command;
      EXPECT_NE(outcome.err.find(place.string() + ": " + says), std::string::npos) << outcome.err;
    }
  }
  EXPECT_EQ(read_text(out), "a letter");
}

TEST_F(RigBursts, SyncIntoALinkThatLeadsNowhereSaysSoAndTheBurstStaysOnTheRig) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(whole_burst());
  fs::create_directories(out);
  fs::create_symlink(scratch.path() / "unplugged", out / "burst-000042");
  const Outcome outcome = sync(rig);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find((out / "burst-000042").string() + ": is a link to " +
                             (scratch.path() / "unplugged").string() + ", which is not there"),
            std::string::npos)
      << outcome.err;
  EXPECT_TRUE(rig.offsets(5).empty());  // before anything was fetched
  EXPECT_TRUE(rig.holds_burst());
}

}  // namespace
}  // namespace lamella
