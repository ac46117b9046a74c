// The one exception of the host, thrown where a command cannot go on and caught in apps/ alone.
#pragma once

#include <stdexcept>
#include <string>

namespace lamella {

enum class Fault {
  kBadInput,  // exit 2: a file, a field or an argument
  kRig,       // exit 3: rig or link
};

// `what()` is one line: where, what is wrong, what to do.
class Error : public std::runtime_error {
 public:
  Error(Fault fault, const std::string& where, const std::string& problem,
        const std::string& remedy = "");

  Fault fault() const { return fault_; }

 private:
  Fault fault_;
};

// Shorthand for the commonest one.
[[noreturn]] void throw_bad_input(const std::string& where, const std::string& problem,
                                  const std::string& remedy = "");

}  // namespace lamella
