#include "rig_process.h"

#include <csignal>

#include "fake_twin.h"
#include "test_host.h"

namespace lamella::testing {

struct TestTwin::Inside {
  FakeTwin twin;
};

TestTwin::TestTwin(int rows) : inside_(new Inside{FakeTwin(rows)}) {}
TestTwin::~TestTwin() = default;
const std::string& TestTwin::path() const { return inside_->twin.path(); }

struct RigUnderTest::Inside {
  explicit Inside(std::vector<std::string> arguments) : process(std::move(arguments)) {}
  RigProcess process;
  int port = 0;
};

RigUnderTest::RigUnderTest(std::vector<std::string> arguments) {
  const std::vector<std::string> always = {"--hal", "sim", "--rig", LAMELLA_BOARD_DIR "/sim.rig"};
  arguments.insert(arguments.begin(), always.begin(), always.end());
  inside_ = std::make_unique<Inside>(last_of_each(std::move(arguments)));
}

RigUnderTest::~RigUnderTest() = default;

int RigUnderTest::port() {
  if (inside_->port == 0) inside_->port = inside_->process.port();
  return inside_->port;
}

pid_t RigUnderTest::pid() const { return inside_->process.pid(); }

void RigUnderTest::kill() {
  inside_->process.signal(SIGKILL);
  inside_->process.exit_code();
}

std::string RigUnderTest::error_line(const std::string& part) {
  return inside_->process.error_line(part);
}

}  // namespace lamella::testing
