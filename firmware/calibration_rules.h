// What a host asks of the numbers of a calibration (host/io/rig_message.cpp), and whether they are
// those of a rig file.
#ifndef LAMELLA_FIRMWARE_CALIBRATION_RULES_H
#define LAMELLA_FIRMWARE_CALIBRATION_RULES_H

#include "calibration_fields.h"
#include "rig.h"

extern const struct field_group kCameraFields, kLedFields, kPatternFields, kRigFields;

// Every check: false, with what is wrong. The numbers are whole where `numbers_whole` says so.

// A camera or a projector can be one: rotation and size.
bool camera_is_sound(const struct numbers* camera, char why[FIELDS_WHY_CHARS]);

// It is as large as the rig file says, whose keys are `keys`.
bool size_is(const struct numbers* camera, const double size_px[2], const char* keys,
             char why[FIELDS_WHY_CHARS]);

// A unit direction, and the one that the rig file's LED shines from.
bool led_is(const struct numbers* led, const struct led_place* place, char why[FIELDS_WHY_CHARS]);

// What the projector shows is what the calibration says.
bool patterns_are(const struct numbers* patterns, const struct rig* rig,
                  char why[FIELDS_WHY_CHARS]);

// projector_to_led, where it is given: it can be inverted and keeps grey light lit.
bool colours_are_sound(const struct numbers* rig, char why[FIELDS_WHY_CHARS]);

#endif
