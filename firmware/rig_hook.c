#include "rig_hook.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char kControl[] = "control:", kModule[] = "module:", kFixed[] = "fixed";

static bool refuse(char error[160], const char* text, const char* why) {
  snprintf(error, 160, "'linux.camera_trigger' is '%.60s', which %s", text, why);
  return false;
}

// "NAME=VALUE" into its two parts.
static bool split(const char* text, struct rig_hook* hook) {
  const char* equals = strrchr(text, '=');
  if (equals == NULL || equals == text || equals[1] == '\0') return false;
  const size_t length = (size_t)(equals - text);
  if (length >= sizeof hook->name) return false;
  memcpy(hook->name, text, length);
  hook->name[length] = '\0';
  snprintf(hook->value, sizeof hook->value, "%s", equals + 1);
  return true;
}

static bool read_control(const char* text, struct rig_hook* hook) {
  if (!split(text, hook)) return false;
  const char* digits = hook->value + (hook->value[0] == '-');
  const size_t count = strspn(digits, "0123456789");
  const bool octal = digits[0] == '0' && count > 1;  // as some would read it
  if (count == 0 || digits[count] != '\0' || octal) return false;
  hook->number = strtol(hook->value, NULL, 10);
  return hook->number >= INT32_MIN && hook->number <= INT32_MAX;
}

static bool read_module(const char* text, struct rig_hook* hook) {
  return split(text, hook) && strstr(hook->name, "/parameters/") != NULL &&
         strstr(hook->name, "..") == NULL;
}

bool rig_hook_read(const char* text, struct rig_hook* hook, char error[160]) {
  *hook = (struct rig_hook){.kind = RIG_HOOK_FIXED};
  if (strcmp(text, kFixed) == 0) return true;
  if (strncmp(text, kControl, strlen(kControl)) == 0) {
    hook->kind = RIG_HOOK_CONTROL;
    return read_control(text + strlen(kControl), hook) ||
           refuse(error, text, "is not control:NAME=NUMBER");
  }
  if (strncmp(text, kModule, strlen(kModule)) == 0) {
    hook->kind = RIG_HOOK_MODULE;
    return read_module(text + strlen(kModule), hook) ||
           refuse(error, text, "is not module:NAME/parameters/NAME=VALUE");
  }
  return refuse(error, text, "is none of control:NAME=NUMBER, module:... and fixed");
}
