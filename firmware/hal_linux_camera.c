#include "hal_linux_camera.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "crc32c.h"
#include "hal_linux_controls.h"
#include "hal_linux_plugin.h"
#include "hal_linux_v4l2.h"

// From the sensor's last row to the frame's arrival here; a busy board takes tens of milliseconds.
static const double kDeliveryUs = 250e3;

struct reader {
  struct linux_camera* camera;
  struct linux_frames frames;
  const struct rig* rig;
  const char* name;
  // `held` came while an earlier shot's frame was looked for; `doubted` where only its sequence
  // says that it is not that shot's, held_for.
  bool holds, doubted;
  unsigned held_for;
  struct linux_frame held;
  bool counted;  // a frame has been taken since arm(), and the last one was:
  uint32_t last_sequence;
  unsigned last_shot;
};

static enum lam_status fail(struct reader* reader, const char* why) {
  snprintf(reader->camera->error, sizeof reader->camera->error, "%s camera: %.140s", reader->name,
           why);
  return LAM_HARDWARE;
}

static enum lam_status dropped(struct reader* reader, const char* why) {
  fail(reader, why);
  return LAM_DROPPED;
}

static enum lam_status check(struct reader* reader, enum lam_status status) {
  if (status != LAM_OK) fail(reader, reader->frames.error);
  return status;
}

static enum lam_status arm(void* self) {
  struct reader* reader = self;
  reader->holds = reader->doubted = reader->counted = false;
  return check(reader, reader->frames.start(reader->frames.self));
}

static void disarm(void* self) {
  struct reader* reader = self;
  reader->holds = false;
  reader->frames.stop(reader->frames.self);
}

static void close_reader(void* self) {
  struct reader* reader = self;
  reader->frames.close(reader->frames.self);
  free(reader);
}

// When a frame of the shot may be stamped, and when it must have arrived.
struct window {
  double from_us, to_us, deadline_us;
};

static struct window window_of(const struct reader* reader, const struct linux_shot* shot) {
  const struct rig* rig = reader->rig;
  const double opened_us = shot->trigger_us + rig->camera_start_delay_us;
  const double closed_us = rig->sensor.edge_triggered
                               ? opened_us + reader->frames.exposure_us
                               : shot->untrigger_us + rig->camera_start_delay_us;
  const double read_out_us = closed_us + rig->camera_readout_us;
  double instant_us = read_out_us;
  if (rig->sensor.stamp == RIG_STAMP_OPENED) instant_us = opened_us;
  if (rig->sensor.stamp == RIG_STAMP_CLOSED) instant_us = closed_us;
  return (struct window){instant_us - rig->camera_guard_us, instant_us + rig->sensor.stamp_late_us,
                         read_out_us + rig->sensor.stamp_late_us + kDeliveryUs};
}

static enum lam_status next_frame(struct reader* reader, double deadline_us,
                                  struct linux_frame* frame, bool* came) {
  *came = reader->holds;
  *frame = reader->held;
  reader->holds = false;
  if (*came) return LAM_OK;
  return check(reader, reader->frames.next(reader->frames.self, deadline_us, frame, came));
}

static enum lam_status timed_out(struct reader* reader, const struct linux_shot* shot) {
  char why[140];
  snprintf(why, sizeof why,
           "no frame of shot %u: it was dropped, or the trigger did not reach the camera",
           shot->number);
  return dropped(reader, why);
}

static void hold(struct reader* reader, const struct linux_frame* frame) {
  reader->held = *frame;
  reader->holds = true;
  reader->doubted = false;
}

// Each pulse makes one frame: how far the camera's count has run ahead of the shots.
static unsigned gap_before(const struct reader* reader, const struct linux_shot* shot,
                           const struct linux_frame* frame) {
  const uint32_t frames = frame->sequence - reader->last_sequence;
  const unsigned shots = shot->number - reader->last_shot;
  return reader->counted && frames > shots ? frames - shots : 0;
}

static void count(struct reader* reader, unsigned shot, const struct linux_frame* frame) {
  reader->counted = true;
  reader->last_sequence = frame->sequence;
  reader->last_shot = shot;
}

