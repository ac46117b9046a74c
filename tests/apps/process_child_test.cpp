// A program of ours that is waited for: in vain, it is said for what, how long, and what to do.
#include "apps/process_child.h"

#include <gtest/gtest.h>

#include "io/expect_error.h"

namespace lamella::apps {
namespace {

TEST(ChildProcess, ThatIsNotReadyInTimeIsNamedWithItsWorkTheSecondsAndWhatToDo) {
  const PrivateFolder folder;
  ChildProcess child("lamella twin", {"/bin/sleep", "60"}, folder.path());
  const std::string line = testing::complaint([&] {
    child.wait_for_line({"serving ", 0.25, "working out its skin"}, [] { return false; });
  });
  EXPECT_EQ(line,
            "lamella twin: still working out its skin after 0.25 s; this computer may be too busy "
            "for it: end other work, then try again");
}

TEST(ChildProcess, IsNotNamedAsWhatWasInterrupted) {
  const PrivateFolder folder;
  ChildProcess child("lamella twin", {"/bin/sleep", "60"}, folder.path());
  EXPECT_EQ(testing::complaint([&] {
              child.wait_for_line({"serving ", 60, "working out its skin"}, [] { return true; });
            }),
            "interrupted, nothing was kept");
}

TEST(ChildProcess, ThatIsReadySaysTheRestOfItsLine) {
  const PrivateFolder folder;
  ChildProcess child("echo", {"/bin/echo", "serving here"}, folder.path());
  EXPECT_EQ(child.wait_for_line({"serving ", 60, "starting"}, [] { return false; }), "here");
}

}  // namespace
}  // namespace lamella::apps
