// What a session, a fit or a rig says is shown on terminals: none of it is obeyed there.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/run_lamella.h"
#include "io/fake_rig.h"
#include "io/fake_session.h"
#include "io/json_tree.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

// Clears a terminal, by seven bits and by eight, and rings it.
constexpr char kObeyed[] = "\x1b[2J\xc2\x9b\x32J\a";

void expect_shown(const std::string& text, const std::string& as) {
  EXPECT_NE(text.find(as), std::string::npos) << text;
  for (const char* obeyed : {"\x1b", "\xc2\x9b", "\a"}) {
    EXPECT_EQ(text.find(obeyed), std::string::npos) << text;
  }
}

class Terminal : public ::testing::Test {
 protected:
  void edit_session(const std::function<void(nlohmann::json*)>& change) {
    testing::write_fake_session(session);
    nlohmann::json manifest = json_tree(read_text(session / "session.json"));
    change(&manifest);
    std::ofstream(session / "session.json") << json_text(manifest, 1);
  }

  testing::ScratchFolder scratch;
  fs::path session = scratch.path() / "session";
};

TEST_F(Terminal, ObeysNoSubjectOfASession) {
  edit_session([](auto* m) { (*m)["subject"] = std::string("A") + kObeyed + "B\nC"; });
  expect_shown(run_lamella({"check", session.string()}).out, R"("A\x1b[2J\x9b2J\x07B\nC")");
}

TEST_F(Terminal, ObeysNoFieldOfASessionThatIsWarnedOf) {
  edit_session([](auto* m) { (*m)[std::string("mood") + kObeyed] = "calm"; });
  expect_shown(run_lamella({"check", session.string()}).out, R"(mood\x1b[2J\x9b2J\x07: unknown)");
  expect_shown(run_lamella({"fit", session.string()}).err, R"(mood\x1b[2J\x9b2J\x07: unknown)");
}

TEST_F(Terminal, ObeysNoPartOfAnError) {
  edit_session([](auto* m) { (*m)["format"] = kObeyed; });
  expect_shown(run_lamella({"check", session.string()}).err, R"([2J\x9b2J)");
}

TEST_F(Terminal, ObeysNoArgumentAndAnErrorInOneIsALine) {
  const std::string bad = std::string("A") + kObeyed + "\nB";
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"rig", "status", "--rig", bad},
        {"rig", "selftest", "--rig", "sim", "--only", bad},
        {"rig", "pair", "--rig", "1.2.3.4:1", "--wait", bad},
        {"fit", session.string(), "--" + bad}}) {
    const Outcome outcome = run_lamella(command);
    EXPECT_EQ(outcome.exit_code, 2) << command[1];
    expect_shown(outcome.err, R"(A\x1b[2J\x9b2J\x07\nB)");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

TEST_F(Terminal, ObeysNoWordOfARig) {
  testing::FakeRig rig;
  v1::Welcome welcome;
  welcome.set_firmware_version(std::string("1.0") + kObeyed);
  rig.set_welcome(welcome);
  v1::HeldBurst held;
  held.set_why(std::string("the power") + kObeyed + "went");
  rig.hold(held);
  expect_shown(run_lamella({"rig", "status", "--rig", rig.address()}).out,
               R"(firmware 1.0\x1b[2J\x9b2J\x07,)");
  expect_shown(run_lamella({"rig", "recover", "--rig", rig.address()}).out,
               R"(the power\x1b[2J\x9b2J\x07went)");
}

}  // namespace
}  // namespace lamella
