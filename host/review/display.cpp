#include "review/display.h"

#include <unistd.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "base/error.h"
#include "io/whole_file.h"

namespace lamella::review {

namespace {

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value && *value;
}

// The arguments of this process, as the kernel keeps them.
std::vector<std::string> own_command_line() {
  std::vector<std::string> words(1);
  for (char c : read_text("/proc/self/cmdline")) {
    if (c == '\0') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  words.pop_back();
  return words;
}

}  // namespace

void ensure_display() {
  if (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")) return;
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  // A server that its last client leaves would begin anew and signal so, which xvfb-run, about to
  // end, takes for a failure of its own: 5 instead of our exit code.
  std::vector<std::string> words{"xvfb-run", "-a", "-s", "-screen 0 64x64x24 -noreset", self};
  const std::vector<std::string> own = own_command_line();
  words.insert(words.end(), own.begin() + 1, own.end());
  std::vector<char*> raw;
  for (std::string& w : words) raw.push_back(w.data());
  raw.push_back(nullptr);
  execvp(raw[0], raw.data());
  throw_bad_input("DISPLAY", "not set, and xvfb-run is not there to stand in for a screen",
                  "apt install xvfb xauth");
}

}  // namespace lamella::review
