// calibration.json: what the daemon takes, and what it says of all else.
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>
#include <vector>

#include "test_calibration.h"
#include "test_rig.h"

extern "C" {
#include "calibration.h"
#include "json_scan.h"
}

namespace {

const struct rig& vm() {
  static const struct rig rig = test_rig("vm");
  return rig;
}

std::string vm_calibration(int width = 160, int height = 120) {
  return calibration_text(width, height, "", "vm");
}

// "" where it is taken. Of which cameras nothing is known, they may have any size.
std::string complaint(const std::string& text, const rig_camera* own = nullptr) {
  char why[CALIBRATION_WHY_CHARS] = "";
  const bool good = calibration_check(text.data(), text.size(), &vm(), own, why);
  EXPECT_EQ(good, why[0] == '\0') << why;
  EXPECT_EQ(std::string(why).find('\n'), std::string::npos) << why;
  return why;
}

std::string changed(const std::string& from, const std::string& to) {
  std::string text = vm_calibration();
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
  EXPECT_EQ(complaint(vm_calibration(), &vm().sensor), "");
  EXPECT_EQ(complaint("\xEF\xBB\xBF" + vm_calibration(), &vm().sensor), "");
  EXPECT_EQ(complaint(vm_calibration(600, 750)), "");
  EXPECT_EQ(complaint(changed(R"("width": 160)", R"("width": 1.6e2)"), &vm().sensor), "");
}

TEST(Calibration, OfAnotherSizeThanTheRigFilesIsRefusedWithBothSizesAndTheLine) {
  expect_complaint(vm_calibration(600, 750),
                   "line 5: the left camera has 600 x 750 pixels, the rig file's (camera.width_px, "
                   "camera.height_px) 160 x 120: make both say what is there",
                   &vm().sensor);
  std::string one = vm_calibration();
  one.replace(one.rfind("\"height\": 120"), 13, "\"height\": 121");
  expect_complaint(one, "line 6: the right camera has 160 x 121 pixels", &vm().sensor);
  std::string projector = vm_calibration();
  projector.replace(projector.rfind("\"height\": "), 10, "\"height\": 1");
  expect_complaint(projector, "line 7: the projector has ");
  expect_complaint(projector, "the rig file's (projector.width_px, projector.height_px)");
}

TEST(Calibration, ThatIsNoJsonIsRefusedWithTheLine) {
  expect_complaint("", "is empty");
  expect_complaint(rig_file_text(), "line 1: not JSON: no value begins here");
  expect_complaint("[]", "line 1: the whole is not an object");
  expect_complaint("null", "line 1: the whole is not an object");
  const std::string whole = vm_calibration();
  for (size_t length = 1; length < whole.size() - 1; length += length % 97 + 1) {
    expect_complaint(whole.substr(0, length), "not JSON");
  }
  expect_complaint(whole + "}", "line 9: not JSON: something comes after its end");
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
  expect_complaint(changed("\"projector\"", "\"beamer\""), "has no rig.projector");
  expect_complaint(changed("\"height\"", "\"depth\""), "line 5: the left camera has no height");
  expect_complaint(changed("\"patterns\"", "\"pictures\""),
                   "\"patterns\" has no fringe.periods: make both say what is there");
  expect_complaint(changed("\"rig\"", "\"frames\": [{}], \"rig\""),
                   "line 2: has frames: it is a session");
  expect_complaint(changed("\"rig\"", "\"retaken\": [{}], \"rig\""), "line 2: has frames");
}

TEST(Calibration, HasTwoCamerasOfTheNamesThatARigsHave) {
  const char* says = "rig.cameras are not two, with the id \"left\" and \"right\"";
  expect_complaint(changed("\"right\"", "\"left\""), says);
  expect_complaint(changed("\"right\"", "\"centre\""), says);
  expect_complaint(changed("\"cameras\": [", "\"cameras\": [{\"id\": \"left\"}, "), says);
  expect_complaint(changed("\"cameras\"", "\"lenses\""), says);
}

TEST(Calibration, ANumberThatNoCameraHasIsRefusedByItsNameAndLine) {
  const std::vector<std::array<std::string, 3>> wrong = {
      {R"("fx": 500)", R"("fx": 0)",
       "line 5: rig.cameras[0].fx is 0: it must be a positive number of at most 1e9"},
      {R"("fx": 500)", R"("fx": -1e3)", "rig.cameras[0].fx is -1000: it must be a positive number"},
      {R"("fx": 500)", R"("fx": 2e9)",
       "rig.cameras[0].fx is 2000000000: it must be a positive number of at most 1e9"},
      {R"("fx": 500)", R"("fx": "NaN")", "line 5: rig.cameras[0].fx is no number"},
      {R"("fx": 500)", R"("fx": [500])", "rig.cameras[0].fx is no number"},
      {R"("fx": 500, )", "", "line 5: the left camera has no fx"},
      {R"("fx": 500)", R"("fx": null)", "line 5: the left camera has no fx"},
      {R"("fx": 500)", R"("fx": 500, "fx": 500)", "rig.cameras[0].fx is given twice"},
      {R"("fx": 500)", R"("fx": 1e999)", "line 5: a number that is too long or too large"},
      {R"("fx": 500)", R"("fx": 500, "distortion": [0, 0])",
       "has 2 numbers of its distortion, not 5"},
      {R"("fx": 500)", R"("fx": 500, "distortion": 0)", "distortion is no list of 5 numbers"},
      {R"("fx": 500)", R"("fx": 500, "extinction": 0.6)", "a share from 0 to 0.5"},
      {R"("fx": 500)", R"("fx": 500, "readNoise": -1)",
       "readNoise is -1: it must be a number that"},
      {R"("width": 160)", R"("width": 160.5)", "has 160.5 x 120 pixels: give whole ones"},
      {R"("width": 160)", R"("width": 32769)", "width is 32769: it must be 1 to 32768 pixels"},
      {R"([1, 0, 0, 0, -1)", R"([1, 0, 0, 0, 1)", "the left camera has a rotation that is none"},
      {R"([1, 0, 0, 0, -1)", R"([1, 0, 0, -1)", "has 8 numbers of its rotation, not 9"},
      {R"([1, 0, 0, 0, -1)", R"([1, 0, 0, 0, 0, -1)",
       "rotation[9] is one number too many: they are 9"}};
  for (const auto& [from, to, says] : wrong) expect_complaint(changed(from, to), says);
  EXPECT_EQ(complaint(changed(R"("fx": 500)", R"("fx": 500, "read_noise": null, "lens": [1])")),
            "");
  EXPECT_EQ(complaint(changed("translation_mm", "translationMm")), "");
}

TEST(Calibration, WhatIsGivenTwiceIsRefused) {
  const std::vector<std::pair<std::string, std::string>> twice = {
      {R"("rig")", R"("rig": {}, "rig")"},
      {R"("patterns")", R"("patterns": {}, "patterns")"},
      {R"("stripes")", R"("stripes": {}, "stripes")"},
      {R"("subject")", R"("subject": "a", "subject")"},
      {R"("projector")", R"("projector": {}, "projector")"},
      {R"({"id": "left")", R"({"id": "foo", "id": "left")"},
      {R"({"id": "left")", R"({"id": "left", "id": "foo")"}};
  for (const auto& [from, to] : twice) expect_complaint(changed(from, to), "is given twice");
}

TEST(Calibration, AListThatIsEmptyIsLeftOut) {
  for (const std::string empty : {R"("distortion": [])", R"("distortion": null)"}) {
    EXPECT_EQ(complaint(changed(R"("fx": 500)", R"("fx": 500, )" + empty)), "");
  }
  EXPECT_EQ(complaint(changed("\"rig\": {", "\"rig\": {\"projector_to_led\": [],")), "");
  EXPECT_EQ(complaint(changed("\"leds\": [{", "\"leds\": [{\"intensity\": [], ")), "");
  expect_complaint(changed("[100, 0, 700]", "[]"), "has 0 numbers of its translation_mm, not 3");
}

TEST(Calibration, WhatItDoesNotKnowMayBeLongAndDeep) {
  const std::string deep = std::string(40, '[') + std::string(40, ']');
  EXPECT_EQ(complaint(changed("\"rig\"", "\"lens\": " + deep + ", \"rig\"")), "");
  EXPECT_EQ(complaint(changed("\"rig\"", "\"pi\": 3." + std::string(300, '1') + ", \"rig\"")), "");
}

TEST(Calibration, OfOtherLedsThanTheRigFilesIsRefused) {
  std::string fewer = vm_calibration();
  const size_t second = fewer.find(", {\"direction\"");
  fewer.erase(second, fewer.find('}', second) + 1 - second);
  expect_complaint(fewer, "shines from ");
  const size_t last = vm_calibration().rfind(", {\"direction\"");
  std::string without_last = vm_calibration();
  without_last.erase(last, without_last.find('}', last) + 1 - last);
  expect_complaint(
      without_last,
      "rig.leds are 149, the rig file's (dome150.leds) 150: make both say what is there");
  expect_complaint(changed("\"leds\": [", "\"leds\": [{\"direction\": [0, 0, 0]}, "),
                   "line 3: rig.leds[0] has a direction whose length is not 1");
  expect_complaint(changed("\"leds\": [", "\"leds\": [{\"direction\": [0, 1]}, "),
                   "line 3: rig.leds[0] has 2 numbers of its direction, not 3");
}

TEST(Calibration, OfOtherPatternsThanTheProjectorShowsIsRefused) {
  expect_complaint(
      changed("\"period_px\": 8", "\"period_px\": 9"),
      "\"patterns\" has 9 of its stripes.period_px where the rig file (pattern.*) has 8");
  expect_complaint(changed("\"periods\": [1,", "\"periods\": [1, 2,"),
                   "fringe.periods[4] is one number");
  expect_complaint(changed("\"offset_px\": [", "\"offset_px\": [1, "),
                   "dots.offset_px[2] is one number");
}

TEST(Calibration, ColoursThatCannotBeUndoneAreRefused) {
  const auto colours = [](const std::string& matrix) {
    return changed("\"rig\": {", "\"rig\": {\"projector_to_led\": [" + matrix + "],");
  };
  EXPECT_EQ(complaint(colours("1, 0.1, 0, 0, 0.9, 0, 0, 0.2, 1.1")), "");
  expect_complaint(colours("1, 0, 0, 0, 1, 0, 1, 1, 0"),
                   "projector_to_led that cannot be inverted");
  expect_complaint(colours("-1, 0, 0, 0, 1, 0, 0, 0, 1"), "turns white light black");
  expect_complaint(colours("1, 0, 0, 0, 1, 0, 0, 0"), "rig has 8 numbers of its projector_to_led");
}

TEST(JsonScan, TellsEveryValueWithItsPath) {
  EXPECT_EQ(scanned(R"({"a": [1, {"b": "x\"y"}], "c": {"d": true, "e": null}, "f": -1.5e+3})"),
            "={ a=[ a[0]=1 a[1]={ a[1].b=x\\\"y c={ c.d=true c.e=null f=-1.5e+3 ");
  EXPECT_EQ(scanned(" [ ] \n"), "=[ ");
  EXPECT_EQ(scanned("\"\xC3\xA4\""), "=\xC3\xA4 ");
  EXPECT_EQ(scanned(R"("\u00e4\ud83d\ude00\n")"), R"(=\u00e4\ud83d\ude00\n )");
}

TEST(JsonScan, APathThatIsTooLongOrCouldBeMistakenForAnotherHasNoName) {
  EXPECT_EQ(scanned(R"({"a.b": 1, "a": {"c[0]": {"d": 2}}})"), "={ ?=1 a={ ?={ ?=2 ");
  const std::string name(70, 'n');
  EXPECT_EQ(scanned("{\"" + name + "\": [1], \"b\": 2}"), "={ ?=[ ?=1 b=2 ");
}

TEST(JsonScan, ANameMayHideNoLetterAndIsNotEmpty) {
  EXPECT_EQ(scanned(R"({"r\u0069g": 1})"), "={ !1 a name with a letter written as \\u00..");
  EXPECT_EQ(scanned(R"({"": 1})"), "={ !1 a name that is empty");
  EXPECT_EQ(scanned(R"({"\u00e4": "\u0061"})"), R"(={ ?=\u0061 )");
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
                            "\"\\ud83d\"",
                            "\"\\ude00\"",
                            "\"\\ud83dx\"",
                            "\"\\ud83d\\u0041\"",
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
