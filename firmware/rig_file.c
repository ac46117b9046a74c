// A rig file and its list of LEDs on a disk.
#include <stdio.h>
#include <string.h>

#include "complain.h"
#include "input_file.h"
#include "rig.h"

enum { kMaxPathChars = 512 };

static char text[RIG_MAX_TEXT_BYTES];  // read once, before any thread begins

static size_t read_text(const char* path, struct rig_errors* errors) {
  char why[INPUT_FILE_WHY_CHARS];
  size_t size = 0;
  if (!input_file_read(path, text, sizeof text, &size, why)) rig_complain(errors, 0, "%s", why);
  return size;
}

// A name without a folder, so that a rig file and its dome are copied together.
static bool find_leds(const char* path, const struct rig* rig, char leds[kMaxPathChars]) {
  const char* slash = strrchr(path, '/');
  const int folder = slash != NULL ? (int)(slash - path) + 1 : 0;
  const int length = snprintf(leds, kMaxPathChars, "%.*s%s", folder, path, rig->leds_file);
  return length < kMaxPathChars && strchr(rig->leds_file, '/') == NULL;
}

static void print(const struct rig_errors* errors, const char* path, const char* leds) {
  const size_t kept = errors->count < RIG_MAX_ERRORS ? errors->count : RIG_MAX_ERRORS;
  for (size_t i = 0; i < kept; i++) {
    const struct rig_error* error = &errors->list[i];
    const char* file = error->in_leds ? leds : path;
    if (error->line > 0) {
      complain("%s:%d: %s", file, error->line, error->text);
    } else {
      complain("%s: %s", file, error->text);
    }
  }
  if (errors->count > kept) complain("%s: %zu more", path, errors->count - kept);
}

static void read_leds(const char* path, struct rig* rig, struct rig_errors* errors) {
  const size_t before = errors->count;
  errors->in_leds = true;
  const size_t size = read_text(path, errors);
  if (errors->count == before) rig_parse_leds(text, size, rig, errors);
}

enum lam_status rig_read(const char* path, struct rig* rig) {
  static struct rig_errors errors;
  char leds[kMaxPathChars] = "";
  memset(&errors, 0, sizeof errors);
  memset(rig, 0, sizeof *rig);
  const size_t size = read_text(path, &errors);
  if (errors.count == 0) rig_parse(text, size, rig, &errors);
  const bool named = rig->leds_file[0] != '\0';
  if (named && !find_leds(path, rig, leds)) {
    const char* why = "'leds.file' is a file beside this one, without a folder";
    rig_complain(&errors, rig_text_line_blamed(text, size, why), "%s", why);
  } else if (named) {
    read_leds(leds, rig, &errors);
  }
  print(&errors, path, leds);
  return errors.count == 0 ? LAM_OK : LAM_BAD_INPUT;
}
