// A burst keeps the calibration that it was taken with: what the daemon takes, a host reads.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "firmware/test_calibration.h"
#include "io/json.h"
#include "io/session_rig.h"
#include "link/daemon_calibration.h"

namespace lamella {
namespace {

using nlohmann::json;

constexpr size_t kLeds = 2;

std::string complaint_of_host(const std::string& calibration) {
  Session session;
  try {
    calibration_from(calibration, "calibration", &session);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Every number, and all that it is in.
std::set<std::string> places_of(const json& calibration) {
  std::set<std::string> places;
  const json flat = calibration.flatten();
  for (const auto& [name, value] : flat.items()) {
    for (json::json_pointer place(name); !place.empty(); place.pop_back()) {
      places.insert(place.to_string());
    }
  }
  return places;
}

// What may stand there in place of what does.
std::vector<json> others_than(const json& value) {
  std::vector<json> others = {
      0,     -1,    1,       0.5,  1e9, 1.1e9, 1e300,         1e-300,
      40000, 160.5, nullptr, true, "x", "500", json::array(), json::object()};
  if (value.is_number()) others.push_back(value.get<double>() * 1.0005);
  if (value.is_array()) {
    others.push_back(value);
    others.back().push_back(value.front());
    others.push_back(value);
    others.back().erase(0);
  }
  return others;
}

void expect_agreement(const json& calibration, const std::string& place) {
  const std::string text = calibration.dump();
  if (!testing::complaint_of_daemon(text, kLeds).empty()) return;
  EXPECT_EQ(complaint_of_host(text), "")
      << place << ": " << calibration.value(json::json_pointer(place), json("gone")).dump();
}

TEST(CalibrationOfBoth, WhateverTheDaemonTakesAHostReads) {
  json whole = json::parse(calibration_text());
  json& leds = whole["rig"]["leds"];
  leds.erase(leds.begin() + kLeds, leds.end());
  whole["rig"]["cameras"][0].update({{"distortion", {0.1, 0, 0, 0, 0}},
                                     {"saturation", 1},
                                     {"read_noise", 1e-3},
                                     {"full_well_electrons", 1e4},
                                     {"extinction", 0.01}});
  leds[0].update({{"distance_mm", 900}, {"intensity", {1, 1, 1}}});
  whole["rig"]["projector_to_led"] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  whole["regions"] = {{"file", "regions.png"}, {"names", {"background", "nose"}}};
  ASSERT_EQ(testing::complaint_of_daemon(whole.dump(), kLeds), "");
  for (const std::string& place : places_of(whole)) {
    const json::json_pointer at(place);
    json spoilt = whole;
    for (const json& other : others_than(whole[at])) {
      spoilt[at] = other;
      expect_agreement(spoilt, place);
    }
    json& parent = spoilt[at.parent_pointer()];
    if (!parent.is_object()) continue;
    parent.erase(at.back());
    expect_agreement(spoilt, place);
  }
}

}  // namespace
}  // namespace lamella
