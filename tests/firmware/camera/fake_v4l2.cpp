#include "fake_v4l2.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstdarg>
#include <cstring>

FakeV4l2 fake_v4l2;

namespace {

constexpr int kVideoFd = 10000, kFileFd = 20000;
FakeV4l2& fake = fake_v4l2;
std::string file_text;

bool is_fake(int fd) { return fd >= kVideoFd; }

bool fails(const std::string& what) {
  fake.called.push_back(what);
  if (fake.calls++ != fake.failing_call) return false;
  errno = fake.failing_errno;
  return true;
}

int no(int why) {
  errno = why;
  return -1;
}

int query_control(v4l2_query_ext_ctrl* query) {
  const uint32_t asked = query->id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
  const bool next_one = query->id & V4L2_CTRL_FLAG_NEXT_CTRL;
  const std::pair<const std::string, FakeControl>* next = nullptr;
  for (const auto& entry : fake.controls) {
    const bool fits = next_one ? entry.second.id > asked : entry.second.id == asked;
    if (fits && (!next || entry.second.id < next->second.id)) next = &entry;
  }
  if (!next) return no(EINVAL);
  query->id = next->second.id;
  std::strncpy(query->name, next->first.c_str(), sizeof query->name - 1);
  return 0;
}

int control(v4l2_control* asked, bool set) {
  for (auto& [name, known] : fake.controls) {
    if (known.id != asked->id) continue;
    if (set && !known.stuck) known.value = asked->value;
    if (!set) asked->value = known.value;
    return 0;
  }
  return no(EINVAL);
}

int set_format(v4l2_pix_format* pixels) {
  if (fake.fourcc) pixels->pixelformat = fake.fourcc;
  if (fake.width) pixels->width = fake.width;
  if (fake.height) pixels->height = fake.height;
  pixels->bytesperline = fake.stride;
  pixels->sizeimage = fake.buffer_bytes;
  return 0;
}

int dequeue(v4l2_buffer* buffer) {
  if (fake.frames.empty() || fake.queued.empty()) return no(EAGAIN);
  const FakeFrame frame = fake.frames.front();
  fake.frames.pop_front();
  buffer->index = fake.queued.front();
  fake.queued.pop_front();
  std::copy(frame.bytes.begin(), frame.bytes.end(), fake.buffers[buffer->index].begin());
  buffer->bytesused = uint32_t(frame.bytes.size());
  buffer->sequence = frame.sequence;
  buffer->timestamp.tv_sec = long(frame.stamp_us / 1e6);
  buffer->timestamp.tv_usec = long(frame.stamp_us - double(buffer->timestamp.tv_sec) * 1e6);
  buffer->flags = frame.flags | V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  return 0;
}

int answer(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP:
      static_cast<v4l2_capability*>(argument)->capabilities =
          fake.capabilities ? fake.capabilities : V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      return 0;
    case VIDIOC_S_FMT:
      return set_format(&static_cast<v4l2_format*>(argument)->fmt.pix);
    case VIDIOC_REQBUFS: {
      auto* wish = static_cast<v4l2_requestbuffers*>(argument);
      wish->count = std::min(wish->count, fake.most_buffers);
      fake.buffers.assign(wish->count, std::vector<uint8_t>(fake.buffer_bytes));
      return 0;
    }
    case VIDIOC_QUERYBUF: {
      auto* buffer = static_cast<v4l2_buffer*>(argument);
      buffer->length = uint32_t(fake.buffer_bytes);
      buffer->m.offset = buffer->index;
      return 0;
    }
    case VIDIOC_QBUF:
      fake.queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return dequeue(static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      fake.streams = true;
      return 0;
    case VIDIOC_STREAMOFF:
      fake.streams = false;
      fake.queued.clear();
      return 0;
    case VIDIOC_QUERY_EXT_CTRL:
      return query_control(static_cast<v4l2_query_ext_ctrl*>(argument));
    case VIDIOC_S_CTRL:
      return control(static_cast<v4l2_control*>(argument), true);
    case VIDIOC_G_CTRL:
      return control(static_cast<v4l2_control*>(argument), false);
    default:
      return no(ENOTTY);
  }
}

std::string name_of(unsigned long request) {
  const std::map<unsigned long, std::string> names = {{VIDIOC_QUERYCAP, "QUERYCAP"},
                                                      {VIDIOC_S_FMT, "S_FMT"},
                                                      {VIDIOC_REQBUFS, "REQBUFS"},
                                                      {VIDIOC_QUERYBUF, "QUERYBUF"},
                                                      {VIDIOC_QBUF, "QBUF"},
                                                      {VIDIOC_DQBUF, "DQBUF"},
                                                      {VIDIOC_STREAMON, "STREAMON"},
                                                      {VIDIOC_STREAMOFF, "STREAMOFF"},
                                                      {VIDIOC_QUERY_EXT_CTRL, "QUERY"},
                                                      {VIDIOC_S_CTRL, "S_CTRL"},
                                                      {VIDIOC_G_CTRL, "G_CTRL"}};
  const auto found = names.find(request);
  return found == names.end() ? "?" : found->second;
}

}  // namespace

