#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "test_rig.h"

extern "C" {
#include "pattern.h"
}

namespace {

using Pixels = std::vector<uint32_t>;
constexpr uint32_t kUntouched = 0xdeadbeef;

Pixels drawn(const struct rig& rig, struct hal_pattern pattern, size_t stride_px) {
  Pixels pixels(stride_px * static_cast<size_t>(rig.projector_height_px), kUntouched);
  pattern_draw(&rig, pattern_image(pattern), pixels.data(), stride_px);
  return pixels;
}

Pixels drawn(lamella_v1_PatternSpan_Kind kind, uint8_t index = 0) {
  return drawn(test_rig(), {kind, index}, 1280);
}

int channel(uint32_t pixel, int c) { return pixel >> (16 - 8 * c) & 255; }

std::string refusal_of(double rig::*number, double value) {
  struct rig rig = test_rig();
  rig.*number = value;
  char error[160] = "";
  EXPECT_FALSE(pattern_can_be_drawn(&rig, error));
  return error;
}

}  // namespace

TEST(Pattern, EveryImageIsOfOnePatternWithANameOfItsOwn) {
  std::set<std::string> names;
  for (size_t image = 0; image < PATTERN_IMAGES; image++) {
    char name[16];
    pattern_name(pattern_of_image(image), name);
    EXPECT_EQ(pattern_image(pattern_of_image(image)), image) << name;
    names.insert(name);
  }
  EXPECT_EQ(names.size(), size_t(PATTERN_IMAGES));
  EXPECT_TRUE(names.count("fringe 3") && names.count("stripes 0") && names.count("dots"));
}

TEST(Pattern, ThatIsNotThereHasNoImage) {
  EXPECT_EQ(pattern_image({lamella_v1_PatternSpan_Kind_FRINGE, 4}), size_t(PATTERN_IMAGES));
  EXPECT_EQ(pattern_image({lamella_v1_PatternSpan_Kind_STRIPES, 4}), size_t(PATTERN_IMAGES));
  EXPECT_EQ(pattern_image({lamella_v1_PatternSpan_Kind_KIND_UNSPECIFIED, 0}),
            size_t(PATTERN_IMAGES));
  char name[16];
  pattern_name({static_cast<lamella_v1_PatternSpan_Kind>(77), 0}, name);
  EXPECT_STREQ(name, "kind 77");
}

TEST(Pattern, BlackAndDarkAreCodeZeroAndWhiteIsCode255OfTheFullRange) {
  for (uint32_t pixel : drawn(lamella_v1_PatternSpan_Kind_BLACK)) ASSERT_EQ(pixel, 0u);
  for (uint32_t pixel : drawn(lamella_v1_PatternSpan_Kind_DARK)) ASSERT_EQ(pixel, 0u);
  for (uint32_t pixel : drawn(lamella_v1_PatternSpan_Kind_WHITE)) ASSERT_EQ(pixel, 0xffffffu);
}

TEST(Pattern, StripesAreWhiteInTheFirstHalfOfEachPeriodAndMoveByTheShift) {
  for (uint8_t index = 0; index < PATTERN_STRIPES; index++) {
    const Pixels stripes = drawn(lamella_v1_PatternSpan_Kind_STRIPES, index);
    for (size_t i = 0; i < stripes.size(); i++) {
      const size_t u = i % 1280;
      ASSERT_EQ(stripes[i], (u + 8 - 2 * index) % 8 < 4 ? 0xffffffu : 0u) << u;
    }
  }
}

TEST(Pattern, StripesThatMoveHalfAPixelAreHalfTheLightThere) {
  struct rig rig = test_rig();
  rig.pattern_stripe_shift_px = 0.5;
  const Pixels stripes = drawn(rig, {lamella_v1_PatternSpan_Kind_STRIPES, 1}, 1280);
  const auto half = static_cast<uint32_t>(std::lround(255 * std::pow(0.5, 1 / 2.2)));
  EXPECT_EQ(stripes[0], half << 16 | half << 8 | half);
  EXPECT_EQ(stripes[1], 0xffffffu);
  EXPECT_EQ(stripes[4], stripes[0]);
  EXPECT_EQ(stripes[5], 0u);
}

