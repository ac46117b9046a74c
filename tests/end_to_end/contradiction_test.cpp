// A burst whose photographs, calibration or manifest contradict each other is fitted as smoothly as
// any other: the fit must say itself that its figures are not to be believed.
#include <algorithm>

#include "base/error.h"
#include "end_to_end/hard_case.h"

namespace lamella {
namespace {

std::vector<std::string> poor_lines(const fit::LayeredFit& fit) {
  std::vector<std::string> names;
  for (const CheckLine& line : fit.check.lines) {
    if (line.grade == Grade::kPoor) names.push_back(line.name);
  }
  return names;
}

void expect_says(const fit::LayeredFit& fit, const std::string& name) {
  const std::vector<std::string> names = poor_lines(fit);
  EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
}

TEST_F(HardCase, ABurstWithoutOneIsNotDoubted) {
  EXPECT_EQ(poor_lines(*whole), std::vector<std::string>{});
  const auto& figure = whole->layers.checks();
  EXPECT_GT(figure.at("position_answered"), 0.99);
  EXPECT_LT(figure.at("normals_off_surface_deg"), 2);
  EXPECT_LT(figure.at("stripe_misfit"), 0.02);
  EXPECT_GT(figure.at("stripe_coherence"), 0.98);
  EXPECT_EQ(figure.at("dots_dark"), 1);
  const Patterns patterns = read_session(scratch->path() / "session").patterns;
  EXPECT_NEAR(figure.at("dots_diameter_px"), patterns.dot_diameter_px,
              0.03 * patterns.dot_diameter_px);
  EXPECT_LT(figure.at("dots_off_px"), 0.04 * patterns.dot_diameter_px);
  for (const char* channel : {"red", "green", "blue"}) {
    EXPECT_NEAR(figure.at(std::string("between_dots_") + channel), 1, 0.02);
    EXPECT_NEAR(figure.at(std::string("rerender_front_cross_") + channel), 0, 0.01);
    EXPECT_NEAR(figure.at(std::string("rerender_front_parallel_") + channel), 0, 0.015);
  }
  EXPECT_LT(figure.at("faces_away_deg"), 20);
  EXPECT_EQ(figure.at("albedo_capped"), 0);
  EXPECT_GT(figure.at("right_camera_agrees"), 0.7);
  EXPECT_NEAR(figure.at("right_camera_apart_px"), 0, 0.03);
  EXPECT_NEAR(figure.at("gradients_over_full"), 0, 0.003);
  EXPECT_NEAR(figure.at("black_level_by_stripes"), figure.at("projector_black_level"), 5e-4);
}

TEST_F(HardCase, GradientsThatGotEachOthersNamesDisagreeWithTheSurface) {
  SpoiltSession session = spoilt();
  for (Json& frame : session.manifest["frames"]) {
    const bool is_x = session.is(frame, "GRADIENT_X");
    if (is_x || session.is(frame, "GRADIENT_Y")) frame["role"] = is_x ? "GRADIENT_Y" : "GRADIENT_X";
  }
  expect_says(session.fitted(fit::Step::kNormals), "normals against positions");
}

TEST_F(HardCase, ACameraOfAnotherFocalLengthKnowsTooFewPositions) {
  SpoiltSession session = spoilt();
  for (const char* focal : {"fx", "fy"}) {
    Json& camera = session.manifest["rig"]["cameras"][0];
    camera[focal] = 1.05 * double(camera[focal]);
  }
  expect_says(session.fitted(fit::Step::kGeometry), "positions");
}

TEST_F(HardCase, ACameraThatIsElsewhereAgreesWithNoOther) {
  SpoiltSession session = spoilt();
  Json& x_mm = session.manifest["rig"]["cameras"][0]["translation_mm"][0];
  x_mm = double(x_mm) + 5;
  expect_says(session.fitted(fit::Step::kGeometry), "right camera");
}

// Failure: l_d a tenth of what it is, without a word.
TEST_F(HardCase, ARigStatedInCentimetresHasASubjectThatIsTooSmall) {
  SpoiltSession session = spoilt();
  Json& rig = session.manifest["rig"];
  for (Json* view : {&rig["cameras"][0], &rig["cameras"][1], &rig["projector"]}) {
    for (Json& mm : (*view)["translation_mm"]) mm = double(mm) / 10;
  }
  expect_says(session.fitted(fit::Step::kGeometry), "size of the subject");
}

// Failure: within the tolerance of every point, and all points were off by the same.
TEST_F(HardCase, ACameraWhoseMiddleIsAThirdOfAPixelOffSeesEverythingAside) {
  SpoiltSession session = spoilt();
  Json& cx = session.manifest["rig"]["cameras"][0]["cx"];
  cx = double(cx) + 0.35;
  const fit::LayeredFit found = session.fitted(fit::Step::kGeometry);
  expect_says(found, "right camera");
  EXPECT_GT(found.layers.checks().at("right_camera_agrees"), 0.5);
}

// Failure: c was 40 % off, and the gradients were mended for what FULL had.
TEST_F(HardCase, AFullLightOfAnotherExposureDisagreesWithItsGradients) {
  SpoiltSession session = spoilt();
  session.change_photographs([&](Json& frame, Image3* image) {
    if (session.is(frame, "GRADIENT_FULL", "CROSS")) *image *= 1.05f;
  });
  const fit::LayeredFit found = session.fitted(fit::Step::kNormals);
  expect_says(found, "GRADIENT_FULL against the gradients");
  EXPECT_NEAR(found.layers.checks().at("gradients_over_full"), 1 / 1.05 - 1, 0.005);
}

// Failure: l_d was 9 to 24 % off.
TEST_F(HardCase, ABlackThatIsNoneDisagreesWithTheStripes) {
  SpoiltSession session = spoilt();
  session.change_photographs([&](Json& frame, Image3* image) {
    if (session.is(frame, "BLACK")) *image *= 0;
  });
  const fit::LayeredFit found = session.fitted(fit::Step::kSeparate);
  expect_says(found, "BLACK against STRIPES");
  EXPECT_NEAR(found.layers.checks().at("black_level_by_stripes"),
              whole->layers.checks().at("projector_black_level"), 5e-4);
}

TEST_F(HardCase, FringesInAnotherOrderAreRefusedForWhatTheyAre) {
  SpoiltSession session = spoilt();
  for (Json& frame : session.manifest["frames"]) {
    if (session.is(frame, "FRINGE")) frame["index"] = 3 - frame.value("index", 0);
  }
  try {
    session.fitted(fit::Step::kGeometry);
    ADD_FAILURE() << "fitted";
  } catch (const Error& error) {
    EXPECT_EQ(error.fault(), Fault::kBadInput);
    EXPECT_NE(std::string(error.what()).find("FRINGE"), std::string::npos) << error.what();
  }
}

TEST_F(HardCase, StripesInAnotherOrderAndDotsElsewhereDisagreeWithTheSurface) {
  SpoiltSession session = spoilt();
  for (Json& frame : session.manifest["frames"]) {
    if (session.is(frame, "STRIPES")) frame["index"] = 3 - frame.value("index", 0);
  }
  session.change_photographs([&](Json& frame, Image3* image) {
    if (frame["camera"] != "left" || !session.is(frame, "DOTS")) return;
    const Image3 still = image->clone();
    still(cv::Rect(0, 0, image->cols - 5, image->rows))
        .copyTo((*image)(cv::Rect(5, 0, image->cols - 5, image->rows)));
  });
  const fit::LayeredFit found = session.fitted(fit::Step::kScattering);
  expect_says(found, "stripes against the surface");
  expect_says(found, "dots against their pattern");
}

// Failure: l_d was half as long again.
TEST_F(HardCase, DotsThatAreNotAsStatedAreMeasured) {
  for (const double larger : {1.2, 0.85}) {
    SpoiltSession session = spoilt();
    Json& diameter_px = session.manifest["patterns"]["dots"]["diameter_px"];
    diameter_px = larger * double(diameter_px);
    expect_says(session.fitted(fit::Step::kScattering), "size and place of the dots");
  }
  SpoiltSession session = spoilt();
  Json& dots = session.manifest["patterns"]["dots"];
  dots["offset_px"][0] = double(dots["offset_px"][0]) + 0.2 * double(dots["diameter_px"]);
  expect_says(session.fitted(fit::Step::kScattering), "size and place of the dots");
}

TEST_F(HardCase, AStripeShiftThatIsNotThePhotographsIsSeen) {
  SpoiltSession session = spoilt();
  session.manifest["patterns"]["stripes"]["shift_px"] = 3;
  session.change_photographs([&](Json& frame, Image3* image) {
    if (frame["camera"] == "left" && session.is(frame, "DOTS")) *image *= 1.3f;
  });
  const fit::LayeredFit found = session.fitted(fit::Step::kScattering);
  expect_says(found, "stripes against their pattern");
  expect_says(found, "light between the dots");
}

TEST_F(HardCase, ExposuresOfTheLedsThatAreNotWhatTheManifestSaysDisagreeWithTheProjectors) {
  SpoiltSession session = spoilt();
  session.change_photographs([&](Json& frame, Image3* image) {
    if (std::string(frame["role"]).starts_with("GRADIENT")) *image *= 0.8f;
  });
  expect_says(session.fitted(), "FRONT crossed, drawn from the layers");
}

TEST_F(HardCase, ParallelPhotographsBrighterThanTheManifestSaysReflectMoreThanTheProjectors) {
  SpoiltSession session = spoilt();
  session.change_photographs([&](Json& frame, Image3* image) {
    const bool is_lit_by_leds = std::string(frame["role"]).starts_with("GRADIENT");
    if (is_lit_by_leds && frame["analyser"] == "PARALLEL") *image *= 1.15f;
  });
  expect_says(session.fitted(), "FRONT parallel, drawn from the layers");
}

// Failure: albedos of 1, without a word.
TEST_F(HardCase, PhotographsOfMoreLightThanThereWasAreSaidToBeCapped) {
  SpoiltSession session = spoilt();
  for (Json& frame : session.manifest["frames"]) {
    for (Json& scale : frame["radiance_scale"]) scale = 4 * double(scale);
  }
  expect_says(session.fitted(), "total albedo");
}

// Failure: albedos were off by what the lights facing +Z give more or less than those that lit it.
TEST_F(HardCase, ARigInAFrameThatTheSubjectDoesNotFaceIsSeen) {
  SpoiltSession session = spoilt();
  // The rig's Y is X now, Z is Y, and X is Z.
  Json& rig = session.manifest["rig"];
  const auto turn = [](Json* first) { std::rotate(first, first + 1, first + 3); };
  for (Json& led : rig["leds"]) turn(&led["direction"][0]);
  for (Json* view : {&rig["cameras"][0], &rig["cameras"][1], &rig["projector"]}) {
    for (size_t row = 0; row < 3; ++row) turn(&(*view)["rotation"][3 * row]);
  }
  const std::map<std::string, std::string> now{
      {"GRADIENT_X", "GRADIENT_Z"}, {"GRADIENT_Y", "GRADIENT_X"}, {"GRADIENT_Z", "GRADIENT_Y"}};
  for (Json& frame : session.manifest["frames"]) {
    const auto turned = now.find(frame["role"]);
    if (turned != now.end()) frame["role"] = turned->second;
  }
  const fit::LayeredFit found = session.fitted(fit::Step::kNormals);
  expect_says(found, "where the subject faces");
  EXPECT_GT(found.layers.checks().at("faces_away_deg"), 80);
}

}  // namespace
}  // namespace lamella