// The frame is of a later shot, and is kept for it.
static enum lam_status was_dropped(struct reader* reader, const struct linux_shot* shot,
                                   const struct linux_frame* frame, double late_us) {
  char why[140], gap[48] = "";
  const unsigned missing = gap_before(reader, shot, frame);
  if (missing > 0) snprintf(gap, sizeof gap, ", a gap of %u in the sequence", missing);
  hold(reader, frame);
  snprintf(why, sizeof why,
           "the frame of shot %u was dropped%s: the next, number %u, is stamped %.0f us too late",
           shot->number, gap, frame->sequence, late_us);
  return dropped(reader, why);
}

// A frame from before the shot. If its number was in doubt, its stamp has told now that it was that
// earlier shot's.
static enum lam_status pass_over(struct reader* reader, const struct linux_frame* frame) {
  if (reader->doubted) count(reader, reader->held_for, frame);
  reader->doubted = false;
  return check(reader, reader->frames.give_back(reader->frames.self, frame));
}

// The first frame whose stamp is not before the window. Earlier ones are of no shot, or of one that
// was given up.
static enum lam_status find_frame(struct reader* reader, const struct linux_shot* shot,
                                  struct linux_frame* frame) {
  const struct window window = window_of(reader, shot);
  for (;;) {
    bool came = false;
    const enum lam_status status = next_frame(reader, window.deadline_us, frame, &came);
    if (status != LAM_OK) return status;
    if (!came) return timed_out(reader, shot);
    if (frame->stamp_us > window.to_us) {
      return was_dropped(reader, shot, frame, frame->stamp_us - window.to_us);
    }
    if (frame->stamp_us >= window.from_us) return LAM_OK;
    const enum lam_status passed = pass_over(reader, frame);
    if (passed != LAM_OK) return passed;
  }
}

// The stamp fits, the number is a later shot's: where stamps come late they fit more than one shot.
// The frame is kept for the shot that its number says.
static enum lam_status doubt(struct reader* reader, const struct linux_shot* shot,
                             const struct linux_frame* frame, unsigned gap) {
  char why[140];
  hold(reader, frame);
  reader->doubted = true;
  reader->held_for = shot->number;
  snprintf(why, sizeof why, "a gap of %u in the sequence before shot %u: dropped, or not triggered",
           gap, shot->number);
  return dropped(reader, why);
}

static void describe(const struct rig* rig, size_t bytes, struct hal_photograph* photograph) {
  const struct rig_camera* sensor = &rig->sensor;
  lamella_v1_PhotographHeader* header = &photograph->header;
  *header = (lamella_v1_PhotographHeader){
      .width = (uint32_t)sensor->width_px,
      .height = (uint32_t)sensor->height_px,
      .size_bytes = (uint32_t)bytes,
      .crc32c = crc32c_extend(0, photograph->bytes, bytes),
      .black_level_dn = sensor->black_level_dn,
      .gain_per_dn = 1 / (sensor->full_scale_dn - sensor->black_level_dn)};
  snprintf(header->pixel_format, sizeof header->pixel_format, "%s", sensor->format->stored);
}

static enum lam_status develop(struct reader* reader, const struct linux_shot* shot,
                               const struct linux_frame* frame, struct hal_photograph* photograph) {
  const struct rig_camera* sensor = &reader->rig->sensor;
  const size_t size[2] = {(size_t)sensor->width_px, (size_t)sensor->height_px};
  char why[140];
  if (frame->damaged) {
    snprintf(why, sizeof why, "the frame of shot %u is damaged or too short", shot->number);
    return dropped(reader, why);
  }
  if (raw_stored_bytes(size[0], size[1]) > photograph->capacity) {
    return fail(reader, "no room for its photograph: raise store.capacity_bytes");
  }
  const size_t bytes =
      raw_pack(sensor->format, frame->bytes, frame->stride_bytes, size, photograph->bytes);
  describe(reader->rig, bytes, photograph);
  return LAM_OK;
}

static enum lam_status take(struct reader* reader, const struct linux_shot* shot,
                            struct hal_photograph* photograph) {
  struct linux_frame frame;
  const enum lam_status found = find_frame(reader, shot, &frame);
  if (found != LAM_OK) return found;
  const unsigned gap = gap_before(reader, shot, &frame);
  if (gap > 0) return doubt(reader, shot, &frame, gap);
  count(reader, shot->number, &frame);
  reader->doubted = false;
  const enum lam_status status = develop(reader, shot, &frame, photograph);
  const enum lam_status given =
      check(reader, reader->frames.give_back(reader->frames.self, &frame));
  return status != LAM_OK ? status : given;
}

