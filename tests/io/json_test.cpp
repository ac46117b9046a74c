#include "io/json.h"

#include <cmath>

#include "io/expect_error.h"
#include "layers.pb.h"
#include "session.pb.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;

std::string session_complaint(const std::string& text) {
  v1::Session session;
  return complaint([&] { parse_json(text, "session.json", &session); });
}

TEST(Json, ListsUnknownFieldsWithTheirPlace) {
  v1::Session session;
  const auto unknown =
      parse_json(R"({"colour": 1, "rig": {"leds": [{}, {"hue": 2}]}, "frames": [{"step": 3}]})",
                 "session.json", &session);
  EXPECT_EQ(unknown, (std::vector<std::string>{"colour", "rig.leds[1].hue"}));
  EXPECT_EQ(session.frames(0).step(), 3u);
}

TEST(Json, NamesTheFieldOfAWrongType) {
  EXPECT_TRUE(names(session_complaint(R"({"frames": [{}, {"exposure_us": "long"}]})"),
                    {"session.json: frames[1].exposure_us", "\"long\"", "a number"}));
  EXPECT_TRUE(names(session_complaint(R"({"frames": {"step": 1}})"), {"frames", "a list"}));
  EXPECT_TRUE(names(session_complaint(R"({"rig": [1]})"), {"session.json: rig", "an object"}));
  EXPECT_TRUE(names(session_complaint(R"({"subject": 7})"), {"subject", "a text"}));
  EXPECT_TRUE(names(session_complaint(R"({"rig": {"leds": [{"direction": [0, "up", 1]}]}})"),
                    {"rig.leds[0].direction[1]", "a number"}));
}

TEST(Json, NamesTheFieldOfANumberThatDoesNotFit) {
  for (const char* width : {"-3", "2.5", "1e12", "\"512\""}) {
    const std::string text = R"({"rig": {"cameras": [{"width": )" + std::string(width) + "}]}}";
    EXPECT_TRUE(names(session_complaint(text), {"rig.cameras[0].width"})) << width;
  }
}

TEST(Json, NamesTheFieldOfAnUnknownEnumValueAndWhatItMayBe) {
  EXPECT_TRUE(names(session_complaint(R"({"frames": [{"role": "STRIPE"}]})"),
                    {"frames[0].role", "STRIPE", "STRIPES"}));
}

TEST(Json, RefusesNumbersThatAreNotFiniteUnlessTheyAreAllowed) {
  EXPECT_TRUE(
      names(session_complaint(R"({"frames": [{"trigger_us": "NaN"}]})"), {"frames[0].trigger_us"}));
  EXPECT_TRUE(names(session_complaint(R"({"frames": [{"trigger_us": NaN}]})"), {"not JSON"}));
  EXPECT_TRUE(names(session_complaint(R"({"frames": [{"trigger_us": 1e999}]})"), {"not JSON"}));
  v1::Layers layers;
  parse_json(R"({"ior": "NaN"})", "layers.json", &layers, NonFinite::kAllowed);
  EXPECT_TRUE(std::isnan(layers.ior()));
}

TEST(Json, TellsWhereTextStopsBeingJson) {
  EXPECT_TRUE(names(session_complaint("this is no manifest"), {"session.json", "not JSON"}));
  EXPECT_TRUE(names(session_complaint(""), {"not JSON"}));
  EXPECT_TRUE(names(session_complaint("[]"), {"an object"}));
  EXPECT_TRUE(names(session_complaint("{\"subject\": \"\xff\xfe\"}"), {"not JSON"}));
}

TEST(Json, ShortensWhatItQuotes) {
  const std::string text = R"({"rig": ")" + std::string(100000, 'x') + "\"}";
  EXPECT_LT(session_complaint(text).size(), 200u);
}

TEST(Json, TakesNullForAFieldLeftOut) {
  EXPECT_EQ(session_complaint(R"({"rig": null, "frames": [{"index": null}]})"), "");
}

TEST(Json, KeepsEveryFieldOnTheWayOutAndBack) {
  v1::Layers layers;
  layers.set_format("lamella.layers.v1");
  (*layers.mutable_timings_s())["geometry"] = 0.25;
  layers.add_regions()->set_name("forehead");
  layers.mutable_regions(0)->mutable_deep()->add_ld_mm(1.0 / 3);
  v1::Layers back;
  EXPECT_TRUE(parse_json(to_json(layers), "layers.json", &back).empty());
  EXPECT_EQ(back.SerializeAsString(), layers.SerializeAsString());
}

TEST(Json, WritesDefaultsWhenAskedTo) {
  v1::Frame frame;
  EXPECT_EQ(to_json(frame).find("trigger_us"), std::string::npos);
  EXPECT_NE(to_json(frame, Defaults::kWritten).find("trigger_us"), std::string::npos);
}

// protobuf's own order of a map is another one in every run.
TEST(Json, HasTheEntriesOfAMapByTheirKeysInWhateverOrderTheyCame) {
  v1::Layers layers;
  for (const char* step : {"single", "deep", "albedo", "total", "normals", "geometry", "specular",
                           "shallow", "read", "regions", "report", "bled_light"}) {
    (*layers.mutable_timings_s())[step] = 1.5;
  }
  for (const Defaults defaults : {Defaults::kLeftOut, Defaults::kWritten}) {
    const std::string text = to_json(layers, defaults);
    size_t last = text.find("timings_s");
    for (const char* step : {"albedo", "bled_light", "deep", "geometry", "normals", "read",
                             "regions", "report", "shallow", "single", "specular", "total"}) {
      const size_t at = text.find("\"" + std::string(step) + "\": 1.5");
      ASSERT_NE(at, std::string::npos) << step;
      EXPECT_LT(last, at) << text;
      last = at;
    }
  }
}

TEST(Json, MayBeginWithAByteOrderMark) {
  v1::Session parsed;
  parse_json("\xef\xbb\xbf{\"subject\": \"ada\"}", "session.json", &parsed);
  EXPECT_EQ(parsed.subject(), "ada");
}

}  // namespace
}  // namespace lamella
