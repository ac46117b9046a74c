// Bad input gets one line that names the file and the field, the right exit code, and leaves
// nothing behind: neither an output nor a part of one.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "apps/run_lamella.h"
#include "io/fake_rig.h"
#include "io/fake_session.h"
#include "io/json_tree.h"
#include "io/labels.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using nlohmann::json;
using testing::Outcome;
using testing::run_lamella;

struct Spoilt {
  const char* name;                            // of the test
  std::function<void(const fs::path&)> spoil;  // the session folder
  std::vector<std::string> named;              // what the one line must name
};

void PrintTo(const Spoilt& spoilt, std::ostream* out) { *out << spoilt.name; }

void edit(const fs::path& session, const std::function<void(json*)>& change) {
  json manifest = json_tree(read_text(session / "session.json"));
  change(&manifest);
  std::ofstream(session / "session.json") << json_text(manifest, 1);
}

// A case that changes the manifest alone.
Spoilt manifest_case(const char* name, const std::function<void(json*)>& change,
                     std::vector<std::string> named) {
  named.push_back("session.json");
  return {name, [change](const fs::path& session) { edit(session, change); }, named};
}

json& camera(json* m, int i) { return (*m)["rig"]["cameras"][size_t(i)]; }
json& frame(json* m, int i) { return (*m)["frames"][size_t(i)]; }

std::vector<Spoilt> spoilt_photographs() {
  const fs::path victim = "frames/left/15_front_cross.exr";
  return {
      {"TruncatedExr",
       [=](const fs::path& s) { fs::resize_file(s / victim, fs::file_size(s / victim) / 2); },
       {victim.string()}},
      {"EmptyExr", [=](const fs::path& s) { fs::resize_file(s / victim, 0); }, {victim.string()}},
      {"FrameOfAnotherSize",
       [=](const fs::path& s) { write_exr_rgb(s / victim, Image3(32, 23, Vec3(0, 0, 0))); },
       {victim.string(), "23x32", "24x32"}},
      {"NanPixels",
       [=](const fs::path& s) {
         Image3 image(32, 24, Vec3(0, 0, 0));
         image(20, 3) = Vec3(1, kNaN, 1);
         write_exr_rgb(s / victim, image);
       },
       {victim.string(), "pixel (3, 20)"}},
      {"InfinitePixels",
       [=](const fs::path& s) {
         write_exr_rgb(s / victim, Image3(32, 24, Vec3(1e30f * 1e30f, 0, 0)));
       },
       {victim.string(), "pixel (0, 0)"}},
      {"MissingChannel",
       [=](const fs::path& s) {
         write_exr(s / victim, {{"R", Image1(32, 24, 0.f)}, {"G", Image1(32, 24, 0.f)}});
       },
       {victim.string(), "channel B"}},
      {"MissingFile", [=](const fs::path& s) { fs::remove(s / victim); }, {victim.string()}},
      {"EmptyRegion",
       [](const fs::path& s) { write_labels(s / "regions.png", Labels(32, 24, uchar(1))); },
       {"regions.png", "lips"}},
      {"LabelWithoutAName",
       [](const fs::path& s) { write_labels(s / "regions.png", Labels(32, 24, uchar(7))); },
       {"regions.png", "label 7"}},
      {"TruncatedLabels",
       [](const fs::path& s) { fs::resize_file(s / "regions.png", 60); },
       {"regions.png"}},
      {"ManifestThatIsNotJson",
       [](const fs::path& s) { std::ofstream(s / "session.json") << "twenty photographs\n"; },
       {"session.json", "not JSON"}},
      {"ManifestCutShort",
       [](const fs::path& s) { fs::resize_file(s / "session.json", 700); },
       {"session.json", "not JSON"}},
      {"NoManifest", [](const fs::path& s) { fs::remove(s / "session.json"); }, {"session.json"}},
  };
}

