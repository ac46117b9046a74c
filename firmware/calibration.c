#include "calibration.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_rules.h"

static const char kFormat[] = "lamella.session.v1";
static const char kReplace[] = "replace it (board/README.md, \"Pairing and calibration\")";
static const char kAgree[] = "make both say what is there";

enum { kCameras = 2 };
static const char* const kNames[kCameras] = {"left", "right"};

struct found_camera {
  const char* id;  // NULL where it has none that a rig's camera may have
  bool named;
  int line;
  struct numbers numbers;
};

// What a host parses, and takes once alone: protobuf takes the second for another.
static const struct {
  const char* path;
  enum json_kind kind;
} kKinds[] = {{"", JSON_OBJECT},
              {"format", JSON_STRING},
              {"subject", JSON_STRING},
              {"rig", JSON_OBJECT},
              {"rig.leds", JSON_ARRAY},
              {"rig.leds[]", JSON_OBJECT},
              {"rig.cameras", JSON_ARRAY},
              {"rig.cameras[]", JSON_OBJECT},
              {"rig.cameras[].id", JSON_STRING},
              {"rig.projector", JSON_OBJECT},
              {"rig.projector.id", JSON_STRING},
              {"patterns", JSON_OBJECT},
              {"patterns.fringe", JSON_OBJECT},
              {"patterns.stripes", JSON_OBJECT},
              {"patterns.dots", JSON_OBJECT},
              {"frames", JSON_ARRAY},
              {"retaken", JSON_ARRAY},
              {"regions", JSON_OBJECT},
              {"regions.file", JSON_STRING},
              {"regions.names", JSON_ARRAY},
              {"regions.names[]", JSON_STRING},
              {"shortfall", JSON_STRING},
              {"flashing_confirmed", JSON_WORD},
              {"flashingConfirmed", JSON_WORD}};
enum { kKindCount = sizeof kKinds / sizeof kKinds[0] };

// What was read so far; one LED at a time, as there may be any number.
struct found {
  const struct rig* rig;
  bool seen[kKindCount];
  bool format;
  size_t leds, cameras;
  int led_line;
  struct numbers led, patterns, colours;
  struct found_camera camera[kCameras], projector;
  char* why;  // of the first thing that is wrong
  bool refused;
};

// The first reason stands.
static bool refuse(struct found* found, const char* format, ...)
    __attribute__((format(printf, 2, 3)));

static bool refuse(struct found* found, const char* format, ...) {
  if (found->refused) return false;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(found->why, CALIBRATION_WHY_CHARS, format, arguments);
  va_end(arguments);
  found->refused = true;
  return false;
}

static bool is_text(const struct json_value* value, const char* text) {
  return value->kind == JSON_STRING && value->length == strlen(text) &&
         memcmp(value->text, text, value->length) == 0;
}

// --- Kinds of values ---

static const char* const kKindNames[] = {[JSON_OBJECT] = "an object",
                                         [JSON_ARRAY] = "a list",
                                         [JSON_STRING] = "a text",
                                         [JSON_NUMBER] = "a number",
                                         [JSON_WORD] = "true or false"};

// "x[7].y" matches "x[].y".
static bool path_is(const char* path, const char* pattern) {
  for (; *pattern != '\0'; pattern++, path++) {
    if (*path != *pattern) return false;
    if (*pattern == '[') path += strspn(path + 1, "0123456789");
  }
  return *path == '\0';
}

// proto3 JSON: null stands for that.
static bool is_left_out(const struct json_value* value) {
  const size_t length = strlen(value->path);
  const bool element = length == 0 || value->path[length - 1] == ']';
  return is_null(value) && !element;
}

static bool is_once(const char* path) { return strchr(path, '[') == NULL; }

// False where a host would not even parse it.
static bool kind_is_right(struct found* found, const struct json_value* value) {
  if (is_left_out(value)) return true;
  for (size_t i = 0; i < kKindCount; i++) {
    const enum json_kind kind = kKinds[i].kind;
    if (!path_is(value->path, kKinds[i].path)) continue;
    const char* path = value->path[0] == '\0' ? "the whole" : value->path;
    if (value->kind != kind) {
      return refuse(found, "line %d: %s is not %s; %s", value->line, path, kKindNames[kind],
                    kReplace);
    }
    if (found->seen[i] && is_once(kKinds[i].path)) {
      return refuse(found, "line %d: %s is given twice; %s", value->line, path, kReplace);
    }
    found->seen[i] = true;
  }
  return true;
}

