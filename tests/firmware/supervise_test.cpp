// The supervisor as a process of its own; its lights are a file that it writes to.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

extern "C" {
#include "supervise.h"
}

namespace {

constexpr int kDiedExit = 77;

void note_lights_off(void* context) {
  const int out = *static_cast<int*>(context);
  if (write(out, "off", 3) != 3) _exit(1);
}

bool lit = false;

// The same, and says whether the sequencer still was to be seen.
void note_lights_off_before_the_end(void* context) {
  siginfo_t ended = {};
  waitid(P_ALL, 0, &ended, WEXITED | WNOHANG | WNOWAIT);
  const int out = *static_cast<int*>(context);
  if (ended.si_pid == 0 && write(out, "early ", 6) != 6) _exit(1);
  note_lights_off(context);
}

struct Outcome {
  int exit_code;
  std::string told;
};

// Runs a supervisor whose sequencer does `work`, and then `meanwhile` with the supervisor's number.
Outcome run(void (*work)(), void (*meanwhile)(pid_t) = nullptr,
            void (*lights_off)(void*) = note_lights_off) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t supervisor = fork();
  if (supervisor == 0) {
    for (int s : {SIGTERM, SIGINT, SIGHUP}) signal(s, SIG_DFL);  // nohup's tests inherit otherwise
    close(ends[0]);
    const struct supervised supervised = {&ends[1], lights_off, [](void*) { return lit; }, 0};
    if (supervise_fork(&supervised, kDiedExit) == 0) {
      if (write(ends[1], "run ", 4) != 4) _exit(1);
      work();
    }
    _exit(99);
  }
  close(ends[1]);
  std::string told;
  char text[16];
  ssize_t size = read(ends[0], text, 4);
  told.append(text, size_t(size));
  if (meanwhile != nullptr) meanwhile(supervisor);
  while ((size = read(ends[0], text, sizeof text)) > 0) told.append(text, size_t(size));
  close(ends[0]);
  int status = 0;
  waitpid(supervisor, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), told};
}

void wait_for_signals() {
  sigset_t none;
  sigemptyset(&none);
  signal(SIGTERM, [](int) { _exit(5); });
  sigsuspend(&none);
}

void ignore_signals() {
  signal(SIGTERM, SIG_IGN);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (;;) pause();
}

}  // namespace

TEST(Supervisor, HandsOnTheSequencersExitCode) {
  const Outcome outcome = run([] { _exit(3); });
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_EQ(outcome.told, "run off") << "the lights are off whatever ended it";
}

TEST(Supervisor, TurnsTheLightsOffWhenTheSequencerIsKilled) {
  const Outcome outcome = run([] { kill(getpid(), SIGKILL); });
  EXPECT_EQ(outcome.exit_code, kDiedExit);
  EXPECT_EQ(outcome.told, "run off");
}

// Its memory is given back first, which takes long on a small board.
TEST(Supervisor, DoesNotWaitForTheMemoryOfASequencerThatIsKilled) {
  const auto die_with_much_memory = [] {
    constexpr size_t kBytes = size_t(256) << 20;
    char* bytes = new char[kBytes];
    for (size_t i = 0; i < kBytes; i += 4096) bytes[i] = 1;
    kill(getpid(), SIGKILL);
  };
  const Outcome outcome = run(die_with_much_memory, nullptr, note_lights_off_before_the_end);
  EXPECT_EQ(outcome.exit_code, kDiedExit);
  EXPECT_EQ(outcome.told, "run early off");
}

TEST(Supervisor, HandsOnToTheSequencerWhatIsToEndIt) {
  for (const auto& end :
       {+[](pid_t pid) { kill(pid, SIGTERM); }, +[](pid_t pid) { kill(pid, SIGINT); },
        +[](pid_t pid) { kill(pid, SIGHUP); }}) {
    EXPECT_EQ(run(wait_for_signals, end).exit_code, 5) << "the sequencer's own way to end";
  }
}

TEST(Supervisor, IsFollowedByTheSequencerWhenItIsKilledItself) {
  const Outcome outcome = run(wait_for_signals, [](pid_t pid) { kill(pid, SIGKILL); });
  EXPECT_EQ(outcome.exit_code, -SIGKILL);
  EXPECT_EQ(outcome.told, "run ") << "the pipe has closed: its sequencer ended too";
}

TEST(Supervisor, KillsASequencerThatKeepsALightOnAfterItWasToldToEnd) {
  lit = true;
  const Outcome outcome = run(ignore_signals, [](pid_t pid) {
    usleep(50000);  // until it ignores signals
    kill(pid, SIGTERM);
  });
  lit = false;
  EXPECT_EQ(outcome.exit_code, kDiedExit);
  EXPECT_EQ(outcome.told, "run off");
}

TEST(Supervisor, GivesADarkSequencerTheTimeToEndByItself) {
  const auto end_slowly = [] {
    signal(SIGTERM, [](int) {
      usleep(100000);
      _exit(5);
    });
    sigset_t none;
    sigemptyset(&none);
    sigsuspend(&none);
  };
  const Outcome outcome = run(end_slowly, [](pid_t pid) { kill(pid, SIGTERM); });
  EXPECT_EQ(outcome.exit_code, 5);
}