std::vector<Spoilt> spoilt_manifests() {
  return {
      manifest_case("MissingRole", [](json* m) { (*m)["frames"].erase(17); },
                    {"frames", "STRIPES 1"}),
      manifest_case("FocalLengthAboveTheLimit", [](json* m) { camera(m, 0)["fx"] = 1e10; },
                    {"cameras[0].fx", "must be at most 1e9"}),
      manifest_case("DuplicateRole", [](json* m) { frame(m, 17)["index"] = 0; },
                    {"frames[17].role"}),
      manifest_case("WrongType", [](json* m) { frame(m, 3)["exposure_us"] = "long"; },
                    {"frames[3].exposure_us", "\"long\""}),
      manifest_case("WrongTypeOfAList", [](json* m) { camera(m, 0)["rotation"] = 1; },
                    {"rig.cameras[0].rotation"}),
      manifest_case("UnknownRole", [](json* m) { frame(m, 3)["role"] = "SPARKLES"; },
                    {"frames[3].role", "SPARKLES"}),
      manifest_case("MissingField", [](json* m) { camera(m, 0).erase("fx"); },
                    {"rig.cameras[0].fx"}),
      manifest_case("NotFinite", [](json* m) { camera(m, 1)["cx"] = "Infinity"; },
                    {"rig.cameras[1].cx"}),
      manifest_case("OutsideTheSession", [](json* m) { frame(m, 2)["file"] = "../../etc/passwd"; },
                    {"frames[2].file", "../../etc/passwd"}),
      manifest_case("AbsurdSize", [](json* m) { camera(m, 0)["width"] = 1000000000; },
                    {"rig.cameras[0].width"}),
      manifest_case("OtherFormat", [](json* m) { (*m)["format"] = "lamella.session.v9"; },
                    {"format", "lamella.session.v9"}),
      manifest_case("NoProjector", [](json* m) { (*m)["rig"].erase("projector"); },
                    {"rig.projector"}),
  };
}

std::vector<Spoilt> all_spoilt() {
  std::vector<Spoilt> all = spoilt_photographs();
  for (const Spoilt& s : spoilt_manifests()) all.push_back(s);
  return all;
}

// Reads the same everywhere: one line, and nothing new on the disk.
void expect_refusal(const Outcome& outcome, int exit_code, const std::vector<std::string>& named) {
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
  const std::vector<std::string> lines = outcome.complaints();
  ASSERT_EQ(lines.size(), 1u) << outcome.err;
  for (const std::string& part : named) {
    EXPECT_NE(lines[0].find(part), std::string::npos) << lines[0] << "\ndoes not name " << part;
  }
}

class SpoiltSession : public ::testing::TestWithParam<Spoilt> {};

TEST_P(SpoiltSession, IsRefusedInOneLineAndLeavesNothing) {
  const testing::ScratchFolder scratch;
  const fs::path session = scratch.path() / "session", out = scratch.path() / "out";
  testing::write_fake_session(session);
  GetParam().spoil(session);
  const std::set<std::string> before = scratch.contents();
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"fit", session.string(), "--out", out.string()},
        std::vector<std::string>{"check", session.string()}}) {
    SCOPED_TRACE(arguments[0] + " " + arguments.back());
    expect_refusal(run_lamella(arguments), 2, GetParam().named);
    EXPECT_EQ(scratch.contents(), before);
  }
}

INSTANTIATE_TEST_SUITE_P(BadInput, SpoiltSession, ::testing::ValuesIn(all_spoilt()),
                         [](const auto& info) { return info.param.name; });

class Command : public ::testing::Test {
 protected:
  // Runs a command that must be refused, and looks that nothing new lies about.
  void refused(const std::vector<std::string>& arguments, int exit_code,
               const std::vector<std::string>& named) {
    const std::set<std::string> before = scratch_.contents();
    expect_refusal(run_lamella(arguments), exit_code, named);
    EXPECT_EQ(scratch_.contents(), before);
  }

  fs::path at(const std::string& name) const { return scratch_.path() / name; }
  std::string in(const std::string& name) const { return at(name).string(); }

  testing::ScratchFolder scratch_;
};

