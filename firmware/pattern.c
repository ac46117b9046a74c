#include "pattern.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define KIND(name) lamella_v1_PatternSpan_Kind_##name
enum { kBlack, kWhite, kDots, kFringes, kStripes = kFringes + PATTERN_FRINGES };
enum { kSamples = 4 };  // of a pixel at a dot's rim, along each side
static const double kMostCode = 255;
static const double kTwoPi = 6.283185307179586;

size_t pattern_image(struct hal_pattern pattern) {
  switch (pattern.kind) {
    case KIND(DARK):
    case KIND(BLACK):
      return kBlack;
    case KIND(WHITE):
      return kWhite;
    case KIND(DOTS):
      return kDots;
    case KIND(FRINGE):
      return pattern.index < PATTERN_FRINGES ? kFringes + pattern.index : PATTERN_IMAGES;
    case KIND(STRIPES):
      return pattern.index < PATTERN_STRIPES ? kStripes + pattern.index : PATTERN_IMAGES;
    default:
      return PATTERN_IMAGES;
  }
}

struct hal_pattern pattern_of_image(size_t image) {
  if (image >= kStripes) return (struct hal_pattern){KIND(STRIPES), (uint8_t)(image - kStripes)};
  if (image >= kFringes) return (struct hal_pattern){KIND(FRINGE), (uint8_t)(image - kFringes)};
  static const lamella_v1_PatternSpan_Kind kKinds[] = {
      [kBlack] = KIND(BLACK), [kWhite] = KIND(WHITE), [kDots] = KIND(DOTS)};
  return (struct hal_pattern){kKinds[image], 0};
}

void pattern_name(struct hal_pattern pattern, char name[16]) {
  static const char* const kNames[] = {[KIND(DARK)] = "dark",       [KIND(BLACK)] = "black",
                                       [KIND(WHITE)] = "white",     [KIND(FRINGE)] = "fringe",
                                       [KIND(STRIPES)] = "stripes", [KIND(DOTS)] = "dots"};
  const size_t kind = (size_t)pattern.kind;
  const char* known = kind < sizeof kNames / sizeof kNames[0] ? kNames[kind] : NULL;
  const bool indexed = pattern.kind == KIND(FRINGE) || pattern.kind == KIND(STRIPES);
  if (known == NULL) {
    snprintf(name, 16, "kind %u", (unsigned)pattern.kind % 1000);
  } else if (indexed) {
    snprintf(name, 16, "%s %u", known, pattern.index);
  } else {
    snprintf(name, 16, "%s", known);
  }
}

// The code whose light is `value` of white's, above black's.
static uint32_t code_of(const struct rig* rig, double value) {
  const double within = value < 0 ? 0 : value > 1 ? 1 : value;
  return (uint32_t)lround(kMostCode * pow(within, 1 / rig->projector_gamma));
}

static uint32_t grey(uint32_t code) { return code << 16 | code << 8 | code; }

static void draw_fringe_row(const struct rig* rig, double periods, uint32_t* row) {
  for (size_t u = 0; u < (size_t)rig->projector_width_px; u++) {
    const double turns = periods * (double)u / rig->projector_width_px;
    row[u] = 0;
    for (int channel = 0; channel < 3; channel++) {
      const double value = 0.5 + 0.5 * cos(kTwoPi * (turns + (channel - 1) / 3.0));
      row[u] = row[u] << 8 | code_of(rig, value);
    }
  }
}

static double lit(const struct rig* rig, double at_px) {
  const double period_px = rig->pattern_stripe_period_px;
  const double within_px = at_px - period_px * floor(at_px / period_px);
  return floor(within_px) < period_px / 2;
}

// A shift by part of a pixel mixes two neighbours.
static void draw_stripe_row(const struct rig* rig, double shift_px, uint32_t* row) {
  const double whole_px = floor(shift_px), part = shift_px - whole_px;
  for (size_t u = 0; u < (size_t)rig->projector_width_px; u++) {
    const double at_px = (double)u - whole_px;
    row[u] = grey(code_of(rig, (1 - part) * lit(rig, at_px) + part * lit(rig, at_px - 1)));
  }
}

// How many of a pixel's samples lie outside the disc whose centre is (u, v) away.
static unsigned samples_outside(double u, double v, double radius_px) {
  const double square = u * u + v * v;
  if (square > (radius_px + 1) * (radius_px + 1)) return kSamples * kSamples;
  unsigned outside = 0;
  for (unsigned i = 0; i < kSamples * kSamples; i++) {
    const double x = u + (i % kSamples - 0.5 * (kSamples - 1)) / kSamples;
    const double y = v + (i / kSamples - 0.5 * (kSamples - 1)) / kSamples;
    outside += x * x + y * y >= radius_px * radius_px;
  }
  return outside;
}

static double from_centre(const struct rig* rig, size_t at_px, double offset_px) {
  const double pitch_px = rig->pattern_dot_pitch_px, away_px = (double)at_px - offset_px;
  return away_px - pitch_px * round(away_px / pitch_px);
}