extern "C" {
int __real_open(const char*, int, ...);
int __real_close(int);
ssize_t __real_read(int, void*, size_t);
int __real_ioctl(int, unsigned long, ...);
int __real_poll(struct pollfd*, nfds_t, int);
void* __real_mmap(void*, size_t, int, int, int, off_t);
int __real_munmap(void*, size_t);

int __wrap_open(const char* path, int flags, ...) {
  const std::string name = path;
  const bool video = name.rfind("/dev/video", 0) == 0 || name.rfind("/dev/v4l", 0) == 0;
  if (!video && name.rfind("/sys/module/", 0) != 0) {
    va_list rest;
    va_start(rest, flags);
    const int mode = flags & O_CREAT ? va_arg(rest, int) : 0;
    va_end(rest);
    return __real_open(path, flags, mode);
  }
  if (fails("open")) return -1;
  if (!video && !fake.files.count(name)) return no(ENOENT);
  if (!video) file_text = fake.files[name];
  fake.open_files++;
  return video ? kVideoFd : kFileFd;
}

int __wrap_close(int fd) {
  if (!is_fake(fd)) return __real_close(fd);
  fake.open_files--;
  return 0;
}

ssize_t __wrap_read(int fd, void* to, size_t size) {
  if (!is_fake(fd)) return __real_read(fd, to, size);
  if (fails("read")) return -1;
  const size_t count = std::min(size, file_text.size());
  std::memcpy(to, file_text.data(), count);
  return ssize_t(count);
}

int __wrap_ioctl(int fd, unsigned long request, ...) {
  va_list rest;
  va_start(rest, request);
  void* argument = va_arg(rest, void*);
  va_end(rest);
  if (!is_fake(fd)) return __real_ioctl(fd, request, argument);
  return fails(name_of(request)) ? -1 : answer(request, argument);
}

int __wrap_poll(struct pollfd* entries, nfds_t count, int timeout_ms) {
  if (count == 0 || !is_fake(entries[0].fd)) return __real_poll(entries, count, timeout_ms);
  if (fails("poll")) return -1;
  entries[0].revents = fake.poll_events ? fake.poll_events : short(POLLIN);
  return fake.poll_events || !fake.frames.empty();
}

void* __wrap_mmap(void* at, size_t size, int protection, int flags, int fd, off_t offset) {
  if (!is_fake(fd)) return __real_mmap(at, size, protection, flags, fd, offset);
  if (fails("mmap")) return MAP_FAILED;
  fake.mappings++;
  return fake.buffers[size_t(offset)].data();
}

int __wrap_munmap(void* at, size_t size) {
  for (const auto& buffer : fake.buffers) {
    if (buffer.data() != at) continue;
    fake.mappings--;
    return 0;
  }
  return __real_munmap(at, size);
}

void* __real_calloc(size_t count, size_t size);
void* __wrap_calloc(size_t count, size_t size) {
  return fake.no_memory ? nullptr : __real_calloc(count, size);
}

void* __real_dlopen(const char* path, int flags);
void* __wrap_dlopen(const char* path, int flags) {
  return fake.plugin.open != nullptr ? &fake.plugin : __real_dlopen(path, flags);
}

void* __real_dlsym(void* library, const char* name);
void* __wrap_dlsym(void* library, const char* name) {
  return library == &fake.plugin ? library : __real_dlsym(library, name);
}

int __real_dlclose(void* library);
int __wrap_dlclose(void* library) { return library == &fake.plugin ? 0 : __real_dlclose(library); }
}
