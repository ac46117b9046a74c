// What the projector shows: every pattern of a burst as pixels, from the rig file's numbers alone.
// The values are those of PROTOCOL.md ("Patterns"); the pixels are the codes, full range, whose
// light is nearest to them on the projector's transfer curve.
#ifndef LAMELLA_FIRMWARE_PATTERN_H
#define LAMELLA_FIRMWARE_PATTERN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "hal.h"
#include "proto/session.pb.h"
#include "rig.h"

enum { PATTERN_IMAGES = PATTERN_FRINGES + PATTERN_STRIPES + 3 };

// The image, 0 to PATTERN_IMAGES - 1, that a pattern is shown by; PATTERN_IMAGES where there is no
// such pattern. A dark projector (lamp shuttered) shows black's image.
size_t pattern_image(struct hal_pattern pattern);

// The pattern of an image, and its name for people: "fringe 2".
struct hal_pattern pattern_of_image(size_t image);
void pattern_name(struct hal_pattern pattern, char name[16]);

// Writes projector_height_px rows of projector_width_px pixels, each 0x00RRGGBB, a row every
// `stride_px` pixels. The image exists.
void pattern_draw(const struct rig* rig, size_t image, uint32_t* pixels, size_t stride_px);

// What a host is told: it must be what the calibration says.
void pattern_describe(const struct rig* rig, lamella_v1_Patterns* patterns);

// False, with a reason, where no projector of this size can draw the rig file's patterns.
bool pattern_can_be_drawn(const struct rig* rig, char error[160]);

#endif
