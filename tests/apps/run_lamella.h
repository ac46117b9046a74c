// The program itself, run as a user runs it.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace lamella::testing {

struct Outcome {
  int exit_code = -1;    // -1: ended by a signal
  std::string out, err;  // standard output and error

  // Lines of standard error that are not warnings.
  std::vector<std::string> complaints() const;
};

// Runs `lamella` with these arguments, its standard output in a file that is read, or to `out`.
Outcome run_lamella(const std::vector<std::string>& arguments, const char* out = nullptr);

// The same, but interrupted, as by ^C, once `is_time` says so.
Outcome interrupt_lamella(const std::vector<std::string>& arguments,
                          const std::function<bool()>& is_time);

}  // namespace lamella::testing
