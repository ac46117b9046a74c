// Numbers of things, in words.
#pragma once

#include <cstdint>
#include <string>

namespace lamella::apps {

// "1 burst", "2 bursts".
inline std::string counted(uint64_t count, const std::string& noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace lamella::apps
