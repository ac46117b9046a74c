#include "base/progress.h"

#include <unistd.h>

#include <cstdio>

namespace lamella {

Progress::Progress(std::string what, int total)
    : what_(std::move(what)), total_(total), visible_(isatty(STDERR_FILENO)) {
  if (visible_) advance(0);
}

Progress::~Progress() {
  if (visible_) std::fprintf(stderr, "\r\033[K");
}

void Progress::advance(int done) {
  const auto now = std::chrono::steady_clock::now();
  if (!visible_ || (done < total_ && done > 0 && now - last_ < std::chrono::milliseconds(100))) {
    return;
  }
  last_ = now;
  std::fprintf(stderr, "\r\033[K%s %d/%d", what_.c_str(), done, total_);
  std::fflush(stderr);
}

}  // namespace lamella