// --- What is judged where it ends ---

static void judge_led(struct found* found) {
  char why[FIELDS_WHY_CHARS];
  if (found->leds == 0 || found->refused) return;
  const size_t index = found->leds - 1;
  const bool one_more = index >= found->rig->led_count;  // told where they are counted
  if (numbers_whole(&found->led, &kLedFields, why) &&
      (one_more || led_is(&found->led, &found->rig->leds[index], why))) {
    return;
  }
  refuse(found, "line %d: rig.leds[%zu] %s; %s", found->led_line, index, why, kReplace);
}

// Of the size that the rig file has under `keys`; NULL: of any.
static void judge_view(struct found* found, const struct found_camera* view, const char* name,
                       const char* keys, const double size_px[2]) {
  char why[FIELDS_WHY_CHARS];
  if (!numbers_whole(&view->numbers, &kCameraFields, why) ||
      !camera_is_sound(&view->numbers, why)) {
    refuse(found, "line %d: the %s %s; %s", view->line, name, why, kReplace);
  } else if (keys != NULL && !size_is(&view->numbers, size_px, keys, why)) {
    refuse(found, "line %d: the %s %s: %s", view->line, name, why, kAgree);
  }
}

static void judge_cameras(struct found* found, const struct rig_camera* own) {
  const struct found_camera* camera = found->camera;
  const bool both = found->cameras == kCameras && camera[0].id != NULL && camera[1].id != NULL &&
                    camera[0].id != camera[1].id;
  if (!both) {
    refuse(found, "rig.cameras are not two, with the id \"left\" and \"right\"; %s", kReplace);
    return;
  }
  for (int i = 0; i < kCameras; i++) {
    char name[16];
    snprintf(name, sizeof name, "%s camera", camera[i].id);
    const double size_px[2] = {own == NULL ? 0 : own->width_px, own == NULL ? 0 : own->height_px};
    judge_view(found, &camera[i], name, own == NULL ? NULL : "camera", size_px);
  }
}

static void judge_rig(struct found* found) {
  char why[FIELDS_WHY_CHARS];
  const struct rig* rig = found->rig;
  const double size_px[2] = {rig->projector_width_px, rig->projector_height_px};
  judge_view(found, &found->projector, "projector", "projector", size_px);
  if (found->leds != rig->led_count) {
    refuse(found, "rig.leds are %zu, the rig file's (%s) %zu: %s", found->leds, rig->leds_file,
           rig->led_count, kAgree);
  }
  const bool patterns = numbers_whole(&found->patterns, &kPatternFields, why);
  if (!patterns || !patterns_are(&found->patterns, rig, why)) {
    refuse(found, "\"patterns\" %s: %s", why, kAgree);
  }
  const bool colours = numbers_whole(&found->colours, &kRigFields, why);
  if (!colours || !colours_are_sound(&found->colours, why)) {
    refuse(found, "rig %s; %s", why, kReplace);
  }
}

// --- What is taken as it is read ---

// What follows "NAME[" and an index; NULL where the path does not begin so.
static const char* within(const char* path, const char* list, size_t* index) {
  const size_t length = strlen(list);
  if (strncmp(path, list, length) != 0 || path[length] != '[') return NULL;
  char* end = NULL;
  *index = strtoul(path + length + 1, &end, 10);
  return end + 1;
}

static void take_numbers(struct found* found, struct numbers* numbers,
                         const struct field_group* group, const char* name,
                         const struct json_value* value) {
  char why[FIELDS_WHY_CHARS];
  if (numbers_take(numbers, group, name, value, why)) return;
  refuse(found, "line %d: %s; %s", value->line, why, kReplace);
}

