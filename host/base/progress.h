// Progress of long work: a line that renews itself on a terminal, silence in a log.
#pragma once

#include <chrono>
#include <string>

namespace lamella {

class Progress {
 public:
  // `what` is a short noun phrase, `total` the number of units of work.
  Progress(std::string what, int total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // May be called from one thread at a time.
  void advance(int done);

 private:
  std::string what_;
  int total_;
  bool visible_;
  std::chrono::steady_clock::time_point last_;
};

// Seconds since construction, monotonic.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace lamella
