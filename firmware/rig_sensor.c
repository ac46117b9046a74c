#include "rig_sensor.h"

#include <stdio.h>
#include <string.h>

#include "rig_hook.h"

enum { kMostFormats = 6 };

struct sensor {
  const char* name;
  double width_px, height_px;
  bool edge_triggered;
  const char* formats[kMostFormats];  // Y16, SBGGR16: a Raspberry Pi 5 hands over words
  enum rig_hook_kind hook;
  const char *hook_name, *hook_value;  // NULL: whatever the module's maker calls it
};

static const struct sensor kSensors[] = {
    // The pulse is the exposure. Its driver waits for triggers where its module is told to.
    [RIG_SENSOR_IMX296] = {"imx296",
                           1456,
                           1088,
                           false,
                           {"Y10", "Y10P", "Y16", "SBGGR10", "SBGGR10P", "SBGGR16"},
                           RIG_HOOK_MODULE,
                           "imx296/parameters/trigger_mode",
                           "1"},
    // An edge begins an exposure whose length is a control. The kernel's own driver does not wait
    // for triggers: a module that has FSIN comes with a control for it.
    [RIG_SENSOR_OV9281] =
        {"ov9281", 1280, 800, true, {"GREY", "Y10", "Y10P", "Y16"}, RIG_HOOK_CONTROL, NULL, NULL},
};

static bool has_format(const struct sensor* sensor, const char* name) {
  for (size_t i = 0; i < kMostFormats && sensor->formats[i] != NULL; i++) {
    if (strcmp(sensor->formats[i], name) == 0) return true;
  }
  return false;
}

static bool has_hook(const struct sensor* sensor, const struct rig_hook* hook) {
  if (hook->kind != sensor->hook) return false;
  if (sensor->hook_name == NULL) return true;
  return strcmp(hook->name, sensor->hook_name) == 0 && strcmp(hook->value, sensor->hook_value) == 0;
}

static void tell_hook(const struct sensor* sensor, char error[160]) {
  if (sensor->hook == RIG_HOOK_MODULE) {
    snprintf(error, 160, "an %s wants 'linux.camera_trigger = module:%s=%s'", sensor->name,
             sensor->hook_name, sensor->hook_value);
  } else {
    snprintf(error, 160,
             "an %s wants 'linux.camera_trigger = control:NAME=VALUE', what puts it into trigger "
             "mode: v4l2-ctl -l",
             sensor->name);
  }
}

bool rig_sensor_fits(const struct rig* rig, char error[160]) {
  const struct rig_camera* camera = &rig->sensor;
  struct rig_hook hook;
  if (!rig_hook_read(rig->board.camera_trigger, &hook, error)) return false;
  if (camera->name == RIG_SENSOR_OTHER) return true;
  const struct sensor* sensor = &kSensors[camera->name];
  error[0] = '\0';
  if (camera->edge_triggered != sensor->edge_triggered) {
    snprintf(error, 160, "an %s wants 'camera.trigger = %s'", sensor->name,
             sensor->edge_triggered ? "edge" : "level");
  } else if (!has_hook(sensor, &hook)) {
    tell_hook(sensor, error);
  } else if (camera->width_px > sensor->width_px || camera->height_px > sensor->height_px) {
    snprintf(error, 160,
             "an %s has no more than %.0f x %.0f pixels: 'camera.width_px', 'height_px'",
             sensor->name, sensor->width_px, sensor->height_px);
  } else if (!has_format(sensor, camera->format->name)) {
    snprintf(error, 160, "an %s does not give 'camera.format = %s'", sensor->name,
             camera->format->name);
  }
  return error[0] == '\0';
}
