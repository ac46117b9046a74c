// The plug-in for libcamera's cameras (hal_linux_frames.h): one raw stream, one request a buffer.
// It is compiled against one release of libcamera, whose C++ interface changes with each.
#include <libcamera/libcamera.h>
#include <sys/mman.h>
#include <time.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal_linux_frames.h"

namespace {

using libcamera::FrameBuffer;
using libcamera::Request;

constexpr unsigned kBuffers = 8;

double clock_us(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return double(now.tv_sec) * 1e6 + double(now.tv_nsec) * 1e-3;
}

// libcamera gives up on a camera that is not triggered for a second or so. On a Raspberry Pi a file
// says how long it waits; without it the burst after a pause would find the camera dead.
bool waits_long_enough(std::string* why) {
  const char* file = std::getenv("LIBCAMERA_RPI_CONFIG_FILE");
  std::FILE* config = file ? std::fopen(file, "r") : nullptr;
  char text[4096] = "";
  if (config) {
    text[std::fread(text, 1, sizeof text - 1, config)] = '\0';
    std::fclose(config);
  }
  if (std::strstr(text, "timeout_value_ms")) return true;
  *why = std::string(file ? file : "LIBCAMERA_RPI_CONFIG_FILE") +
         " gives no camera_timeout_value_ms, so it would time out: copy libcamera-pi4.yaml or -pi5";
  return false;
}

// libcamera's name of a format that V4L2 calls `name`: "Y10P" is R10_CSI2P, "SRGGB12" the same.
std::string libcamera_name(std::string name) {
  if (name == "GREY") return "R8";
  if (name.back() == 'P') name.replace(name.size() - 1, 1, "_CSI2P");
  if (name.front() == 'Y') name.front() = 'R';
  return name;
}

class Source {
 public:
  Source(linux_frames* frames, const linux_frames_wish& wish) : frames_(frames), wish_(wish) {}

  ~Source() {
    stop();
    for (const auto& [buffer, bytes] : bytes_) ::munmap(bytes.first, bytes.second);
    requests_.clear();
    allocator_.reset();
    if (camera_) {
      camera_->requestCompleted.disconnect(this);
      camera_->release();
      camera_.reset();
    }
    manager_.stop();
  }

  lam_status open() {
    if (manager_.start() != 0) return fail("libcamera does not start");
    camera_ = manager_.get(wish_.device);
    if (!camera_) return fail("no camera of that name: `cam -l` lists them");
    std::string why;
    const bool pi = std::string(wish_.device).find("/i2c") != std::string::npos;
    if (pi && !waits_long_enough(&why)) return fail(why);
    if (camera_->acquire() != 0) return fail("another program has the camera");
    const lam_status status = configure();
    if (status != LAM_OK) return status;
    camera_->requestCompleted.connect(this, &Source::on_completed);
    return allocate();
  }

  lam_status start() {
    stop();
    libcamera::ControlList controls(camera_->controls());
    controls.set(libcamera::controls::AeEnable, false);
    if (wish_.exposure_us > 0) {
      controls.set(libcamera::controls::ExposureTime, int32_t(wish_.exposure_us));
    }
    // libcamera stamps frames on CLOCK_BOOTTIME, the rig on CLOCK_MONOTONIC.
    boottime_ahead_us_ = clock_us(CLOCK_BOOTTIME) - clock_us(CLOCK_MONOTONIC);
    if (camera_->start(&controls) != 0) return fail("does not start");
    running_ = true;
    for (const auto& request : requests_) {
      request->reuse(Request::ReuseBuffers);
      if (camera_->queueRequest(request.get()) != 0) return fail("a request cannot be queued");
    }
    return LAM_OK;
  }

  void stop() {
    if (running_) camera_->stop();
    running_ = false;
    const std::lock_guard lock(mutex_);
    completed_.clear();
  }

  lam_status next(double deadline_us, linux_frame* frame, bool* came) {
    std::unique_lock lock(mutex_);
    const auto left = std::chrono::microseconds(int64_t(deadline_us - clock_us(CLOCK_MONOTONIC)));
    arrived_.wait_for(lock, left, [&] { return !completed_.empty(); });
    *came = !completed_.empty();
    if (!*came) return LAM_OK;
    Request* request = completed_.front();
    completed_.pop_front();
    return take(request, frame);
  }

  lam_status give_back(uint32_t slot) {
    Request* request = requests_[slot].get();
    request->reuse(Request::ReuseBuffers);
    return camera_->queueRequest(request) == 0 ? LAM_OK : fail("a request cannot be queued");
  }

 private:
  lam_status fail(const std::string& why) {
    std::snprintf(frames_->error, sizeof frames_->error, "%s: %s", wish_.device, why.c_str());
    return LAM_HARDWARE;
  }