static enum lam_status read_shot(void* self, const struct linux_shot* shot,
                                 struct hal_photograph* photograph) {
  struct reader* reader = self;
  const enum lam_status status = take(reader, shot, photograph);
  if (status != LAM_OK) {
    snprintf(photograph->error, sizeof photograph->error, "%s", reader->camera->error);
  }
  return status;
}

// The name after "v4l2:" or "libcamera:", or NULL where it is neither; and what opens it.
static const char* source_of(const char* name, linux_frames_opener** opener) {
  static const struct {
    const char* prefix;
    linux_frames_opener* open;
  } kSources[] = {{"v4l2:", linux_v4l2_open}, {"libcamera:", linux_plugin_open}};
  for (size_t i = 0; i < sizeof kSources / sizeof kSources[0]; i++) {
    const size_t length = strlen(kSources[i].prefix);
    *opener = kSources[i].open;
    if (strncmp(name, kSources[i].prefix, length) == 0) return name + length;
  }
  return NULL;
}

// The exposure that an edge triggers is as long as the projector's light, which the planner makes
// every exposure of such a rig (burst.c). libcamera has set it by now.
static enum lam_status expose(struct reader* reader, const char* controls,
                              const struct linux_frames_wish* wish) {
  if (wish->exposure_us <= 0 || reader->frames.exposure_us > 0) return LAM_OK;
  if (reader->rig->sensor.exposure_step_us <= 0) {
    snprintf(reader->frames.error, sizeof reader->frames.error,
             "an edge-triggered one needs camera.exposure_step_us in the rig file");
    return LAM_BAD_INPUT;
  }
  return linux_controls_expose(controls, reader->rig->sensor.exposure_step_us, wish->exposure_us,
                               &reader->frames.exposure_us, reader->frames.error);
}

static enum lam_status open_reader(struct reader* reader, unsigned index) {
  const struct rig* rig = reader->rig;
  const struct rig_linux* board = &rig->board;
  const char* given = index == 0 ? board->camera_left_controls : board->camera_right_controls;
  linux_frames_opener* open = NULL;
  const struct linux_frames_wish wish = {
      .device = source_of(index == 0 ? board->camera_left : board->camera_right, &open),
      .format_name = rig->sensor.format->name,
      .fourcc = rig->sensor.format->fourcc,
      .width = (uint32_t)rig->sensor.width_px,
      .height = (uint32_t)rig->sensor.height_px,
      .row_bytes = (uint32_t)raw_row_bytes(rig->sensor.format, (size_t)rig->sensor.width_px),
      .exposure_us = rig->sensor.edge_triggered ? rig_projector_light_us(rig) : 0};
  if (wish.device == NULL) return fail(reader, "is neither v4l2:DEVICE nor libcamera:ID");
  const char* controls = *given != '\0' ? given : wish.device;
  enum lam_status status =
      linux_controls_trigger(controls, board->camera_trigger, reader->frames.error);
  if (status == LAM_OK) status = open(&reader->frames, &wish);
  if (status != LAM_OK) return check(reader, status);
  status = check(reader, expose(reader, controls, &wish));
  if (status != LAM_OK) reader->frames.close(reader->frames.self);
  return status;
}

enum lam_status linux_camera_open(struct linux_camera* camera, const struct rig* rig,
                                  unsigned index) {
  struct reader* reader = calloc(1, sizeof *reader);
  *camera = (struct linux_camera){
      .self = reader, .arm = arm, .read = read_shot, .disarm = disarm, .close = close_reader};
  if (reader == NULL) {
    snprintf(camera->error, sizeof camera->error, "no memory for a camera");
    return LAM_HARDWARE;
  }
  *reader = (struct reader){.camera = camera, .rig = rig, .name = index == 0 ? "left" : "right"};
  const enum lam_status status = open_reader(reader, index);
  if (status == LAM_OK) {
    camera->exposure_us = reader->frames.exposure_us;
    return LAM_OK;
  }
  free(reader);
  camera->self = NULL;
  return status;
}
