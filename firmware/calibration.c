#include "calibration.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "json_scan.h"

static const char kFormat[] = "lamella.session.v1";
static const char kReplace[] = "replace it (board/README.md, \"Pairing and calibration\")";

enum { kCameras = 2 };
static const char* const kNames[kCameras] = {"left", "right"};

struct found_camera {
  char id[8];  // "" where it has none that a rig's camera may have
  double width, height;
  int line;
};

struct found {
  bool object, format, rig, leds, projector, frames;
  size_t cameras;
  struct found_camera camera[kCameras];
};

static bool is_text(const struct json_value* value, const char* text) {
  return value->kind == JSON_STRING && value->length == strlen(text) &&
         memcmp(value->text, text, value->length) == 0;
}

static double number_of(const struct json_value* value) {
  char text[32];
  if (value->kind != JSON_NUMBER || value->length >= sizeof text) return NAN;
  memcpy(text, value->text, value->length);
  text[value->length] = '\0';
  return strtod(text, NULL);
}

static void take_of_camera(struct found_camera* camera, const char* field,
                           const struct json_value* value) {
  if (strcmp(field, "width") == 0) camera->width = number_of(value);
  if (strcmp(field, "height") == 0) camera->height = number_of(value);
  for (int i = 0; i < kCameras && strcmp(field, "id") == 0; i++) {
    if (is_text(value, kNames[i])) strcpy(camera->id, kNames[i]);
  }
}

static void take_camera(struct found* found, const struct json_value* value) {
  static const char kPath[] = "rig.cameras[";
  if (strncmp(value->path, kPath, sizeof kPath - 1) != 0) return;
  char* end = NULL;
  const unsigned long index = strtoul(value->path + sizeof kPath - 1, &end, 10);
  const bool itself = strcmp(end, "]") == 0;
  if (itself) found->cameras++;
  if (index >= kCameras) return;
  if (itself) found->camera[index] = (struct found_camera){.line = value->line};
  if (strncmp(end, "].", 2) == 0) take_of_camera(&found->camera[index], end + 2, value);
}

static void take(void* context, const struct json_value* value) {
  struct found* found = context;
  const bool object = value->kind == JSON_OBJECT;
  if (strcmp(value->path, "") == 0) found->object = object;
  if (strcmp(value->path, "format") == 0) found->format = is_text(value, kFormat);
  if (strcmp(value->path, "rig") == 0) found->rig = object;
  if (strcmp(value->path, "rig.leds[0]") == 0) found->leds = object;
  if (strcmp(value->path, "rig.projector") == 0) found->projector = object;
  if (strcmp(value->path, "frames[0]") == 0) found->frames = true;
  take_camera(found, value);
}

static bool refuse(char why[CALIBRATION_WHY_CHARS], const char* format, ...)
    __attribute__((format(printf, 2, 3)));

static bool refuse(char why[CALIBRATION_WHY_CHARS], const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(why, CALIBRATION_WHY_CHARS, format, arguments);
  va_end(arguments);
  return false;
}

static bool is_whole(double pixels) { return pixels >= 1 && pixels == floor(pixels); }

static bool camera_is_sound(const struct found_camera* camera, const struct rig_camera* own,
                            char why[CALIBRATION_WHY_CHARS]) {
  if (!is_whole(camera->width) || !is_whole(camera->height)) {
    return refuse(why, "line %d: the %s camera has no width or height in pixels; %s", camera->line,
                  camera->id, kReplace);
  }
  if (own == NULL || (camera->width == own->width_px && camera->height == own->height_px)) {
    return true;
  }
  return refuse(why,
                "line %d: the %s camera has %.0f x %.0f pixels, the rig file's (camera.width_px, "
                "camera.height_px) %.0f x %.0f: make both say what the camera sends",
                camera->line, camera->id, camera->width, camera->height, own->width_px,
                own->height_px);
}

static bool cameras_are_sound(const struct found* found, const struct rig_camera* own,
                              char why[CALIBRATION_WHY_CHARS]) {
  const struct found_camera* camera = found->camera;
  const bool both = found->cameras == kCameras && camera[0].id[0] != '\0' &&
                    camera[1].id[0] != '\0' && strcmp(camera[0].id, camera[1].id) != 0;
  if (!both) {
    return refuse(why, "rig.cameras are not two, with the id \"left\" and \"right\"; %s", kReplace);
  }
  return camera_is_sound(&camera[0], own, why) && camera_is_sound(&camera[1], own, why);
}

bool calibration_check(const char* text, size_t length, const struct rig_camera* own,
                       char why[CALIBRATION_WHY_CHARS]) {
  struct found found = {0};
  struct json_error error;
  if (length == 0) return refuse(why, "is empty; %s", kReplace);
  if (!json_scan(text, length, take, &found, &error)) {
    return refuse(why, "line %d: not JSON: %s; %s", error.line, error.what, kReplace);
  }
  if (!found.object) return refuse(why, "is no JSON object; %s", kReplace);
  if (!found.format) return refuse(why, "\"format\" is not \"%s\"; %s", kFormat, kReplace);
  if (!found.rig) return refuse(why, "has no \"rig\"; %s", kReplace);
  if (!found.leds) return refuse(why, "has no rig.leds; %s", kReplace);
  if (!found.projector) return refuse(why, "has no rig.projector; %s", kReplace);
  if (found.frames) return refuse(why, "has frames: it is a session, not a rig's; %s", kReplace);
  return cameras_are_sound(&found, own, why);
}