TEST_F(Command, WarnsOfAnUnknownFieldAndGoesOn) {
  testing::write_fake_session(at("session"));
  edit(at("session"), [](json* m) { (*m)["mood"] = "calm"; });
  const Outcome outcome = run_lamella({"check", in("session")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("mood"), std::string::npos);
}

TEST_F(Command, RefusesForARealRigWhatOnlyASimulatedOneObeys) {
  for (const char* option : {"--seed", "--scale", "--clock", "--rig-file"}) {
    SCOPED_TRACE(option);
    testing::FakeRig rig;
    testing::load_burst(&rig, testing::kFakeSize);
    const std::string value = option == std::string("--clock") ? "real" : "1";
    refused({"capture", "--rig", rig.address(), "--out", in("s"), option, value}, 2,
            {option, "is for the simulated rig alone"});
    EXPECT_EQ(rig.connections(), 0);
  }
}

TEST_F(Command, RefusesASessionThatIsNotThere) {
  for (const char* command : {"fit", "check"}) refused({command, in("none")}, 2, {in("none")});
  refused({"export", in("none"), "--out", in("face.glb")}, 2, {in("none")});
  refused({"render", in("none"), "--view", in("v.json"), "--out", in("i.exr")}, 2, {in("none")});
}

TEST_F(Command, RefusesToExportOrRenderWhatWasNeverFitted) {
  testing::write_fake_session(at("session"));
  std::ofstream(at("v.json")) << "{}";
  refused({"export", in("session"), "--out", in("face.glb")}, 2, {"session/fit"});
  refused({"render", in("session"), "--view", in("v.json"), "--out", in("i.exr")}, 2, {"session"});
}

TEST_F(Command, RefusesAnOutputNamedAsIfItWereOfAnotherKind) {
  testing::write_fake_session(at("session"));
  std::ofstream(at("v.json")) << "{}";
  refused({"review", in("session"), "--screenshot", in("face.jpg")}, 2,
          {"face.jpg: what is written there is no jpg file; let its name end with .png"});
  refused({"render", in("session"), "--view", in("v.json"), "--out", in("i.png")}, 2,
          {"i.png: what is written there is no png file; let its name end with .exr"});
  refused({"export", in("session"), "--out", in("face.gltf")}, 2,
          {"face.gltf: what is written there is no gltf file; let its name end with .glb"});
}

TEST_F(Command, RefusesAMapThatIsCut) {
  testing::write_fake_session(at("session"));
  write_exr_xyz(at("session/fit/position.exr"), Image3(32, 24, Vec3(1, 2, 3)));
  fs::resize_file(at("session/fit/position.exr"), 300);
  refused({"export", in("session"), "--out", in("face.glb")}, 2, {"position.exr"});
}

TEST_F(Command, NeverReplacesAFolderThatIsNoFit) {
  testing::write_fake_session(at("session"));
  fs::create_directory(at("letters"));
  std::ofstream(at("letters/dear.txt")) << "dear";
  const Outcome outcome = run_lamella({"fit", in("session"), "--out", in("letters")});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(fs::exists(at("letters/dear.txt")));
}

TEST_F(Command, NeverLetsTheTwinReplaceAFolderThatIsNoSession) {
  fs::create_directory(at("letters"));
  std::ofstream(at("letters/dear.txt")) << "dear";
  refused({"twin", "--subject", "sphere", "--scale", "0.1", "--out", in("letters")}, 2,
          {"letters", "not replaced"});
}

TEST_F(Command, NeverLetsTheTwinReplacePhotographsOrAFitThatItCannotMakeAgain) {
  testing::write_fake_session(at("session"));
  fs::create_directory(at("fit"));
  std::ofstream(at("fit/layers.json")) << "{}";
  refused({"twin", "--subject", "sphere", "--scale", "0.1", "--out", in("session")}, 2,
          {"session", "no truth"});
  refused({"twin", "--subject", "sphere", "--scale", "0.1", "--truth-out", in("fit")}, 2,
          {"fit", "no kernels.npz"});
  EXPECT_TRUE(fs::exists(at("session/frames/left/15_front_cross.exr")));
}

TEST_F(Command, ListsTheSkinsThatTheTwinKnowsToWhoeverAsksForAnother) {
  refused({"twin", "--skin", "green", "--scale", "0.1", "--out", in("s")}, 2,
          {"--skin: \"green\"; the twin knows layered, one_layer, no_single, dark and light"});
}

TEST_F(Command, DriftsTheTwinsSubjectAndSpreadsItsLedsOnlySoFar) {
  refused({"twin", "--drift", "11", "--scale", "0.1", "--out", in("s")}, 2,
          {"--drift: 11 mm; give a number from 0 to 10"});
  refused({"twin", "--drift", "1", "--scale", "0.1", "--truth-out", in("s")}, 2,
          {"--drift: is of --out; give --out with it"});
  refused({"twin", "--led-spread", "31", "--scale", "0.1", "--out", in("s")}, 2,
          {"--led-spread: 31 %; give a number from 0 to 30"});
}

TEST_F(Command, NamesThePlaceOfWhatTheDiskDoesNotTakeAndLeavesNothing) {
  testing::write_fake_session(at("session"), cv::Size(96, 128));
  std::vector<std::vector<std::string>> commands{{"fit", in("session")}};
#ifndef LAMELLA_SANITIZED  // it walks photons for a minute before it writes
  commands.push_back({"twin", "--subject", "sphere", "--scale", "0.1"});
#endif
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  for (const std::vector<std::string>& command : commands) {
    SCOPED_TRACE(command[0]);
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"--out", in("out")});
    const std::set<std::string> empty = scratch_.contents();
    const rlimit small{4096, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    const Outcome outcome = run_lamella(arguments);
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("lamella: " + in("out") + "/"), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find(".part"), std::string::npos) << outcome.err;
    EXPECT_EQ(scratch_.contents(), empty);
  }
  std::signal(SIGXFSZ, SIG_DFL);
}

