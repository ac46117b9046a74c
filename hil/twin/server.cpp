#include "twin/server.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/error.h"
#include "io/crc32c.h"
#include "io/wire.h"

namespace lamella::twin {

namespace {

constexpr double kPatience_s = 86400;  // a rig may rest between two bursts
constexpr size_t kLongestError = 120;  // what the firmware has room for (twin.options)

v1::PhotographHeader header_of(const RawPhotograph& photograph, const Camera& camera,
                               const std::vector<uint8_t>& bytes) {
  v1::PhotographHeader header;
  header.set_width(uint32_t(photograph.raw.cols));
  header.set_height(uint32_t(photograph.raw.rows));
  header.set_pixel_format(kRgb12p);
  header.set_size_bytes(uint32_t(bytes.size()));
  header.set_crc32c(crc32c(bytes.data(), bytes.size()));
  header.set_black_level_dn(kBlackLevelDn);
  header.set_gain_per_dn(gain_per_dn(camera));
  for (int c = 0; c < 3; ++c) header.add_radiance_scale(photograph.radiance_scale[c]);
  return header;
}

Break answer(Socket* socket, const v1::ExposureReport& report, const Session& rig, Studio* studio,
             uint64_t serial) {
  const Deadline deadline = deadline_in(kPatience_s);
  try {
    const Exposure exposure = read_exposure(report, int(rig.stage.leds().size()),
                                            int(rig.patterns.fringe_periods.size()));
    const RawPhotograph photograph = studio->take(exposure, serial);
    const std::vector<uint8_t> bytes = pack_rgb12p(photograph.raw);
    const Camera& camera = exposure.camera == 0 ? rig.left : *rig.right;
    if (Break broken = socket->send(header_of(photograph, camera, bytes), deadline)) return broken;
    return socket->send_bytes(bytes.data(), bytes.size(), deadline);
  } catch (const Error& e) {
    v1::PhotographHeader refusal;
    refusal.set_error(std::string(e.what()).substr(0, kLongestError));
    return socket->send(refusal, deadline);
  }
}

}  // namespace

LocalListener::LocalListener(std::filesystem::path path) : path_(std::move(path)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = path_.string();
  if (name.empty() || name.size() >= sizeof address.sun_path) {
    throw_bad_input("--serve", "a socket's path has 1 to 107 characters",
                    "name one in a folder nearer to the root");
  }
  std::memcpy(address.sun_path, name.c_str(), name.size() + 1);
  fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd_ < 0 || ::bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(fd_, 4) != 0) {
    const std::string why = std::strerror(errno);
    if (fd_ >= 0) ::close(fd_);
    throw Error(Fault::kRig, name, why, "choose a path where nothing is yet");
  }
}

LocalListener::~LocalListener() {
  ::close(fd_);
  ::unlink(path_.c_str());
}

int LocalListener::accept(const std::function<bool()>& interrupted) const {
  while (!interrupted()) {
    pollfd entry{fd_, POLLIN, 0};
    if (::poll(&entry, 1, 100) <= 0) continue;
    const int fd = ::accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC);
    if (fd >= 0) return fd;
  }
  return -1;
}

void serve(const LocalListener& listener, const Photographer& photographer, Studio* studio,
           const std::function<bool()>& interrupted) {
  uint64_t serial = 0;
  for (int fd; (fd = listener.accept(interrupted)) >= 0;) {
    Socket socket(fd);
    socket.set_interrupted(interrupted);
    v1::ExposureReport report;
    while (!socket.receive(&report, deadline_in(kPatience_s))) {
      if (answer(&socket, report, photographer.rig(), studio, serial++)) break;
    }
  }
}

}  // namespace lamella::twin
