// What lamella-rigd is given on its command line and in its files, and says of what is wrong there.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "rigd_bench.h"
#include "test_host.h"
#include "test_rig.h"

namespace {

class RigdInput : public Rigd {
 protected:
  void expect_failure(const std::vector<std::string>& more, int code, const std::string& says) {
    RigProcess rigd(arguments(more));
    EXPECT_EQ(rigd.exit_code(), code);
    const std::string errors = rigd.errors();
    EXPECT_NE(errors.find(says), std::string::npos) << errors;
  }
};

}  // namespace

TEST_F(RigdInput, RefusesToListenBeyondLoopback) {
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

TEST_F(RigdInput, BadInputIsOneLineAndExitCodeTwo) {
  expect_failure({"--rig", "/nowhere.rig"}, 2, "/nowhere.rig: cannot be read");
  expect_failure({"--calibration", "/nowhere.json"}, 2, "/nowhere.json: cannot be read");
  expect_failure({"--hal", "linux"}, 2, "the rig file has no linux. keys");
  expect_failure({"--hal", "arduino"}, 2, "there are sim and linux");
  expect_failure({"--clock", "sundial"}, 2, "--clock sundial: there are virtual and real; see");
  expect_failure({"--inject", "flip-bit:9999"}, 2, "--inject flip-bit:9999: bits are");
  expect_failure({"--inject"}, 2, "--inject: needs a value");
  expect_failure({"--brightness", "7"}, 2, "--brightness: no such option; see lamella-rigd --help");
  expect_failure({"bright"}, 2, "bright: is no option");
  expect_failure({"--standalone"}, 2, "--standalone: needs --store");
  const std::string wrong = folder / "wrong.rig";
  std::ofstream(wrong) << "# a rig\nleds.spi_hz = 99e6\n";
  expect_failure({"--rig", wrong}, 2, wrong + ":2: 'leds.spi_hz' is 99000000");
}

TEST_F(RigdInput, AnOptionThatIsGivenTwiceOrWithNothingIsRefused) {
  std::vector<std::string> options = {"--store", "--state", "--name", "--led-reference", "--clock"};
  for (const std::string& word : arguments()) {
    if (word.starts_with("--")) options.push_back(word);
  }
  for (const std::string& option : options) {
    expect_failure({option, ""}, 2, "lamella-rigd: " + option + ": needs a value; see");
    std::vector<std::string> twice = arguments({option, "one"});
    twice.insert(twice.end(), {option, "two"});
    RigProcess rigd(twice);
    EXPECT_EQ(rigd.exit_code(), 2) << option;
    EXPECT_EQ(rigd.errors(),
              "lamella-rigd: " + option + " two: given twice; see lamella-rigd --help\n");
  }
  expect_failure({"--inject", ""}, 2, "--inject: needs a value");
  expect_failure({"--inject", "hot:80", "--inject", "hot:90"}, 2,
                 "--inject hot:90: one of its kind is given already");
  expect_failure({"--inject", "late-blank:1", "--inject", "estop", "--inject", "late-blank:2:3"}, 2,
                 "--inject late-blank:2:3: one of its kind is given already");
}

TEST_F(RigdInput, CheckPlanAndAnnounceAreEachAllThatIsDone) {
  const std::string file = folder / "announced";
  for (const auto& [both, says] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"--check", "--plan"}, "--check: not with --plan"},
           {{"--announce", file, "--check"}, "--announce: not with --check"},
           {{"--plan", "--announce", file, "--state", folder}, "--announce: not with --plan"}}) {
    RigProcess rigd(arguments(both));
    EXPECT_EQ(rigd.exit_code(), 2) << says;
    EXPECT_EQ(rigd.output(), "");
    EXPECT_EQ(rigd.errors(), "lamella-rigd: " + says + "; see lamella-rigd --help\n");
    EXPECT_FALSE(std::filesystem::exists(file));
  }
}

TEST_F(RigdInput, PhotographsAreATwinsOrNoiseAndNotBoth) {
  std::vector<std::string> both = arguments();
  both.push_back("--test-frames");
  RigProcess rigd(both);
  EXPECT_EQ(rigd.exit_code(), 2);
  EXPECT_EQ(rigd.errors(),
            "lamella-rigd: --test-frames: not with --twin: leave out one of them; see lamella-rigd "
            "--help\n");
}

