// How each LED alone lights what the cameras see: learned on a rig that is known to be good, with
// the stage as it is when it tests itself (nobody in the chair), and compared with ever after.
#ifndef LAMELLA_FIRMWARE_LED_REFERENCE_H
#define LAMELLA_FIRMWARE_LED_REFERENCE_H

#include "hal.h"
#include "rig.h"

enum {
  SIGNATURE_SIDE = 4,  // a photograph is weighed with 4 x 4 overlapping tents
  SIGNATURE_SIZE = 2 * SIGNATURE_SIDE * SIGNATURE_SIDE,  // both cameras
};

// Means of raw values above black, in dn, by camera and tent.
struct led_signature {
  double dn[SIGNATURE_SIZE];
};

struct led_reference {
  uint32_t led_count;  // 0: not learned
  struct led_signature leds[RIG_MAX_LEDS];
};

// Puts one camera's photograph into its half. False for what is no photograph of 12-bit samples.
bool led_signature_take(struct led_signature* signature, unsigned camera,
                        const struct hal_photograph* photograph);

double led_signature_norm(const struct led_signature* signature);
// Norm of a - b.
double led_signature_distance(const struct led_signature* a, const struct led_signature* b);
// a += factor * b.
void led_signature_add(struct led_signature* a, double factor, const struct led_signature* b);

// A file's bytes, checked; false for what is none, or is of a rig with another number of LEDs.
bool led_reference_parse(const uint8_t* bytes, size_t size, size_t led_count,
                         struct led_reference* reference);
// LAM_OK, or LAM_BAD_INPUT with a reason. No file at all is a reference that is not learned.
enum lam_status led_reference_read(const char* path, size_t led_count,
                                   struct led_reference* reference, char error[112]);
// Appears whole or not at all.
enum lam_status led_reference_write(const char* path, const struct led_reference* reference,
                                    char error[112]);

#endif