TEST_F(Command, NeverReplacesTheTruthByAFit) {
  testing::write_fake_session(at("session"));
  fs::create_directory(at("session/truth"));
  for (const char* file : {"layers.json", "kernels.npz"}) std::ofstream(at("session/truth") / file);
  refused({"fit", in("session"), "--out", in("session/truth")}, 2, {"session/truth", "the truth"});
}

TEST_F(Command, NamesALinkThatLeadsToItself) {
  fs::create_symlink(at("loop"), at("loop"));
  for (const char* command : {"check", "fit"}) {
    refused({command, in("loop")}, 2, {in("loop"), "symbolic links"});
    EXPECT_EQ(run_lamella({command, in("loop")}).err.find("internal"), std::string::npos);
  }
}

TEST_F(Command, SaysThatNoRigAnswers) {
  std::string address;
  { address = testing::FakeRig().address(); }
  refused({"capture", "--rig", address, "--out", in("s")}, 3, {address, "no rig answers"});
}

TEST_F(Command, RefusesAnAddressThatIsNoneAndSaysWhatIsWrongWithIt) {
  refused({"capture", "--rig", "rig", "--out", in("s")}, 2, {"--rig", "names no port", "or sim"});
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"127.0.0.1:70000", "\"70000\" is no port: 1 to 65535"},
      {"127.0.0.1:0", "\"0\" is no port"},
      {"127.0.0.1:7x", "\"7x\" is no port"},
      {"rig.local", "names no port: give HOST:PORT"},
      {"rig.local:", "names no port"},
      {":7391", "names no host"},
      {"fe80::1:7391", "an IPv6 address is given as [HOST]:PORT"}};
  for (const auto& [address, says] : wrong) {
    SCOPED_TRACE(address);
    refused({"rig", "status", "--rig", address}, 2, {"--rig", says});
  }
}

TEST_F(Command, RefusesANameThatNobodyKnows) {
  refused({"rig", "recover", "--rig", "no such host:7391"}, 2, {"no such host:7391", "mistyped"});
}

TEST_F(Command, OfARigThatWasOffInMidBurstSaysSoAndWhereItsPartIsAndKeepsNothing) {
  testing::FakeRigFaults faults;
  faults.cut_during_burst = true;
  faults.off_during_burst = "13 of 40 photographs are whole";
  testing::FakeRig rig(faults);
  load_burst(&rig, testing::kFakeSize, {v1::Frame::DOTS});
  refused({"capture", "--rig", rig.address(), "--out", in("s")}, 3,
          {"link cut during burst 42", "13 of 40", "lamella rig recover --rig " + rig.address(),
           "lamella rig sync --rig " + rig.address()});
}

TEST_F(Command, OfABurstThatLacksAPhotographMakesASessionThatSaysSo) {
  testing::FakeRigFaults faults;
  faults.lacks = true;
  testing::FakeRig rig(faults);
  load_burst(&rig, testing::kFakeSize, {v1::Frame::DOTS});
  const Outcome capture = run_lamella({"capture", "--rig", rig.address(), "--out", in("s")});
  EXPECT_EQ(capture.exit_code, 1) << capture.err;
  EXPECT_NE(capture.out.find("not to fit   "), std::string::npos) << capture.out;
  const std::string reason =
      "no DOTS CROSS of the left camera; the rig says: MARKED: step 7 "
      "dropped by a camera; if no other folder has the burst whole, take it again";
  for (const char* command : {"check", "fit"}) {
    const Outcome outcome = run_lamella({command, in("s")});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << outcome.err;
  }
}