static void draw_dots(const struct rig* rig, uint32_t* pixels, size_t stride_px) {
  const size_t width = (size_t)rig->projector_width_px, height = (size_t)rig->projector_height_px;
  const double radius_px = 0.5 * rig->pattern_dot_diameter_px;
  uint32_t greys[kSamples * kSamples + 1];
  for (size_t i = 0; i <= kSamples * kSamples; i++) {
    greys[i] = grey(code_of(rig, (double)i / (kSamples * kSamples)));
  }
  double du_px[RIG_MOST_PROJECTOR_PX];
  for (size_t u = 0; u < width; u++) du_px[u] = from_centre(rig, u, rig->pattern_dot_offset_u_px);
  for (size_t v = 0; v < height; v++) {
    const double dv_px = from_centre(rig, v, rig->pattern_dot_offset_v_px);
    for (size_t u = 0; u < width; u++) {
      pixels[v * stride_px + u] = greys[samples_outside(du_px[u], dv_px, radius_px)];
    }
  }
}

void pattern_draw(const struct rig* rig, size_t image, uint32_t* pixels, size_t stride_px) {
  if (image == kDots) {
    draw_dots(rig, pixels, stride_px);
    return;
  }
  // In memory that is quick to write: a display's may not be quick to read.
  const size_t width = (size_t)rig->projector_width_px;
  uint32_t row[RIG_MOST_PROJECTOR_PX];
  if (image >= kStripes) {
    draw_stripe_row(rig, (double)(image - kStripes) * rig->pattern_stripe_shift_px, row);
  } else if (image >= kFringes) {
    draw_fringe_row(rig, rig->pattern_fringe_periods[image - kFringes], row);
  } else {
    for (size_t u = 0; u < width; u++) row[u] = image == kWhite ? grey(255) : 0;
  }
  for (size_t v = 0; v < (size_t)rig->projector_height_px; v++) {
    memcpy(pixels + v * stride_px, row, width * sizeof *row);
  }
}

void pattern_describe(const struct rig* rig, lamella_v1_Patterns* patterns) {
  *patterns = (lamella_v1_Patterns)lamella_v1_Patterns_init_zero;
  patterns->has_fringe = patterns->has_stripes = patterns->has_dots = true;
  patterns->fringe.periods_count = PATTERN_FRINGES;
  memcpy(patterns->fringe.periods, rig->pattern_fringe_periods, sizeof rig->pattern_fringe_periods);
  lamella_v1_StripePattern* stripes = &patterns->stripes;
  stripes->has_period_px = stripes->has_shift_px = true;
  stripes->period_px = rig->pattern_stripe_period_px;
  stripes->shift_px = rig->pattern_stripe_shift_px;
  lamella_v1_DotPattern* dots = &patterns->dots;
  dots->has_pitch_px = dots->has_diameter_px = true;
  dots->pitch_px = rig->pattern_dot_pitch_px;
  dots->diameter_px = rig->pattern_dot_diameter_px;
  dots->offset_px_count = 2;
  dots->offset_px[0] = rig->pattern_dot_offset_u_px;
  dots->offset_px[1] = rig->pattern_dot_offset_v_px;
}

static bool refuse(char error[160], const char* key, double value, const char* why) {
  snprintf(error, 160, "'%s' is %.10g; it must be %s", key, value, why);
  return false;
}

bool pattern_can_be_drawn(const struct rig* rig, char error[160]) {
  static const char* const kFringeKeys[PATTERN_FRINGES] = {
      "pattern.fringe_0_periods", "pattern.fringe_1_periods", "pattern.fringe_2_periods",
      "pattern.fringe_3_periods"};
  const double* periods = rig->pattern_fringe_periods;
  for (size_t i = 1; i < PATTERN_FRINGES; i++) {
    if (periods[i] > periods[i - 1]) continue;
    return refuse(error, kFringeKeys[i], periods[i], "more than the fringe before has");
  }
  if (periods[PATTERN_FRINGES - 1] > rig->projector_width_px / 2) {
    return refuse(error, kFringeKeys[PATTERN_FRINGES - 1], periods[PATTERN_FRINGES - 1],
                  "at most half of 'projector.width_px'");
  }
  if (rig->pattern_stripe_shift_px > rig->pattern_stripe_period_px / 2) {
    return refuse(error, "pattern.stripe_shift_px", rig->pattern_stripe_shift_px,
                  "at most half of 'pattern.stripe_period_px'");
  }
  if (rig->pattern_dot_diameter_px > 0.9 * rig->pattern_dot_pitch_px) {
    return refuse(error, "pattern.dot_diameter_px", rig->pattern_dot_diameter_px,
                  "at most 0.9 of 'pattern.dot_pitch_px'");
  }
  if (rig->projector_width_px == floor(rig->projector_width_px) &&
      rig->projector_height_px == floor(rig->projector_height_px)) {
    return true;
  }
  snprintf(error, 160, "'projector.width_px' and 'projector.height_px' must be whole numbers");
  return false;
}
