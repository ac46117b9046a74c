#include "calibration_rules.h"

#include <float.h>
#include <math.h>

#define LARGEST 1e9    // of any number: its square is a finite float
#define SIDE_PX 32768  // of an image that a host reads
#define ANY -LARGEST, LARGEST, "a number of at most 1e9"
#define POSITIVE DBL_MIN, LARGEST, "a positive number of at most 1e9"
#define NOT_NEGATIVE 0, LARGEST, "a number that is not negative and at most 1e9"
#define SIZE 1, SIDE_PX, "1 to 32768 pixels"
#define COUNT_OF(fields) (sizeof(fields) / sizeof(fields)[0])

static const double kImage_px = 1 << 27;  // as a host: more are not read
static const double kRotationError = 1e-3;
static const double kUnitError = 0.9e-2;
static const double kFurthest_deg = 10;  // neighbours on a dome of 150 are 15 apart
static const double kRounding = 1e-9;    // JSON and the rig file write decimals
static const double kMostCondition = 1000;

static const struct field kCameraTable[] = {
    {"width", 0, true, SIZE},
    {"height", 0, true, SIZE},
    {"fx", 0, true, POSITIVE},
    {"fy", 0, true, POSITIVE},
    {"cx", 0, true, ANY},
    {"cy", 0, true, ANY},
    {"distortion", 5, false, ANY},
    {"rotation", 9, true, ANY},
    {"translation_mm", 3, true, ANY},
    {"saturation", 0, false, POSITIVE},
    {"read_noise", 0, false, NOT_NEGATIVE},
    {"full_well_electrons", 0, false, NOT_NEGATIVE},
    {"extinction", 0, false, 0, 0.5, "a share from 0 to 0.5"},
};
static const struct field kLedTable[] = {
    {"direction", 3, true, ANY},
    {"distance_mm", 0, false, POSITIVE},
    {"intensity", 3, false, NOT_NEGATIVE},
};
static const struct field kPatternTable[] = {
    {"fringe.periods", PATTERN_FRINGES, true, ANY},
    {"stripes.period_px", 0, true, ANY},
    {"stripes.shift_px", 0, true, ANY},
    {"dots.pitch_px", 0, true, ANY},
    {"dots.diameter_px", 0, true, ANY},
    {"dots.offset_px", 2, true, ANY},
};
static const struct field kRigTable[] = {{"projector_to_led", 9, false, ANY}};

const struct field_group kCameraFields = {kCameraTable, COUNT_OF(kCameraTable)};
const struct field_group kLedFields = {kLedTable, COUNT_OF(kLedTable)};
const struct field_group kPatternFields = {kPatternTable, COUNT_OF(kPatternTable)};
const struct field_group kRigFields = {kRigTable, COUNT_OF(kRigTable)};

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double product[3]) {
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    product[i] = a[j] * b[k] - a[k] * b[j];
  }
}

// Of a row-major matrix and its rows' cross products, which are the rows of its inverse times its
// determinant, transposed.
static double cofactors(const double m[9], double rows[9]) {
  cross(m + 3, m + 6, rows);
  cross(m + 6, m, rows + 3);
  cross(m, m + 3, rows + 6);
  return dot(m, rows);
}

static double norm(const double* values, int count) {
  double sum = 0;
  for (int i = 0; i < count; i++) sum += values[i] * values[i];
  return sqrt(sum);
}

static bool is_rotation(const double r[9]) {
  double errors[9], unused[9];
  for (int i = 0; i < 9; i++) errors[i] = dot(r + 3 * (i / 3), r + 3 * (i % 3)) - (i % 4 == 0);
  return norm(errors, 9) <= kRotationError && cofactors(r, unused) > 0;
}