TEST_F(RigdInput, NothingThatATerminalObeysComesOfTheCommandLine) {
  const std::string evil = "\x1b]0;a\x07\x7f\n\xc2\x9b\x9b\xc3\xa4";
  const std::string shown = R"(\x1b]0;a\x07\x7f\n\x9b\x9b)"
                            "\xc3\xa4";
  for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
           {"--hal", evil},
           {"--" + evil},
           {evil},
           {"--clock", evil},
           {"--inject", evil},
           {"--inject", "dead-led:" + evil},
           {"--rig", evil},
           {"--calibration", evil},
           {"--listen", evil},
           {"--listen", "127.0.0.1:" + evil},
           {"--store", evil},
           {"--state", evil},
           {"--twin", evil},
           {"--announce", evil + "/", "--state", folder, "--listen", "127.0.0.1:7391"},
           {"--check", "--rig", evil}}) {
    RigProcess rigd(arguments(more));
    EXPECT_NE(rigd.exit_code(), 0) << more[0];
    const std::string errors = rigd.errors();
    EXPECT_NE(errors.find(shown), std::string::npos) << more[0] << ": " << errors;
    EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1) << errors;
    EXPECT_TRUE(std::none_of(errors.begin(), errors.end(), [](char c) {
      return (c >= 0 && c < ' ' && c != '\n') || c == '\x7f' || c == '\x9b';
    })) << errors;
  }
}

TEST_F(RigdInput, AFaultOfAPartThatTheRigHasNotIsRefusedWithThoseThatItHas) {
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"dead-led:150", "LEDs are 0 to 149"},
      {"weak-led:167", "LEDs are 0 to 149"},
      {"swapped-leds:3:150", "LEDs are 0 to 149"},
      {"swapped-leds:150:3", "LEDs are 0 to 149"},
      {"swapped-leds:3:3", "it takes two LEDs"},
      {"flip-bit:2016", "bits are 0 to 2015"},
      {"stuck-bit:2016", "bits are 0 to 2015"},
      {"missing-chip:7", "chips are 0 to 6"},
      {"broken-chip:7", "chips are 0 to 6"},
      {"forgetful-chip:7", "chips are 0 to 6"},
      {"missing-camera:2", "cameras are 0 to 1"},
      {"drop-frame:32", "shots of a burst are 0 to 31"},
      {"late-blank:50:32", "pulses of a burst are 0 to 31"},
      {"spi-error:128", "LED frames of a burst are 0 to 127"}};
  for (const auto& [fault, says] : wrong) {
    expect_failure({"--inject", fault}, 2, "--inject " + fault + ": " + says);
  }
  expect_failure({"--check", "--inject", "dead-led:150"}, 2, "LEDs are 0 to 149");
}

TEST_F(RigdInput, AFaultThatIsNoneIsToldFromOneWithAnArgumentThatItDoesNotTake) {
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"dead-led:xyz", "\"xyz\" is no argument of dead-led:N"},
      {"dead-led:1.5", "\"1.5\" is no argument of dead-led:N"},
      {"dead-led:0x1", "\"0x1\" is no argument of dead-led:N"},
      {"dead-led", "\"\" is no argument of dead-led:N"},
      {"hot:0x10", "\"0x10\" is no argument of hot:CELSIUS"},
      {"late-blank:1e999", "\"1e999\" is no argument of late-blank:US[:PULSE]"},
      {"press:1:x", "\"1:x\" is no argument of press:AT_US:FOR_US"},
      {"estop:1", "\"1\" is no argument of estop"},
      {"dead", "no such fault"},
      {"dead-leds:3", "no such fault"},
      {":3", "no such fault"}};
  for (const auto& [fault, says] : wrong) {
    expect_failure({"--inject", fault}, 2,
                   "--inject " + fault + ": " + says + "; see lamella-rigd");
  }
}

