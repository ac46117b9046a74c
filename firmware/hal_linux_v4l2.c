#include "hal_linux_v4l2.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "hal_linux_time.h"

// What the collector may be behind by while it writes to a disk, before frames are dropped.
enum { kBuffers = 8, kFewestBuffers = 2 };

struct stream {
  struct linux_frames* frames;
  int fd;
  char device[32];
  uint32_t stride_bytes, frame_bytes, row_bytes, height;
  struct {
    void* bytes;
    size_t size;
  } buffers[kBuffers];
  uint32_t buffer_count;
  bool streams;
};

static enum lam_status fail(struct stream* stream, const char* what) {
  snprintf(stream->frames->error, sizeof stream->frames->error, "%s: %s: %s", stream->device, what,
           strerror(errno));
  return LAM_HARDWARE;
}

static enum lam_status refuse(struct stream* stream, const char* what) {
  snprintf(stream->frames->error, sizeof stream->frames->error, "%s: %s", stream->device, what);
  return LAM_HARDWARE;
}

static int ask(const struct stream* stream, unsigned long request, void* argument) {
  int result;
  do {
    result = ioctl(stream->fd, request, argument);
  } while (result != 0 && errno == EINTR);
  return result;
}

static enum lam_status check_kind(struct stream* stream) {
  struct v4l2_capability device = {0};
  if (ask(stream, VIDIOC_QUERYCAP, &device) != 0) return fail(stream, "is no video device");
  const uint32_t can =
      device.capabilities & V4L2_CAP_DEVICE_CAPS ? device.device_caps : device.capabilities;
  if (can & V4L2_CAP_VIDEO_CAPTURE && can & V4L2_CAP_STREAMING) return LAM_OK;
  return refuse(stream, "captures no single-planar stream: use libcamera for this camera");
}

static enum lam_status set_format(struct stream* stream, const struct linux_frames_wish* wish) {
  struct v4l2_format format = {.type = V4L2_BUF_TYPE_VIDEO_CAPTURE};
  struct v4l2_pix_format* pixels = &format.fmt.pix;
  pixels->width = wish->width;
  pixels->height = wish->height;
  pixels->pixelformat = wish->fourcc;
  pixels->field = V4L2_FIELD_NONE;
  if (ask(stream, VIDIOC_S_FMT, &format) != 0) return fail(stream, "the format cannot be set");
  if (pixels->width != wish->width || pixels->height != wish->height ||
      pixels->pixelformat != wish->fourcc) {
    snprintf(stream->frames->error, sizeof stream->frames->error,
             "%s: gives %ux%u %.4s where camera.format asks for %ux%u %s", stream->device,
             pixels->width, pixels->height, (const char*)&pixels->pixelformat, wish->width,
             wish->height, wish->format_name);
    return LAM_HARDWARE;
  }
  stream->stride_bytes = pixels->bytesperline > 0 ? pixels->bytesperline : wish->row_bytes;
  stream->row_bytes = wish->row_bytes;
  stream->height = wish->height;
  if (stream->stride_bytes >= wish->row_bytes) return LAM_OK;
  return refuse(stream, "its rows are shorter than its pixels");
}

static enum lam_status map_buffer(struct stream* stream, uint32_t index) {
  struct v4l2_buffer buffer = {
      .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP, .index = index};
  if (ask(stream, VIDIOC_QUERYBUF, &buffer) != 0) return fail(stream, "a buffer is not there");
  void* bytes = mmap(NULL, buffer.length, PROT_READ, MAP_SHARED, stream->fd, buffer.m.offset);
  if (bytes == MAP_FAILED) return fail(stream, "a buffer cannot be mapped");
  stream->buffers[index].bytes = bytes;
  stream->buffers[index].size = buffer.length;
  stream->buffer_count = index + 1;
  return LAM_OK;
}