TEST_F(Command, RefusesASimulatedRigThatCannotBeBeforeItStartsOne) {
  std::ofstream(at("bad.rig")) << "leds = many\n";
  const std::vector<std::vector<std::string>> cases{
      {"--subject", "cow"},         {"--seed", "-1"},   {"--seed", "99999999999999999999999"},
      {"--scale", "0.05"},          {"--scale", "nan"}, {"--rig-file", in("none.rig")},
      {"--rig-file", in("bad.rig")}};
  for (const auto& wrong : cases) {
    SCOPED_TRACE(wrong[0] + " " + wrong[1]);
    refused({"capture", "--rig", "sim", "--out", in("s"), wrong[0], wrong[1]}, 2, {wrong[0]});
  }
}

TEST_F(Command, NamesTheRigFileAndTheLineThatIsWrong) {
  std::ofstream(at("bad.rig")) << "leds = many\n";
  refused({"capture", "--out", in("s"), "--rig-file", in("bad.rig")}, 2, {in("bad.rig") + ":1"});
}

TEST_F(Command, NamesFrameAndByteOfALinkCutInTheMiddleOfAFrame) {
  testing::FakeRigFaults faults;
  faults.cut_frame = 7;
  faults.cut_at_byte = 1500;
  faults.cut_times = 1000;
  testing::FakeRig rig(faults);
  testing::load_burst(&rig, testing::kFakeSize);
  refused({"capture", "--rig", rig.address(), "--out", in("deep/s")}, 3,
          {"frame 7 (left GRADIENT_Z CROSS)", "byte 1500 of 3456"});
  EXPECT_TRUE(rig.acknowledged().empty());
}

TEST_F(Command, NamesBothProtocolVersions) {
  testing::FakeRigFaults faults;
  faults.protocol_version = 9;
  testing::FakeRig rig(faults);
  refused({"capture", "--rig", rig.address(), "--out", in("s")}, 3, {"version 9"});
}

TEST_F(Command, CapturesWholeAndLetsTheRigForgetOnlyThen) {
  testing::FakeRig rig;
  testing::load_burst(&rig, testing::kFakeSize);
  const Outcome outcome =
      run_lamella({"capture", "--rig", rig.address(), "--out", in("s"), "--json"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(json_tree(outcome.out)["frames"], 40);
  EXPECT_EQ(rig.acknowledged().size(), 40u);
  EXPECT_TRUE(fs::exists(at("s/session.json")));
  EXPECT_TRUE(fs::exists(at("s/timing.json")));
}

TEST_F(Command, CaptureLosesNoSessionUnlessToldTo) {
  testing::FakeRig rig;
  testing::load_burst(&rig, testing::kFakeSize);
  testing::write_fake_session(at("s"));
  std::ofstream(at("s/notes.txt")) << "mine";
  EXPECT_EQ(run_lamella({"capture", "--rig", rig.address(), "--out", in("s")}).exit_code, 2);
  EXPECT_TRUE(fs::exists(at("s/notes.txt")));
  const Outcome told =
      run_lamella({"capture", "--rig", rig.address(), "--out", in("s"), "--replace"});
  EXPECT_EQ(told.exit_code, 0) << told.err;
  EXPECT_FALSE(fs::exists(at("s/notes.txt")));
}

TEST_F(Command, RigStatusTellsAFaultAndRigAbortClearsIt) {
  testing::FakeRigFaults faults;
  faults.stands_in_fault = true;
  testing::FakeRig rig(faults);
  const Outcome status = run_lamella({"rig", "status", "--rig", rig.address()});
  EXPECT_EQ(status.exit_code, 1);
  EXPECT_NE(status.out.find("FAULT, a camera missed a trigger"), std::string::npos) << status.out;
  EXPECT_EQ(run_lamella({"rig", "abort", "--rig", rig.address()}).exit_code, 0);
  const Outcome after = run_lamella({"rig", "status", "--rig", rig.address(), "--json"});
  EXPECT_EQ(after.exit_code, 0);
  EXPECT_EQ(json_tree(after.out)["state"], "IDLE");
}

}  // namespace
}  // namespace lamella
