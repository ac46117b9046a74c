// What the host's fuzz targets share: bytes as a file, and the one exception that bad input may
// cause.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/error.h"

namespace lamella::fuzz {

// Bytes as a file that lives in memory.
class MemoryFile {
 public:
  MemoryFile(const uint8_t* bytes, size_t size) : fd_(memfd_create("fuzz", MFD_CLOEXEC)) {
    if (fd_ < 0 || write(fd_, bytes, size) != ssize_t(size)) std::abort();
  }
  ~MemoryFile() { close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

// Any other exception than an Error of one line is a fault.
template <class Read>
void expect_error_or_nothing(const Read& read) {
  try {
    read();
  } catch (const Error& e) {
    const std::string line = e.what();
    if (line.empty() || line.find('\n') != std::string::npos) std::abort();
  }
}

}  // namespace lamella::fuzz