TEST(Pattern, FringesAreCosinesInLightAThirdOfAPeriodApartByColour) {
  for (uint8_t index = 0; index < PATTERN_FRINGES; index++) {
    const Pixels fringe = drawn(lamella_v1_PatternSpan_Kind_FRINGE, index);
    for (size_t u = 0; u < 1280; u++) {
      for (int c = 0; c < 3; c++) {
        const double phase = 2 * M_PI * (std::pow(4, index) * u / 1280 + (c - 1) / 3.0);
        const double code = 255 * std::pow(0.5 + 0.5 * std::cos(phase), 1 / 2.2);
        ASSERT_NEAR(channel(fringe[u], c), code, 0.5 + 1e-6) << u;
        ASSERT_EQ(fringe[799 * 1280 + u], fringe[u]);
      }
    }
  }
}

TEST(Pattern, DotsAreBlackDiscsOfTheirDiameterOnWhite) {
  const Pixels dots = drawn(lamella_v1_PatternSpan_Kind_DOTS);
  size_t rim = 0;
  for (size_t i = 0; i < dots.size(); i++) {
    const double du = i % 1280 - 640.0, dv = i / 1280 - 400.0;
    const double from_centre =
        std::hypot(du - 53.33 * std::round(du / 53.33), dv - 53.33 * std::round(dv / 53.33));
    if (from_centre < 9.4) {
      ASSERT_EQ(dots[i], 0u) << i;
    }
    if (from_centre > 10.6) {
      ASSERT_EQ(dots[i], 0xffffffu) << i;
    }
    rim += dots[i] != 0 && dots[i] != 0xffffff;
  }
  EXPECT_GT(rim, 300u * 50);  // 24 x 15 discs, each with a rim of some 60 pixels
}

TEST(Pattern, DotsTakeTheAreaOfTheirDiscs) {
  const Pixels dots = drawn(lamella_v1_PatternSpan_Kind_DOTS);
  double black_px = 0;
  for (size_t v = 400 - 26; v <= 400 + 26; v++) {
    for (size_t u = 640 - 26; u <= 640 + 26; u++) {
      black_px += 1 - std::pow((dots[v * 1280 + u] & 255) / 255.0, 2.2);
    }
  }
  EXPECT_NEAR(black_px, M_PI * 100, 1.5);
}

TEST(Pattern, LeavesWhatLiesBetweenTheRowsAlone) {
  struct rig rig = test_rig();
  rig.projector_width_px = 1279;
  rig.projector_height_px = 33;
  for (size_t image = 0; image < PATTERN_IMAGES; image++) {
    const Pixels pixels = drawn(rig, pattern_of_image(image), 1280);
    for (size_t v = 0; v < 33; v++) ASSERT_EQ(pixels[v * 1280 + 1279], kUntouched);
    for (size_t u = 0; u < 1279; u++) ASSERT_EQ(pixels[32 * 1280 + u] >> 24, 0u);
  }
}

TEST(Pattern, ThatNoProjectorCanDrawIsRefusedByItsKey) {
  EXPECT_EQ(refusal_of(&rig::pattern_stripe_shift_px, 4.5),
            "'pattern.stripe_shift_px' is 4.5; it must be at most half of "
            "'pattern.stripe_period_px'");
  EXPECT_EQ(refusal_of(&rig::pattern_dot_diameter_px, 50),
            "'pattern.dot_diameter_px' is 50; it must be at most 0.9 of 'pattern.dot_pitch_px'");
  EXPECT_EQ(refusal_of(&rig::projector_width_px, 100),
            "'pattern.fringe_3_periods' is 64; it must be at most half of 'projector.width_px'");
  EXPECT_EQ(refusal_of(&rig::projector_height_px, 800.5),
            "'projector.width_px' and 'projector.height_px' must be whole numbers");
  struct rig rig = test_rig();
  rig.pattern_fringe_periods[2] = 4;
  char error[160];
  EXPECT_FALSE(pattern_can_be_drawn(&rig, error));
  EXPECT_STREQ(error,
               "'pattern.fringe_2_periods' is 4; it must be more than the fringe before has");
}

TEST(Pattern, OfEveryRigFileThatShipsIsTheSame) {
  for (const char* name : {"slr", "machine_vision", "vm"}) {
    const struct rig rig = test_rig(name);
    for (size_t image = 0; image < PATTERN_IMAGES; image++) {
      ASSERT_EQ(drawn(rig, pattern_of_image(image), 1280),
                drawn(test_rig(), pattern_of_image(image), 1280))
          << name;
    }
  }
}
