// One small C interface to whatever delivers frames: V4L2 (hal_linux_v4l2.h) or libcamera, which is
// a plug-in loaded at run time, as its C++ interface changes with every release. A source knows
// nothing of shots: it hands over what the camera sent, and hal_linux_camera.c tells which is
// which.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_FRAMES_H
#define LAMELLA_FIRMWARE_HAL_LINUX_FRAMES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "status.h"

#ifdef __cplusplus
extern "C" {
#endif

// Counts the changes of everything in this header. A plug-in of another number is not loaded.
enum { LINUX_FRAMES_ABI = 1 };
#define LINUX_FRAMES_PLUGIN "lamella-libcamera.so"
#define LINUX_FRAMES_ENTRY "lamella_frames_plugin"

enum { LINUX_FRAMES_ERROR_CHARS = 160 };

// What a camera is asked for. It does exactly that, or is not opened.
struct linux_frames_wish {
  const char* device;       // "/dev/video0", or libcamera's id
  const char* format_name;  // as V4L2_PIX_FMT_ says it
  uint32_t fourcc;          // of V4L2
  uint32_t width, height;
  uint32_t row_bytes;  // of one row without padding
  double exposure_us;  // 0: the trigger's length is the exposure
};

struct linux_frame {
  const uint8_t* bytes;
  size_t size_bytes, stride_bytes;
  uint32_t sequence;  // counts the camera's frames, those that were dropped too
  double stamp_us;    // CLOCK_MONOTONIC
  bool damaged;       // the driver says that its content is not to be trusted
  uint32_t slot;      // the source's own
};

struct linux_frames {
  void* self;                            // first argument of every call
  char error[LINUX_FRAMES_ERROR_CHARS];  // of the last call that failed
  double exposure_us;                    // what the camera says it was set to; 0: it was not
  enum lam_status (*start)(void* self);  // every buffer is the camera's
  // The next frame, in the camera's order. `came` is false where none did until deadline_us
  // (CLOCK_MONOTONIC): no error yet.
  enum lam_status (*next)(void* self, double deadline_us, struct linux_frame* frame, bool* came);
  // Each frame goes back to the camera before it is short of buffers.
  enum lam_status (*give_back)(void* self, const struct linux_frame* frame);
  void (*stop)(void* self);   // frames that were not given back are lost
  void (*close)(void* self);  // stops too
};

// `frames` must not move while it is open: a source writes its errors there.
typedef enum lam_status linux_frames_opener(struct linux_frames* frames,
                                            const struct linux_frames_wish* wish);

// What a plug-in exports as LINUX_FRAMES_ENTRY. `abi` stays first for ever.
struct linux_frames_plugin {
  uint32_t abi;
  linux_frames_opener* open;
};

#ifdef __cplusplus
}
#endif

#endif