TEST_F(RigdInput, ADaemonWhoseListeningLineIsLostEndsWithTwo) {
  std::string command = "timeout -s KILL 20 " LAMELLA_RIGD;
  for (const std::string& a : arguments({})) command += " " + a;
  const std::string errors = folder / "errors";
  const int status = std::system((command + " >/dev/full 2>" + errors).c_str());
  EXPECT_EQ(WEXITSTATUS(status), 2);
  std::ifstream file(errors);
  const std::string told{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(told.find("lamella-rigd: standard output: cannot be written: No space"),
            std::string::npos)
      << told;
}

TEST_F(RigdInput, WhatCannotBeWrittenToStandardOutputIsExitCodeTwoAndALine) {
  for (const std::string what :
       {"--help", "--version", "--plan --rig " LAMELLA_BOARD_DIR "/sim.rig"}) {
    const std::string errors = folder / "errors";
    const int status = std::system((LAMELLA_RIGD " " + what + " >/dev/full 2>" + errors).c_str());
    EXPECT_EQ(WEXITSTATUS(status), 2) << what;
    std::ifstream file(errors);
    const std::string told{std::istreambuf_iterator<char>(file), {}};
    EXPECT_NE(told.find("lamella-rigd: standard output: cannot be written: No space"),
              std::string::npos)
        << told;
  }
}

TEST_F(RigdInput, HelpFitsOnAScreenAndNamesEveryFaultAndVersionIsOneLine) {
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

TEST_F(RigdInput, ManualNamesEveryOptionAndFaultOfHelp) {
  std::ifstream file(LAMELLA_BOARD_DIR "/../../debian/lamella-rigd.8");
  const std::string manual{std::istreambuf_iterator<char>(file), {}};
  RigProcess rigd({"--help"});
  const std::string help = rigd.output();
  const std::regex word("--[a-z][a-z-]*|\\b[a-z]+-[a-z]+(?=:)|\\bhot(?=:)|\\bpress(?=:)");
  int count = 0;
  for (std::sregex_iterator at(help.begin(), help.end(), word), end; at != end; ++at, ++count) {
    const std::string written = std::regex_replace(at->str(), std::regex("-"), "\\-");
    EXPECT_NE(manual.find(written), std::string::npos) << written;
  }
  EXPECT_GT(count, 30);
}

TEST_F(RigdInput, WhatIsMissingOfARealRigIsToldBeforeAnyHardwareIsTouched) {
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

TEST_F(RigdInput, ACalibrationThatNoHostCouldUseIsRefusedAtTheStartAndNothingIsWritten) {
  const std::string path = folder / "other.json", store = folder / "store";
  const std::string test_frames = "--test-frames", vm = LAMELLA_BOARD_DIR "/vm.rig";
  std::filesystem::create_directory(store);
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"", "is empty; replace it"},
      {std::string("\x9f\x01\xffnoise"), "line 1: not JSON"},
      {board_text("vm.rig"), "line 1: not JSON: no value begins here"},
      {R"({"format": "lamella.session.v1"})", "has no \"rig\""},
      {calibration_text(600, 750, "", "vm"), "line 5: the left camera has 600 x 750 pixels"}};
  for (const auto& [text, says] : wrong) {
    std::ofstream(path) << text;
    const std::string line = "lamella-rigd: --calibration " + path + ": " + says;
    expect_failure({"--calibration", path, test_frames, "--rig", vm, "--store", store}, 2, line);
    expect_failure({"--calibration", path, "--hal", "linux", "--rig", vm}, 2, line);
    EXPECT_TRUE(std::filesystem::is_empty(store)) << says;
  }
}

TEST_F(RigdInput, CheckJudgesTheCalibrationThatItIsGiven) {
  const std::string path = folder / "other.json", vm = LAMELLA_BOARD_DIR "/vm.rig";
  const auto check = [&] {
    RigProcess rigd({"--check", "--rig", vm, "--calibration", path});
    const int code = rigd.exit_code();
    return std::pair(code, rigd.errors());
  };
  EXPECT_EQ(check().first, 2);
  std::ofstream(path) << calibration_text(600, 750, "", "vm");
  EXPECT_EQ(check(), std::pair(2, "lamella-rigd: --calibration " + path +
                                      ": line 5: the left camera has 600 x 750 pixels, the rig "
                                      "file's (camera.width_px, camera.height_px) 160 x 120: make "
                                      "both say what is there\n"));
  std::ofstream(path) << calibration_text(160, 120, "", "vm");
  EXPECT_EQ(check(), std::pair(0, std::string()));
}

TEST_F(RigdInput, AFolderForPhotographsThatIsNotThereIsToBeMade) {
  const std::string calibration = folder / "calibration.json", gone = folder / "gone";
  std::ofstream(calibration) << calibration_text(160, 120, "", "vm");
  expect_failure({"--calibration", calibration, "--test-frames", "--rig",
                  LAMELLA_BOARD_DIR "/vm.rig", "--store", gone},
                 2, "lamella-rigd: --store " + gone + ": no such folder: make one");
}

TEST_F(RigdInput, WaitsForNoPipeInPlaceOfAFile) {
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  expect_failure({"--check", "--rig", pipe}, 2, pipe + ": cannot be read: not a plain file");
  expect_failure({"--calibration", pipe}, 2, pipe + ": cannot be read: not a plain file");
  expect_failure({"--led-reference", pipe}, 2, pipe + ": cannot be read: not a plain file");
}

TEST_F(RigdInput, CheckNamesEveryWrongKeyOfBothFilesWithItsLine) {
  const std::string wrong = folder / "wrong.rig", leds = folder / "few.leds";
  std::ofstream(wrong) << "leds.spi_mhz = 10\nleds.file = few.leds\ncamera.iso = fast\n";
  std::ofstream(leds) << "led.count = 3\nled.0 = 0 0 0 1 0\nled.1 = 9 0 0 1 0\nled.3 = 1 0 0 1 0\n";
  RigProcess rigd({"--check", "--rig", wrong});
  EXPECT_EQ(rigd.exit_code(), 2);
  const std::string errors = rigd.errors();
  for (const std::string& line :
       {wrong + ":1: unknown key 'leds.spi_mhz'; is 'leds.spi_hz' meant?\n",
        wrong + ":3: 'camera.iso' needs one decimal number, not 'fast'\n",
        wrong + ": missing key 'light.least_share'\n", leds + ":3: 'led.1' is at chip 9",
        leds + ":4: 'led.3' stands where 'led.2' is due"}) {
    EXPECT_NE(errors.find(line), std::string::npos) << line << "\n" << errors;
  }
}

TEST_F(RigdInput, CheckRefusesARigFileWhoseBurstTheRigWouldAlwaysRefuse) {
  const std::string refused = folder / "refused.rig";
  std::ofstream(folder / "dome150.leds") << board_text("dome150.leds");
  for (const auto& [line, says] : std::vector<std::pair<std::string, std::string>>{
           {"light.least_share = 0.9", "light.least_share asks 90 %"},
           {"burst.longest_us = 10000", "burst.longest_us asks a subject to sit still for 0.01 s"},
           {"leds.highest_duty = 0.01", "LEDs are on for more than leds.highest_duty allows"}}) {
    const std::string key = line.substr(0, line.find(" ="));
    std::ofstream(refused) << std::regex_replace(
        board_text("vm.rig"), std::regex("(^|\n)" + key + " *=[^\n]*"), "$1" + line);
    RigProcess rigd({"--check", "--rig", refused});
    EXPECT_EQ(rigd.exit_code(), 2) << line;
    const std::string errors = rigd.errors();
    EXPECT_EQ(errors.find(refused + ": the rig would not play its burst: "), 0u) << errors;
    EXPECT_NE(errors.find(says), std::string::npos) << errors;
  }
}

TEST_F(RigdInput, EveryRigFileThatShipsPassesTheCheck) {
  size_t count = 0;
  for (const auto& file : std::filesystem::directory_iterator(LAMELLA_BOARD_DIR)) {
    if (file.path().extension() != ".rig") continue;
    RigProcess rigd({"--check", "--rig", file.path()});
    EXPECT_EQ(rigd.exit_code(), 0) << file.path() << rigd.errors();
    count++;
  }
  EXPECT_EQ(count, 7u);
}

TEST_F(RigdInput, LedsAreLookedForBesideTheRigFileAlone) {
  const std::string rig = folder / "some.rig";
  std::ofstream(rig) << "leds.file = none.leds\n";
  expect_failure({"--rig", rig}, 2, (folder / "none.leds").string() + ": cannot be read");
  std::ofstream(rig) << "leds.file = ../none.leds\n";
  expect_failure({"--rig", rig}, 2, rig + ":1: 'leds.file' is a file beside this one");
}

TEST_F(RigdInput, MissingTwinIsExitCodeThree) {
  expect_failure({"--twin", "/nowhere/socket"}, 3, "no twin answers");
}
