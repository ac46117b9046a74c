// The twin on a local socket: every ExposureReport is answered with the photograph of what
// happened. Framing and order are in proto/PROTOCOL.md.
#pragma once

#include <filesystem>
#include <functional>

#include "twin/studio.h"

namespace lamella::twin {

// A listening Unix socket, removed again with the object.
class LocalListener {
 public:
  // Throws Error where the path is taken or cannot be used.
  explicit LocalListener(std::filesystem::path path);
  ~LocalListener();
  LocalListener(const LocalListener&) = delete;
  LocalListener& operator=(const LocalListener&) = delete;

  // The next connection's descriptor, or -1 when `interrupted` says so.
  int accept(const std::function<bool()>& interrupted) const;

 private:
  std::filesystem::path path_;
  int fd_ = -1;
};

// Answers one connection after another until interrupted.
void serve(const LocalListener& listener, const Photographer& photographer, Studio* studio,
           const std::function<bool()>& interrupted);

}  // namespace lamella::twin
