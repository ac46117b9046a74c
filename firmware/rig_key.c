#include "rig_key.h"

#include <math.h>
#include <string.h>

enum rig_kind { KIND_NUMBER, KIND_WHOLE, KIND_CHOICE, KIND_TEXT, KIND_LINE };

struct rig_key {
  const char* name;
  enum rig_kind kind;
  size_t offset;
  bool required, of_board;
  double lowest, highest, otherwise;
  const char *no, *yes;
};

// clang-format off
#define KEY(section, key, field, what) \
  .name = #section "." #key, .offset = offsetof(struct rig, field), .kind = KIND_##what
static const struct rig_key kKeys[] = {
#define NUMBER(section, key, low, high) \
  {KEY(section, key, section##_##key, NUMBER), .required = true, .lowest = low, .highest = high},
#define OPTIONAL_NUMBER(section, key, low, high, value) \
  {KEY(section, key, section##_##key, NUMBER), .lowest = low, .highest = high, .otherwise = value},
#define PLACED_NUMBER(section, key, field, low, high) \
  {KEY(section, key, field, NUMBER), .required = true, .lowest = low, .highest = high},
#define WHOLE(section, key, low, high) \
  {KEY(section, key, section##_##key, WHOLE), .required = true, .lowest = low, .highest = high},
#define CHOICE(section, key, field, word, other) \
  {KEY(section, key, field, CHOICE), .required = true, .no = word, .yes = other},
#define TEXT(section, key) {KEY(section, key, section##_##key, TEXT), .required = true},
#include "rig_keys.def"
#undef NUMBER
#undef OPTIONAL_NUMBER
#undef PLACED_NUMBER
#undef WHOLE
#undef CHOICE
#undef TEXT
#define NUMBER(key, low, high) \
  {KEY(linux, key, board.key, NUMBER), .required = true, .of_board = true, \
   .lowest = low, .highest = high},
#define WHOLE(key, low, high) \
  {KEY(linux, key, board.key, WHOLE), .required = true, .of_board = true, \
   .lowest = low, .highest = high},
#define TEXT(key, must) {KEY(linux, key, board.key, TEXT), .required = must, .of_board = true},
#define LINE(key, must) {KEY(linux, key, board.key, LINE), .required = must, .of_board = true},
#include "rig_linux_keys.def"
#undef NUMBER
#undef WHOLE
#undef TEXT
#undef LINE
};
// clang-format on
enum { kMaxNameChars = 48 };
static const size_t kKeyCount = sizeof kKeys / sizeof kKeys[0];
_Static_assert(sizeof kKeys / sizeof kKeys[0] <= RIG_MAX_KEYS,
               "struct rig_given has room for every key");

static void* field_of(struct rig* rig, const struct rig_key* key) {
  return (char*)rig + key->offset;
}

void rig_key_presume(struct rig* rig) {
  for (size_t i = 0; i < kKeyCount; i++) {
    if (kKeys[i].kind == KIND_NUMBER) {
      memcpy(field_of(rig, &kKeys[i]), &kKeys[i].otherwise, sizeof(double));
    }
  }
}

// Levenshtein's distance, for names of at most kMaxNameChars.
static size_t distance(const char* a, const char* b) {
  size_t row[kMaxNameChars + 1];
  const size_t length = strlen(b);
  for (size_t k = 0; k <= length; k++) row[k] = k;
  for (size_t i = 0; a[i] != '\0'; i++) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t k = 0; k < length; k++) {
      size_t least = diagonal + (a[i] != b[k]);
      if (row[k] + 1 < least) least = row[k] + 1;
      if (row[k + 1] + 1 < least) least = row[k + 1] + 1;
      diagonal = row[k + 1];
      row[k + 1] = least;
    }
  }
  return row[length];
}

// The known key that is most like this one, or NULL where none is more like it than not.
static const char* nearest(const char* name) {
  const char* best = NULL;
  if (strlen(name) > kMaxNameChars) return NULL;
  size_t least = strlen(name) / 2 + 1;
  for (size_t i = 0; i < kKeyCount; i++) {
    const size_t apart = distance(name, kKeys[i].name);
    if (apart >= least) continue;
    least = apart;
    best = kKeys[i].name;
  }
  return best;
}

static const struct rig_key* find(const char* name) {
  for (size_t i = 0; i < kKeyCount; i++) {
    if (strcmp(name, kKeys[i].name) == 0) return &kKeys[i];
  }
  return NULL;
}

static void complain_of_unknown(const struct rig_pair* pair, struct rig_errors* errors) {
  const char* meant = nearest(pair->key);
  if (strncmp(pair->key, "led.", 4) == 0) {
    rig_complain(errors, pair->line, "unknown key '%.40s': LEDs are listed in leds.file",
                 pair->key);
  } else if (meant != NULL) {
    rig_complain(errors, pair->line, "unknown key '%.40s'; is '%s' meant?", pair->key, meant);
  } else {
    rig_complain(errors, pair->line, "unknown key '%.40s'", pair->key);
  }
}

static void take_number(const struct rig_key* key, const struct rig_pair* pair, double* field,
                        struct rig_errors* errors) {
  double number = 0;
  const char* end = rig_text_number(pair->value, &number);
  if (end == NULL || *end != '\0') {
    rig_complain(errors, pair->line, "'%s' needs one decimal number, not '%.40s'", key->name,
                 pair->value);
  } else if (!(number >= key->lowest && number <= key->highest)) {
    rig_complain(errors, pair->line, "'%s' is %.15g; it must be between %.15g and %.15g", key->name,
                 number, key->lowest, key->highest);
  } else if (key->kind == KIND_WHOLE && number != floor(number)) {
    rig_complain(errors, pair->line, "'%s' is %.10g; it must be a whole number", key->name, number);
  } else {
    *field = number;
  }
}

static void take_choice(const struct rig_key* key, const struct rig_pair* pair, bool* field,
                        struct rig_errors* errors) {
  *field = strcmp(pair->value, key->yes) == 0;
  if (*field || strcmp(pair->value, key->no) == 0) return;
  rig_complain(errors, pair->line, "'%s' is %s or %s, not '%.40s'", key->name, key->no, key->yes,
               pair->value);
}

static void take_text(const struct rig_key* key, const struct rig_pair* pair, char* field,
                      struct rig_errors* errors) {
  if (*pair->value == '\0') {
    rig_complain(errors, pair->line, "'%s' is empty", key->name);
  } else if (strlen(pair->value) >= RIG_TEXT_CHARS) {
    rig_complain(errors, pair->line, "'%s' is too long: at most %d characters", key->name,
                 RIG_TEXT_CHARS - 1);
  } else {
    strcpy(field, pair->value);
  }
}

// Two outputs on one line would move together.
static void refuse_shared_line(struct rig* rig, const struct rig_key* key, int line,
                               struct rig_errors* errors) {
  const char* mine = field_of(rig, key);
  for (size_t i = 0; i < kKeyCount; i++) {
    if (&kKeys[i] == key || kKeys[i].kind != KIND_LINE || *mine == '\0') continue;
    if (strcmp(field_of(rig, &kKeys[i]), mine) != 0) continue;
    rig_complain(errors, line, "'%s' is the line that '%s' has", key->name, kKeys[i].name);
    return;
  }
}

void rig_key_take(struct rig* rig, struct rig_given* given, const struct rig_pair* pair,
                  struct rig_errors* errors) {
  const struct rig_key* key = find(pair->key);
  rig->board.given |= strncmp(pair->key, "linux.", 6) == 0;
  if (key == NULL) {
    complain_of_unknown(pair, errors);
    return;
  }
  int* given_on = &given->lines[key - kKeys];
  if (*given_on != 0) {
    rig_complain(errors, pair->line, "'%s' is given twice, on line %d before", key->name,
                 *given_on);
    return;
  }
  *given_on = pair->line;
  void* field = field_of(rig, key);
  if (key->kind == KIND_CHOICE) {
    take_choice(key, pair, field, errors);
  } else if (key->kind == KIND_TEXT || key->kind == KIND_LINE) {
    take_text(key, pair, field, errors);
  } else {
    take_number(key, pair, field, errors);
  }
  if (key->kind == KIND_LINE) refuse_shared_line(rig, key, pair->line, errors);
}

int rig_key_line(const struct rig_given* given, const char* name) {
  return given->lines[find(name) - kKeys];
}

void rig_key_require_all(const struct rig* rig, const struct rig_given* given,
                         struct rig_errors* errors) {
  for (size_t i = 0; i < kKeyCount; i++) {
    if (!kKeys[i].required || given->lines[i] != 0) continue;
    if (kKeys[i].of_board && !rig->board.given) continue;
    rig_complain(errors, 0, "missing key '%s'", kKeys[i].name);
  }
}