static void take_led(struct found* found, const struct json_value* value) {
  size_t index = 0;
  const char* rest = within(value->path, "rig.leds", &index);
  if (rest == NULL) return;
  if (*rest == '\0') {
    judge_led(found);
    found->led = (struct numbers){0};
    found->led_line = value->line;
    found->leds++;
  }
  if (*rest == '.') take_numbers(found, &found->led, &kLedFields, rest + 1, value);
}

static void take_camera(struct found* found, const struct json_value* value) {
  size_t index = 0;
  const char* rest = within(value->path, "rig.cameras", &index);
  if (rest == NULL) return;
  if (*rest == '\0') found->cameras++;
  if (index >= kCameras) return;
  struct found_camera* camera = &found->camera[index];
  if (*rest == '\0') camera->line = value->line;
  if (strcmp(rest, ".id") == 0) {
    if (camera->named) {
      refuse(found, "line %d: %s is given twice; %s", value->line, value->path, kReplace);
    }
    camera->named = true;
    for (int i = 0; i < kCameras; i++) {
      if (is_text(value, kNames[i])) camera->id = kNames[i];
    }
  }
  if (*rest == '.') take_numbers(found, &camera->numbers, &kCameraFields, rest + 1, value);
}

// What follows `prefix`; NULL where the path does not begin with it.
static const char* after(const char* path, const char* prefix) {
  const size_t length = strlen(prefix);
  return strncmp(path, prefix, length) == 0 ? path + length : NULL;
}

static void take_rig(struct found* found, const struct json_value* value) {
  const char *projector = after(value->path, "rig.projector."),
             *patterns = after(value->path, "patterns."), *rig = after(value->path, "rig.");
  struct numbers* seen = &found->projector.numbers;
  if (projector != NULL) take_numbers(found, seen, &kCameraFields, projector, value);
  if (patterns != NULL) take_numbers(found, &found->patterns, &kPatternFields, patterns, value);
  if (rig != NULL) take_numbers(found, &found->colours, &kRigFields, rig, value);
}

static void take_session(struct found* found, const struct json_value* value) {
  if (strcmp(value->path, "rig.projector") == 0) found->projector.line = value->line;
  if (strcmp(value->path, "format") == 0) found->format = is_text(value, kFormat);
  if (strcmp(value->path, "frames[0]") == 0 || strcmp(value->path, "retaken[0]") == 0) {
    refuse(found, "line %d: has frames: it is a session, not a rig's; %s", value->line, kReplace);
  }
}

static void take(void* context, const struct json_value* value) {
  struct found* found = context;
  if (found->refused || !kind_is_right(found, value)) return;
  if (value->kind == JSON_NUMBER && isnan(number_of(value))) {
    refuse(found, "line %d: a number that is too long or too large; %s", value->line, kReplace);
  }
  take_session(found, value);
  take_led(found, value);
  take_camera(found, value);
  take_rig(found, value);
}

static bool is_there(const struct found* found, const char* path) {
  size_t i = 0;
  while (strcmp(kKinds[i].path, path) != 0) i++;
  return found->seen[i];
}

static bool has_what_is_needed(struct found* found) {
  if (!found->format) return refuse(found, "\"format\" is not \"%s\"; %s", kFormat, kReplace);
  if (!is_there(found, "rig")) return refuse(found, "has no \"rig\"; %s", kReplace);
  if (found->leds == 0) return refuse(found, "has no rig.leds; %s", kReplace);
  if (!is_there(found, "rig.projector")) return refuse(found, "has no rig.projector; %s", kReplace);
  return !found->refused;
}

bool calibration_check(const char* text, size_t length, const struct rig* rig,
                       const struct rig_camera* own, char why[CALIBRATION_WHY_CHARS]) {
  struct found found = {.rig = rig, .why = why};
  struct json_error error;
  if (length == 0) return refuse(&found, "is empty; %s", kReplace);
  if (!json_scan(text, length, take, &found, &error)) {
    found.refused = false;
    return refuse(&found, "line %d: not JSON: %s; %s", error.line, error.what, kReplace);
  }
  if (!has_what_is_needed(&found)) return false;
  judge_led(&found);
  judge_cameras(&found, own);
  judge_rig(&found);
  return !found.refused;
}
