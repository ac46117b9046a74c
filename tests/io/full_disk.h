// A disk that takes no more: files may not grow beyond a size.
#pragma once

#include <sys/resource.h>

#include <csignal>

namespace lamella::testing {

// While it lives; what is refused is an error, not the signal's end of the process.
class FullDisk {
 public:
  explicit FullDisk(rlim_t most_bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{most_bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, SIG_DFL);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_;
};

}  // namespace lamella::testing