static enum lam_status map_buffers(struct stream* stream) {
  struct v4l2_requestbuffers request = {
      .count = kBuffers, .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
  if (ask(stream, VIDIOC_REQBUFS, &request) != 0) return fail(stream, "no buffers");
  const uint32_t count = request.count < kBuffers ? request.count : kBuffers;
  if (count < kFewestBuffers) return refuse(stream, "fewer than two buffers: too little memory");
  for (uint32_t i = 0; i < count; i++) {
    const enum lam_status status = map_buffer(stream, i);
    if (status != LAM_OK) return status;
  }
  return LAM_OK;
}

static enum lam_status queue(struct stream* stream, uint32_t index) {
  struct v4l2_buffer buffer = {
      .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP, .index = index};
  return ask(stream, VIDIOC_QBUF, &buffer) == 0 ? LAM_OK
                                                : fail(stream, "a buffer cannot be queued");
}

static void stop(void* self) {
  struct stream* stream = self;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  // Nothing depends on its success: the descriptor is closed, or the stream started, next.
  if (stream->streams) ask(stream, VIDIOC_STREAMOFF, &type);
  stream->streams = false;
}

static enum lam_status start(void* self) {
  struct stream* stream = self;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  stop(stream);
  for (uint32_t i = 0; i < stream->buffer_count; i++) {
    const enum lam_status status = queue(stream, i);
    if (status != LAM_OK) return status;
  }
  if (ask(stream, VIDIOC_STREAMON, &type) != 0) return fail(stream, "does not stream");
  stream->streams = true;
  return LAM_OK;
}

// Whether a buffer is filled before deadline_us; one that is filled already counts after it too.
static enum lam_status wait_for_buffer(struct stream* stream, double deadline_us, bool* came) {
  for (;;) {
    const double left_us = deadline_us - linux_now_us();
    const int left_ms = left_us > 0 ? (int)(left_us / 1e3) + 1 : 0;
    struct pollfd entry = {.fd = stream->fd, .events = POLLIN};
    const int ready = poll(&entry, 1, left_ms);
    if (ready < 0 && errno == EINTR) continue;
    if (ready < 0) return fail(stream, "waiting for a frame");
    if (ready > 0 && !(entry.revents & POLLIN)) {
      return refuse(stream, "is gone, or has stopped to stream");
    }
    *came = ready > 0;
    return LAM_OK;
  }
}

static enum lam_status take_buffer(struct stream* stream, struct v4l2_buffer* buffer,
                                   struct linux_frame* frame) {
  if (buffer->index >= stream->buffer_count) return refuse(stream, "an unknown buffer came");
  // Whatever clock its driver says, and some say none: a stamp of another one fits no shot.
  const size_t needed = (size_t)stream->stride_bytes * (stream->height - 1) + stream->row_bytes;
  const size_t there = stream->buffers[buffer->index].size;
  *frame = (struct linux_frame){
      .bytes = stream->buffers[buffer->index].bytes,
      .size_bytes = buffer->bytesused < there ? buffer->bytesused : there,
      .stride_bytes = stream->stride_bytes,
      .sequence = buffer->sequence,
      .stamp_us = (double)buffer->timestamp.tv_sec * 1e6 + (double)buffer->timestamp.tv_usec,
      .slot = buffer->index};
  frame->damaged = buffer->flags & V4L2_BUF_FLAG_ERROR || frame->size_bytes < needed;
  return LAM_OK;
}

static enum lam_status next(void* self, double deadline_us, struct linux_frame* frame, bool* came) {
  struct stream* stream = self;
  for (;;) {
    const enum lam_status status = wait_for_buffer(stream, deadline_us, came);
    if (status != LAM_OK || !*came) return status;
    struct v4l2_buffer buffer = {.type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
    if (ask(stream, VIDIOC_DQBUF, &buffer) == 0) return take_buffer(stream, &buffer, frame);
    // EAGAIN: what woke us was taken back.
    if (errno != EAGAIN) return fail(stream, "a frame cannot be taken");
    *came = false;
    if (linux_now_us() >= deadline_us) return LAM_OK;
  }
}

static enum lam_status give_back(void* self, const struct linux_frame* frame) {
  return queue(self, frame->slot);
}

static void close_stream(void* self) {
  struct stream* stream = self;
  stop(stream);
  for (uint32_t i = 0; i < stream->buffer_count; i++) {
    munmap(stream->buffers[i].bytes, stream->buffers[i].size);
  }
  close(stream->fd);
  free(stream);
}

static enum lam_status prepare(struct stream* stream, const struct linux_frames_wish* wish) {
  enum lam_status status = check_kind(stream);
  if (status == LAM_OK) status = set_format(stream, wish);
  if (status == LAM_OK) status = map_buffers(stream);
  return status;
}

enum lam_status linux_v4l2_open(struct linux_frames* frames, const struct linux_frames_wish* wish) {
  *frames = (struct linux_frames){
      .start = start, .next = next, .give_back = give_back, .stop = stop, .close = close_stream};
  struct stream* stream = calloc(1, sizeof *stream);
  if (stream == NULL) return LAM_HARDWARE;
  stream->frames = frames;
  snprintf(stream->device, sizeof stream->device, "%s", wish->device);
  stream->fd = open(wish->device, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (stream->fd < 0) {
    fail(stream, "cannot be opened");
    free(stream);
    return LAM_HARDWARE;
  }
  const enum lam_status status = prepare(stream, wish);
  if (status != LAM_OK) close_stream(stream);
  frames->self = status == LAM_OK ? stream : NULL;
  return status;
}
