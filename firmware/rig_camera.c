#include "rig_camera.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "rig_text.h"

enum kind { WHOLE, NUMBER, FORMAT, SENSOR, TRIGGER, ACTIVE, STAMP };

struct camera_key {
  const char* name;
  size_t offset;
  enum kind kind;
  bool required;
  double lowest, highest;
};

#define KEY(field, kind, required, lowest, highest) \
  { "camera." #field, offsetof(struct rig_camera, field), kind, required, lowest, highest }
static const struct camera_key kKeys[RIG_CAMERA_KEYS] = {
    KEY(width_px, WHOLE, true, 2, RAW_MAX_WIDTH_PX),
    KEY(height_px, WHOLE, true, 2, RAW_MAX_WIDTH_PX),
    KEY(format, FORMAT, true, 0, 0),
    KEY(black_level_dn, NUMBER, true, 0, 4095),
    KEY(full_scale_dn, NUMBER, true, 1, 4095),
    {"camera.sensor", offsetof(struct rig_camera, name), SENSOR, true, 0, 0},
    {"camera.trigger", offsetof(struct rig_camera, edge_triggered), TRIGGER, true, 0, 0},
    {"camera.trigger_active", offsetof(struct rig_camera, trigger_active_low), ACTIVE, true, 0, 0},
    KEY(exposure_step_us, NUMBER, false, 0.001, 1000),
    KEY(stamp, STAMP, true, 0, 0),
    KEY(stamp_late_us, NUMBER, true, 0, 1e6),
};

static size_t index_of(const char* key) {
  size_t index = 0;
  while (index < RIG_CAMERA_KEYS && strcmp(key, kKeys[index].name) != 0) index++;
  return index;
}

bool rig_camera_knows(const char* key) { return index_of(key) < RIG_CAMERA_KEYS; }

static bool refuse(char error[160], const char* key, const char* why) {
  snprintf(error, 160, "'%.40s' %s", key, why);
  return false;
}

static bool take_number(const struct camera_key* key, const char* value, void* field,
                        char error[160]) {
  double number = 0;
  const char* end = rig_text_number(value, &number);
  if (end == NULL || *end != '\0') {
    snprintf(error, 160, "'%s' needs one decimal number, not '%.40s'", key->name, value);
    return false;
  }
  if (!(number >= key->lowest && number <= key->highest)) {
    snprintf(error, 160, "'%s' is %.10g; it must be between %.10g and %.10g", key->name, number,
             key->lowest, key->highest);
    return false;
  }
  if (key->kind == WHOLE && number != floor(number)) {
    return refuse(error, key->name, "must be a whole number");
  }
  memcpy(field, &number, sizeof number);
  return true;
}

static bool take_format(struct rig_camera* camera, const char* value, char error[160]) {
  camera->format = raw_format_find(value);
  return camera->format != NULL ||
         refuse(error, "camera.format", "is none that is known: as Y10P or SRGGB12 (raw_pixels.h)");
}

// Which of the words it is; -1: none.
static int word_of(const char* value, const char* const words[], int count) {
  for (int i = 0; i < count; i++) {
    if (strcmp(value, words[i]) == 0) return i;
  }
  return -1;
}

static bool take_sensor(struct rig_camera* camera, const char* value, char error[160]) {
  static const char* const kWords[] = {
      [RIG_SENSOR_OTHER] = "other", [RIG_SENSOR_IMX296] = "imx296", [RIG_SENSOR_OV9281] = "ov9281"};
  const int word = word_of(value, kWords, 3);
  camera->name = (enum rig_sensor_name)word;
  return word >= 0 || refuse(error, "camera.sensor", "is imx296, ov9281 or other");
}

static bool take_trigger(struct rig_camera* camera, const char* value, char error[160]) {
  static const char* const kWords[] = {"level", "edge"};
  const int word = word_of(value, kWords, 2);
  camera->edge_triggered = word == 1;
  return word >= 0 || refuse(error, "camera.trigger", "is edge or level");
}

static bool take_active(struct rig_camera* camera, const char* value, char error[160]) {
  static const char* const kWords[] = {"high", "low"};
  const int word = word_of(value, kWords, 2);
  camera->trigger_active_low = word == 1;
  return word >= 0 || refuse(error, "camera.trigger_active", "is high or low");
}

static bool take_stamp(struct rig_camera* camera, const char* value, char error[160]) {
  static const char* const kWords[] = {[RIG_STAMP_OPENED] = "opened",
                                       [RIG_STAMP_CLOSED] = "closed",
                                       [RIG_STAMP_READ_OUT] = "read_out"};
  const int word = word_of(value, kWords, 3);
  camera->stamp = (enum rig_stamp)word;
  return word >= 0 || refuse(error, "camera.stamp", "is opened, closed or read_out");
}

bool rig_camera_take(struct rig_camera* camera, const char* key, const char* value,
                     char error[160]) {
  const size_t index = index_of(key);
  if (index == RIG_CAMERA_KEYS) return refuse(error, key, "is an unknown key");
  if (camera->seen[index]) return refuse(error, key, "is given twice");
  camera->seen[index] = true;
  const struct camera_key* known = &kKeys[index];
  switch (known->kind) {
    case FORMAT:
      return take_format(camera, value, error);
    case SENSOR:
      return take_sensor(camera, value, error);
    case TRIGGER:
      return take_trigger(camera, value, error);
    case ACTIVE:
      return take_active(camera, value, error);
    case STAMP:
      return take_stamp(camera, value, error);
    case WHOLE:
    case NUMBER:
      break;
  }
  return take_number(known, value, (char*)camera + known->offset, error);
}

bool rig_camera_complete(const struct rig_camera* camera, char error[160]) {
  for (size_t i = 0; i < RIG_CAMERA_KEYS; i++) {
    if (kKeys[i].required && !camera->seen[i]) {
      snprintf(error, 160, "missing key '%s', as there is a 'linux.camera_left'", kKeys[i].name);
      return false;
    }
  }
  return camera->full_scale_dn > camera->black_level_dn ||
         refuse(error, "camera.full_scale_dn", "must be above camera.black_level_dn");
}
