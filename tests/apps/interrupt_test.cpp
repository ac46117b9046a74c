// ^C in the middle of long work leaves nothing half-written.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "apps/process_child.h"
#include "apps/process_interrupt.h"
#include "apps/run_lamella.h"
#include "io/fake_session.h"
#include "io/whole_file.h"

namespace lamella::apps {
namespace {

// What a child leaves in `folder` that is interrupted while it writes a folder and a file.
int interrupted_while_writing(const fs::path& folder, int signal_number) {
  const pid_t child = fork();
  if (child == 0) {
    abandon_outputs_on_interrupt();
    const WholeFolder fit(folder / "deep" / "fit", "layers.json");
    std::ofstream(fit.path() / "position.exr") << "half";
    write_whole_file(folder / "image.exr", [&](const fs::path& temporary) {
      std::ofstream(temporary) << "half";
      kill(getpid(), signal_number);
      pause();
    });
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

TEST(Interrupt, EndsTheProgramAsItWouldHaveAndLeavesNothingHalfWritten) {
  for (int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
    const testing::ScratchFolder scratch;
    EXPECT_EQ(interrupted_while_writing(scratch.path(), signal_number), signal_number);
    EXPECT_TRUE(scratch.contents().empty());
  }
}

// A run that is killed while it writes `file`.
void be_killed_while_writing(const fs::path& file) {
  const pid_t child = fork();
  if (child == 0) {
    write_whole_file(file, [](const fs::path& temporary) {
      std::ofstream(temporary) << "half";
      kill(getpid(), SIGKILL);
    });
  }
  waitpid(child, nullptr, 0);
}

TEST(Interrupt, ThatKillsARunLeavesWhatTheNextOneThatWritesAFileThereRemoves) {
  const testing::ScratchFolder scratch;
  const std::string file = (scratch.path() / "out").string();
  const std::string none = (scratch.path() / "none").string();
  for (const std::vector<std::string>& next : std::vector<std::vector<std::string>>{
           {"render", none, "--view", none, "--out", file},
           {"export", none, "--out", file},
           {"review", none, "--screenshot", file},
           {"rig", "plan", "--rig-file", none, "--svg", file},
           {"rig", "plan", "--rig-file", none, "--vcd", file},
           {"twin", "--subject", "nobody", "--calibration-out", file}}) {
    be_killed_while_writing(file);
    EXPECT_FALSE(scratch.contents().empty());
    const testing::Outcome outcome = testing::run_lamella(next);
    EXPECT_EQ(outcome.err.find("lamella: " + scratch.path().string() +
                               ": removed 1 half-written output that a run that was killed had"),
              0u)
        << next[0] << ": " << outcome.err;
    EXPECT_TRUE(scratch.contents().empty()) << next[0];
  }
}

TEST(Interrupt, IsIgnoredWhereItWasIgnoredBefore) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGHUP, SIG_IGN);  // as nohup does
    abandon_outputs_on_interrupt();
    kill(getpid(), SIGHUP);
    usleep(200000);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
}

// What a command that waits for a rig knows of a signal that it was sent: 1 noted, 0 not; -1 where
// it was ended by it.
int noted(int signal_number, sighandler_t before) {
  const pid_t child = fork();
  if (child == 0) {
    std::signal(signal_number, before);
    catch_interrupts();
    kill(getpid(), signal_number);
    _exit(interrupted());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Interrupt, OfACommandThatWaitsForARigIsNotedUnlessItWasIgnoredBefore) {
  for (int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EQ(noted(signal_number, SIG_DFL), 1) << signal_number;
    EXPECT_EQ(noted(signal_number, SIG_IGN), 0) << signal_number;
  }
}

}  // namespace
}  // namespace lamella::apps
