// The firmware's pixels for the twin's tests. Firmware and host have headers of the same names, so
// only this file's source sees the firmware's.
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// `kind` is a PatternSpan.Kind; `width` x `height` pixels are written, 0x00RRGGBB. Returns
// projector.gamma, or 0 where the rig file is not of this size or has no such pattern.
double drawn_by_firmware(const char* rig_file, size_t length, const int pattern[2],
                         const size_t size[2], uint32_t* pixels);

#ifdef __cplusplus
}
#endif