  lam_status configure() {
    config_ = camera_->generateConfiguration({libcamera::StreamRole::Raw});
    if (!config_ || config_->empty()) return fail("has no raw stream");
    libcamera::StreamConfiguration& stream = config_->at(0);
    const libcamera::PixelFormat format =
        libcamera::PixelFormat::fromString(libcamera_name(wish_.format_name));
    stream.pixelFormat = format;
    stream.size = {wish_.width, wish_.height};
    stream.bufferCount = kBuffers;
    if (config_->validate() == libcamera::CameraConfiguration::Invalid) {
      return fail("cannot give that format");
    }
    const bool same = stream.pixelFormat == format && stream.size.width == wish_.width &&
                      stream.size.height == wish_.height && stream.stride >= wish_.row_bytes;
    if (!same) return fail("gives " + stream.toString() + ", not camera.format");
    return camera_->configure(config_.get()) == 0 ? LAM_OK : fail("cannot be configured");
  }

  lam_status allocate() {
    libcamera::Stream* stream = config_->at(0).stream();
    allocator_ = std::make_unique<libcamera::FrameBufferAllocator>(camera_);
    if (allocator_->allocate(stream) < 2) return fail("fewer than two buffers: too little memory");
    for (const std::unique_ptr<FrameBuffer>& buffer : allocator_->buffers(stream)) {
      const FrameBuffer::Plane& plane = buffer->planes()[0];
      const size_t size = plane.offset + plane.length;
      void* bytes = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, plane.fd.get(), 0);
      if (bytes == MAP_FAILED) return fail("a buffer cannot be mapped");
      bytes_[buffer.get()] = {bytes, size};
      std::unique_ptr<Request> request = camera_->createRequest(requests_.size());
      if (!request || request->addBuffer(stream, buffer.get()) != 0) return fail("no request");
      requests_.push_back(std::move(request));
    }
    return LAM_OK;
  }

  // On libcamera's own thread.
  void on_completed(Request* request) {
    if (request->status() == Request::RequestCancelled) return;
    const std::lock_guard lock(mutex_);
    completed_.push_back(request);
    arrived_.notify_one();
  }

  lam_status take(Request* request, linux_frame* frame) {
    const FrameBuffer* buffer = request->buffers().begin()->second;
    const libcamera::FrameMetadata& told = buffer->metadata();
    const FrameBuffer::Plane& plane = buffer->planes()[0];
    const auto stamp_ns = request->metadata().get(libcamera::controls::SensorTimestamp);
    if (!stamp_ns) return fail("its frames have no time stamp");
    const auto exposure_us = request->metadata().get(libcamera::controls::ExposureTime);
    *frame = linux_frame{};
    frame->bytes = static_cast<const uint8_t*>(bytes_[buffer].first) + plane.offset;
    frame->size_bytes = told.planes()[0].bytesused;
    frame->stride_bytes = config_->at(0).stride;
    frame->sequence = told.sequence;
    frame->stamp_us = double(*stamp_ns) * 1e-3 - boottime_ahead_us_;
    frame->slot = uint32_t(request->cookie());
    const size_t needed = frame->stride_bytes * (wish_.height - 1) + wish_.row_bytes;
    // An exposure that the sensor did not take is another photograph than was asked for.
    const bool exposed = wish_.exposure_us <= 0 || !exposure_us ||
                         std::abs(double(*exposure_us) - wish_.exposure_us) <= 100;
    frame->damaged = told.status != libcamera::FrameMetadata::FrameSuccess ||
                     frame->size_bytes < needed || !exposed;
    return LAM_OK;
  }

  linux_frames* frames_;
  linux_frames_wish wish_;
  libcamera::CameraManager manager_;
  std::shared_ptr<libcamera::Camera> camera_;
  std::unique_ptr<libcamera::CameraConfiguration> config_;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::map<const FrameBuffer*, std::pair<void*, size_t>> bytes_;
  std::vector<std::unique_ptr<Request>> requests_;
  double boottime_ahead_us_ = 0;
  bool running_ = false;
  std::mutex mutex_;  // completed_
  std::condition_variable arrived_;
  std::deque<Request*> completed_;
};

Source* source(void* self) { return static_cast<Source*>(self); }

lam_status open_source(linux_frames* frames, const linux_frames_wish* wish) {
  *frames = linux_frames{};
  frames->start = [](void* self) { return source(self)->start(); };
  frames->next = [](void* self, double deadline_us, linux_frame* frame, bool* came) {
    return source(self)->next(deadline_us, frame, came);
  };
  frames->give_back = [](void* self, const linux_frame* frame) {
    return source(self)->give_back(frame->slot);
  };
  frames->stop = [](void* self) { source(self)->stop(); };
  frames->close = [](void* self) { delete source(self); };
  auto opened = std::make_unique<Source>(frames, *wish);
  const lam_status status = opened->open();
  if (status != LAM_OK) return status;
  frames->exposure_us = wish->exposure_us;
  frames->self = opened.release();
  return LAM_OK;
}

}  // namespace

extern "C" __attribute__((visibility("default")))
const linux_frames_plugin lamella_frames_plugin = {LINUX_FRAMES_ABI, open_source};