bool camera_is_sound(const struct numbers* camera, char why[FIELDS_WHY_CHARS]) {
  const double width = *numbers_find(camera, &kCameraFields, "width");
  const double height = *numbers_find(camera, &kCameraFields, "height");
  if (width != floor(width) || height != floor(height)) {
    return fields_wrong(why, "has %.10g x %.10g pixels: give whole ones", width, height);
  }
  if (width * height > kImage_px) {
    return fields_wrong(why, "has %.0f x %.0f pixels, more than 134 million", width, height);
  }
  if (is_rotation(numbers_find(camera, &kCameraFields, "rotation"))) return true;
  return fields_wrong(why, "has a rotation that is none: give an orthonormal, right-handed matrix");
}

bool size_is(const struct numbers* camera, const double size_px[2], const char* keys,
             char why[FIELDS_WHY_CHARS]) {
  const double width = *numbers_find(camera, &kCameraFields, "width");
  const double height = *numbers_find(camera, &kCameraFields, "height");
  if (width == size_px[0] && height == size_px[1]) return true;
  return fields_wrong(
      why, "has %.0f x %.0f pixels, the rig file's (%s.width_px, %s.height_px) %.0f x %.0f", width,
      height, keys, keys, size_px[0], size_px[1]);
}

bool led_is(const struct numbers* led, const struct led_place* place, char why[FIELDS_WHY_CHARS]) {
  const double* direction = numbers_find(led, &kLedFields, "direction");
  if (fabs(norm(direction, 3) - 1) > kUnitError) {
    return fields_wrong(why, "has a direction whose length is not 1");
  }
  double sine[3];
  cross(direction, place->direction, sine);
  const double off_deg = atan2(norm(sine, 3), dot(direction, place->direction)) * 180 / M_PI;
  if (off_deg <= kFurthest_deg) return true;
  return fields_wrong(
      why, "shines from %.0f degrees beside the rig file's LED, which may be 10 off", off_deg);
}

static bool is_shown(const struct numbers* patterns, const char* name, const double* shown,
                     int count, char why[FIELDS_WHY_CHARS]) {
  const double* calibrated = numbers_find(patterns, &kPatternFields, name);
  for (int i = 0; i < count; i++) {
    if (fabs(shown[i] - calibrated[i]) <= kRounding * fabs(calibrated[i])) continue;
    return fields_wrong(why, "has %.10g of its %s where the rig file (pattern.*) has %.10g",
                        calibrated[i], name, shown[i]);
  }
  return true;
}

bool patterns_are(const struct numbers* patterns, const struct rig* rig,
                  char why[FIELDS_WHY_CHARS]) {
  const double offset[2] = {rig->pattern_dot_offset_u_px, rig->pattern_dot_offset_v_px};
  return is_shown(patterns, "fringe.periods", rig->pattern_fringe_periods, PATTERN_FRINGES, why) &&
         is_shown(patterns, "stripes.period_px", &rig->pattern_stripe_period_px, 1, why) &&
         is_shown(patterns, "stripes.shift_px", &rig->pattern_stripe_shift_px, 1, why) &&
         is_shown(patterns, "dots.pitch_px", &rig->pattern_dot_pitch_px, 1, why) &&
         is_shown(patterns, "dots.diameter_px", &rig->pattern_dot_diameter_px, 1, why) &&
         is_shown(patterns, "dots.offset_px", offset, 2, why);
}

bool colours_are_sound(const struct numbers* rig, char why[FIELDS_WHY_CHARS]) {
  const double* m = numbers_find(rig, &kRigFields, "projector_to_led");
  if (m == NULL) return true;
  double inverse[9];
  const double determinant = fabs(cofactors(m, inverse));
  if (!(norm(m, 9) * norm(inverse, 9) < kMostCondition * determinant)) {
    return fields_wrong(
        why, "has a projector_to_led that cannot be inverted: leave it out for identity");
  }
  for (int i = 0; i < 3; i++) {
    const double* row = m + 3 * i;
    if (row[0] + row[1] + row[2] > 0) continue;
    return fields_wrong(why, "has a projector_to_led that turns white light black");
  }
  return true;
}
