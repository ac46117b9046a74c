#include "led_reference.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "crc32c.h"
#include "input_file.h"

// "LamLEDs1", the number of LEDs, their signatures as floats, CRC32C of all that; little endian.
static const char kMagic[8] = "LamLEDs1";
enum {
  kHeadBytes = sizeof kMagic + 4,
  kLedBytes = SIGNATURE_SIZE * 4,
  kMaxFileBytes = kHeadBytes + RIG_MAX_LEDS * kLedBytes + 4,
};

static double tent(int place, double at) { return fmax(0, 1 - fabs(at - place)); }

// 12 bits a sample, two samples in three bytes.
static unsigned sample(const uint8_t* bytes, size_t index) {
  const uint8_t* at = bytes + index / 2 * 3;
  return index % 2 == 0 ? at[0] | (at[1] & 0xFu) << 8 : at[1] >> 4 | (unsigned)at[2] << 4;
}

// Samples of one pixel; 0 where the sizes do not fit together.
static size_t channels_of(const lamella_v1_PhotographHeader* header) {
  const size_t pixels = (size_t)header->width * header->height;
  for (size_t channels = 1; channels <= 3; channels += 2) {
    if (pixels > 0 && (pixels * channels + 1) / 2 * 3 == header->size_bytes) return channels;
  }
  return 0;
}

// A row's share to the tents across; `sums` are of its samples.
static void weigh_row(const struct hal_photograph* photograph, size_t row, size_t channels,
                      double sums[SIGNATURE_SIDE]) {
  const size_t width = photograph->header.width;
  const double step = width > 1 ? (SIGNATURE_SIDE - 1.0) / (double)(width - 1) : 0;
  for (int i = 0; i < SIGNATURE_SIDE; i++) sums[i] = 0;
  for (size_t x = 0; x < width; x++) {
    double dn = 0;
    for (size_t c = 0; c < channels; c++) {
      dn += sample(photograph->bytes, (row * width + x) * channels + c);
    }
    const int left = (int)((double)x * step);
    sums[left] += dn * tent(left, (double)x * step);
    if (left + 1 < SIGNATURE_SIDE) sums[left + 1] += dn * tent(left + 1, (double)x * step);
  }
}

bool led_signature_take(struct led_signature* signature, unsigned camera,
                        const struct hal_photograph* photograph) {
  const lamella_v1_PhotographHeader* header = &photograph->header;
  const size_t channels = channels_of(header);
  if (channels == 0) return false;
  double* half = signature->dn + camera * SIGNATURE_SIDE * SIGNATURE_SIDE;
  memset(half, 0, SIGNATURE_SIDE * SIGNATURE_SIDE * sizeof *half);
  const double step = header->height > 1 ? (SIGNATURE_SIDE - 1.0) / (header->height - 1.0) : 0;
  const double scale = 1.0 / ((double)header->width * header->height * (double)channels);
  for (size_t y = 0; y < header->height; y++) {
    double sums[SIGNATURE_SIDE];
    weigh_row(photograph, y, channels, sums);
    for (int i = 0; i < SIGNATURE_SIDE; i++) {
      const double weight = scale * tent(i, (double)y * step);
      for (int j = 0; j < SIGNATURE_SIDE; j++) half[i * SIGNATURE_SIDE + j] += weight * sums[j];
    }
  }
  return true;
}

double led_signature_norm(const struct led_signature* signature) {
  const struct led_signature none = {{0}};
  return led_signature_distance(signature, &none);
}

double led_signature_distance(const struct led_signature* a, const struct led_signature* b) {
  double sum = 0;
  for (int i = 0; i < SIGNATURE_SIZE; i++) sum += (a->dn[i] - b->dn[i]) * (a->dn[i] - b->dn[i]);
  return sqrt(sum);
}

void led_signature_add(struct led_signature* a, double factor, const struct led_signature* b) {
  for (int i = 0; i < SIGNATURE_SIZE; i++) a->dn[i] += factor * b->dn[i];
}

static uint32_t get32(const uint8_t* at) {
  return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static void put32(uint8_t* at, uint32_t value) {
  for (int i = 0; i < 4; i++) at[i] = (uint8_t)(value >> (8 * i));
}

bool led_reference_parse(const uint8_t* bytes, size_t size, size_t led_count,
                         struct led_reference* reference) {
  memset(reference, 0, sizeof *reference);
  if (led_count > RIG_MAX_LEDS || size != kHeadBytes + led_count * kLedBytes + 4) return false;
  if (memcmp(bytes, kMagic, sizeof kMagic) != 0) return false;
  if (get32(bytes + sizeof kMagic) != led_count) return false;
  if (crc32c_extend(0, bytes, size - 4) != get32(bytes + size - 4)) return false;
  for (size_t i = 0; i < led_count * SIGNATURE_SIZE; i++) {
    const uint32_t bits = get32(bytes + kHeadBytes + 4 * i);
    float dn = 0;
    memcpy(&dn, &bits, sizeof dn);
    if (!isfinite(dn)) return false;
    reference->leds[i / SIGNATURE_SIZE].dn[i % SIGNATURE_SIZE] = (double)dn;
  }
  reference->led_count = (uint32_t)led_count;
  return true;
}

enum lam_status led_reference_read(const char* path, size_t led_count,
                                   struct led_reference* reference, char error[112]) {
  static uint8_t bytes[kMaxFileBytes];
  reference->led_count = 0;
  char why[INPUT_FILE_WHY_CHARS];
  size_t size = 0;
  if (!input_file_read(path, bytes, sizeof bytes, &size, why)) {
    if (errno == ENOENT) return LAM_OK;
    snprintf(error, 112, "%.60s: %.49s", path, why);
    return LAM_BAD_INPUT;
  }
  if (led_reference_parse(bytes, size, led_count, reference)) return LAM_OK;
  snprintf(error, 112, "%.55s: no LED reference of this rig: remove it, then learn it", path);
  return LAM_BAD_INPUT;
}

static size_t encode(const struct led_reference* reference, uint8_t bytes[kMaxFileBytes]) {
  memcpy(bytes, kMagic, sizeof kMagic);
  put32(bytes + sizeof kMagic, reference->led_count);
  uint8_t* at = bytes + kHeadBytes;
  for (size_t i = 0; i < reference->led_count * SIGNATURE_SIZE; i++, at += 4) {
    const float dn = (float)reference->leds[i / SIGNATURE_SIZE].dn[i % SIGNATURE_SIZE];
    uint32_t bits = 0;
    memcpy(&bits, &dn, sizeof bits);
    put32(at, bits);
  }
  put32(at, crc32c_extend(0, bytes, (size_t)(at - bytes)));
  return (size_t)(at - bytes) + 4;
}

enum lam_status led_reference_write(const char* path, const struct led_reference* reference,
                                    char error[112]) {
  static uint8_t bytes[kMaxFileBytes];
  char place[PATH_MAX], beside[PATH_MAX + 8];
  const size_t size = encode(reference, bytes);
  const bool known = input_file_place(path, place);
  snprintf(beside, sizeof beside, "%s.new", place);
  FILE* file = known ? fopen(beside, "wb") : NULL;
  bool whole = file != NULL && fwrite(bytes, 1, size, file) == size;
  if (file != NULL) whole = fclose(file) == 0 && whole;
  if (whole && rename(beside, place) == 0) return LAM_OK;
  snprintf(error, 112, "%.60s: %s", path, strerror(errno));
  return LAM_HARDWARE;
}
