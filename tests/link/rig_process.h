// lamella-rigd with a twin beside it, for tests of the host: behind a wall, as messages of nanopb
// and of libprotobuf have the same names.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace lamella::testing {

class TestTwin {
 public:
  explicit TestTwin(int rows);
  ~TestTwin();
  const std::string& path() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

class RigUnderTest {
 public:
  // `arguments` beside the simulated hardware and the rig file.
  explicit RigUnderTest(std::vector<std::string> arguments);
  ~RigUnderTest();

  int port();
  std::string address() { return "127.0.0.1:" + std::to_string(port()); }
  pid_t pid() const;
  void kill();  // as a power cut does
  // Waits for a line on its stderr that has this in it.
  std::string error_line(const std::string& part);

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace lamella::testing
