// calibration.json: what the daemon takes, and what it says of all else.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>

#include "test_calibration.h"
#include "test_rig.h"

extern "C" {
#include "calibration.h"
#include "json_scan.h"
}

namespace {

const rig_camera* vm_cameras() {
  static const struct rig rig = test_rig("vm");
  return &rig.sensor;
}

// "" where it is taken.
std::string complaint(const std::string& text, const rig_camera* own = nullptr) {
  char why[CALIBRATION_WHY_CHARS] = "";
  const bool good = calibration_check(text.data(), text.size(), own, why);
  EXPECT_EQ(good, why[0] == '\0') << why;
  EXPECT_EQ(std::string(why).find('\n'), std::string::npos) << why;
  return why;
}

std::string changed(const std::string& from, const std::string& to) {
  std::string text = calibration_text();
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expect_complaint(const std::string& text, const std::string& says,
                      const rig_camera* own = nullptr) {
  EXPECT_NE(complaint(text, own).find(says), std::string::npos) << complaint(text, own);
}

// Every path of a text with the value that stands there, in order; "!LINE what" at an error.
std::string scanned(const std::string& text) {
  std::string told;
  json_error error{};
  const auto take = [](void* context, const json_value* value) {
    *static_cast<std::string*>(context) +=
        std::string(value->path) + "=" + std::string(value->text, value->length) + " ";
  };
  if (!json_scan(text.data(), text.size(), take, &told, &error)) {
    told += "!" + std::to_string(error.line) + " " + error.what;
  }
  return told;
}

}  // namespace

TEST(Calibration, OfTheRightSizeIsTakenAndSoIsAnyWhereTheSizeIsATwins) {
  EXPECT_EQ(complaint(calibration_text(), vm_cameras()), "");
  EXPECT_EQ(complaint("\xEF\xBB\xBF" + calibration_text(), vm_cameras()), "");
  EXPECT_EQ(complaint(calibration_text(600, 750)), "");
  EXPECT_EQ(complaint(changed(R"("width": 160)", R"("width": 1.6e2)"), vm_cameras()), "");
}

TEST(Calibration, OfAnotherSizeThanTheRigFilesIsRefusedWithBothSizesAndTheLine) {
  expect_complaint(calibration_text(600, 750),
                   "line 4: the left camera has 600 x 750 pixels, the rig file's (camera.width_px, "
                   "camera.height_px) 160 x 120: make both say what the camera sends",
                   vm_cameras());
  std::string one = calibration_text();
  one.replace(one.rfind("120"), 3, "121");
  expect_complaint(one, "line 5: the right camera has 160 x 121 pixels", vm_cameras());
}

TEST(Calibration, ThatIsNoJsonIsRefusedWithTheLine) {
  expect_complaint("", "is empty");
  expect_complaint(rig_file_text(), "line 1: not JSON: no value begins here");
  expect_complaint("[]", "is no JSON object");
  expect_complaint("null", "is no JSON object");
  const std::string whole = calibration_text();
  for (size_t length = 1; length < whole.size() - 1; length++) {
    expect_complaint(whole.substr(0, length), "not JSON");
  }
  expect_complaint(whole + "}", "line 7: not JSON: something comes after its end");
  std::mt19937 random(1);
  for (int round = 0; round < 1000; round++) {
    std::string noise(random() % 64 + 1, '\0');
    for (char& byte : noise) byte = static_cast<char>(random());
    EXPECT_NE(complaint(noise), "");
  }
}

TEST(Calibration, WithoutWhatASessionNeedsIsRefusedByTheNameOfWhatIsMissing) {
  expect_complaint("{}", "\"format\" is not \"lamella.session.v1\"; replace it");
  expect_complaint(changed("session.v1", "session.v2"), "\"format\" is not");
  expect_complaint(R"({"format": "lamella.session.v1"})", "has no \"rig\"");
  expect_complaint(changed("\"leds\"", "\"lamps\""), "has no rig.leds");
  expect_complaint(changed("{\"direction\": [0, 1, 0]}", ""), "has no rig.leds");
  expect_complaint(changed("\"projector\"", "\"beamer\""), "has no rig.projector");
  expect_complaint(changed("\"height\"", "\"depth\""),
                   "line 4: the left camera has no width or height");
  expect_complaint(changed(": 160", ": 160.5"), "line 4: the left camera has no width or height");
  expect_complaint(changed("\"rig\"", "\"frames\": [{}], \"rig\""), "has frames: it is a session");
}

TEST(Calibration, HasTwoCamerasOfTheNamesThatARigsHave) {
  const char* says = "rig.cameras are not two, with the id \"left\" and \"right\"";
  expect_complaint(changed("\"right\"", "\"left\""), says);
  expect_complaint(changed("\"right\"", "\"centre\""), says);
  expect_complaint(changed("\"cameras\": [", "\"cameras\": [{\"id\": \"left\"}, "), says);
  expect_complaint(changed("\"cameras\"", "\"lenses\""), says);
}

TEST(JsonScan, TellsEveryValueWithItsPath) {
  EXPECT_EQ(scanned(R"({"a": [1, {"b": "x\"y"}], "c": {"d": true, "e": null}, "f": -1.5e+3})"),
            "={ a=[ a[0]=1 a[1]={ a[1].b=x\\\"y c={ c.d=true c.e=null f=-1.5e+3 ");
  EXPECT_EQ(scanned(" [ ] \n"), "=[ ");
  EXPECT_EQ(scanned("\"\xC3\xA4\""), "=\xC3\xA4 ");
}

TEST(JsonScan, APathThatIsTooLongOrCouldBeMistakenForAnotherHasNoName) {
  EXPECT_EQ(scanned(R"({"a.b": 1, "a": {"c[0]": {"d": 2}}, "": 3})"), "={ ?=1 a={ ?={ ?=2 ?=3 ");
  const std::string name(70, 'n');
  EXPECT_EQ(scanned("{\"" + name + "\": [1], \"b\": 2}"), "={ ?=[ ?=1 b=2 ");
}

TEST(JsonScan, RefusesWhatAlmostIsJson) {
  for (const char* wrong : {"",
                            "{",
                            "[1,]",
                            "{\"a\": 1,}",
                            "{a: 1}",
                            "{\"a\" 1}",
                            "[1 2]",
                            "01",
                            "-",
                            "1.",
                            ".5",
                            "1e",
                            "0x10",
                            "+1",
                            "NaN",
                            "Infinity",
                            "tru",
                            "truely",
                            "\"a",
                            "\"a\nb\"",
                            "\"\\x\"",
                            "\"\\u12g4\"",
                            "\"\xC3\"",
                            "\"\xC0\x80\"",
                            "\"\xED\xA0\x80\"",
                            "\"\xFF\"",
                            "\"\xF7\xBF\xBF\xBF\"",
                            "1 2",
                            "{} {}",
                            "'a'"}) {
    EXPECT_NE(scanned(wrong).find('!'), std::string::npos) << wrong;
  }
  EXPECT_EQ(scanned("[\n1,\n?]"), "=[ [0]=1 !3 no value begins here");
  EXPECT_NE(scanned(std::string(100000, '[')).find("nested deeper"), std::string::npos);
}
