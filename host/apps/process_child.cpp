#include "apps/process_child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <thread>

#include "base/error.h"

namespace lamella::apps {

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr int kBadInputExit = 2;  // of both programs
constexpr milliseconds kLook{10};
constexpr milliseconds kGrace{3000};  // between asking a child to end and ending it

volatile std::sig_atomic_t interrupted_flag = 0;

void note_interrupt(int) { interrupted_flag = 1; }

std::vector<std::string> whole_lines(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  std::string line;
  while (std::getline(in, line) && !in.eof()) lines.push_back(line);
  return lines;
}

// In the child, between fork and exec: only what is safe there.
[[noreturn]] void become(char* const* arguments, const char* out, const char* err, pid_t parent) {
  setpgid(0, 0);  // ^C at the terminal is for the parent to handle
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  const int in_fd = open("/dev/null", O_RDONLY);
  const int out_fd = open(out, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int err_fd = open(err, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  dup2(in_fd, 0);
  dup2(out_fd, 1);
  dup2(err_fd, 2);
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  execv(arguments[0], arguments);
  _exit(127);
}

}  // namespace

ChildProcess::ChildProcess(std::string name, const std::vector<std::string>& arguments,
                           const fs::path& folder)
    : name_(std::move(name)), out_(folder / (name_ + ".out")), err_(folder / (name_ + ".err")) {
  if (access(arguments[0].c_str(), X_OK) != 0) {
    throw Error(Fault::kRig, name_, "no program " + arguments[0], "build it first");
  }
  std::vector<char*> pointers;
  for (const std::string& a : arguments) pointers.push_back(const_cast<char*>(a.c_str()));
  pointers.push_back(nullptr);
  const std::string out = out_.string(), err = err_.string();
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) become(pointers.data(), out.c_str(), err.c_str(), parent);
  if (pid_ < 0) throw Error(Fault::kRig, name_, std::string("fork: ") + std::strerror(errno));
}

ChildProcess::~ChildProcess() {
  if (has_ended()) return;
  kill(pid_, SIGTERM);
  const auto end = steady_clock::now() + kGrace;
  while (!has_ended() && steady_clock::now() < end) std::this_thread::sleep_for(kLook);
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool ChildProcess::has_ended() {
  if (pid_ < 0) return true;
  int status = 0;
  const pid_t ended = waitpid(pid_, &status, WNOHANG);
  if (ended == 0) return false;
  if (ended == pid_ && WIFEXITED(status)) exit_code_ = WEXITSTATUS(status);
  pid_ = -1;
  return true;
}

int ChildProcess::wait() {
  while (!has_ended()) std::this_thread::sleep_for(kLook);
  return exit_code_;
}

std::string ChildProcess::output() const {
  std::ifstream file(out_, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string ChildProcess::last_words() const {
  const std::vector<std::string> lines = whole_lines(err_);
  return lines.empty() ? "" : lines.back();
}

std::string ChildProcess::complaint() const {
  const std::vector<std::string> lines = whole_lines(err_);
  if (lines.size() < 2) return last_words();
  return lines.front() + " (and " + std::to_string(lines.size() - 1) + " more)";
}

std::string ChildProcess::wait_for_line(const Awaited& awaited,
                                        const std::function<bool()>& interrupted) {
  const auto end = steady_clock::now() + std::chrono::duration<double>(awaited.longest_s);
  while (true) {
    const bool ended = has_ended();  // before the look at its output, so that nothing is missed
    for (const std::string& line : whole_lines(out_)) {
      if (line.starts_with(awaited.line)) return line.substr(awaited.line.size());
    }
    const std::string said = last_words().empty() ? "" : ": " + last_words();
    if (interrupted()) throw Error(Fault::kRig, "", "interrupted, nothing was kept");
    if (ended) {
      const Fault fault = exit_code_ == kBadInputExit ? Fault::kBadInput : Fault::kRig;
      throw Error(fault, name_, "ended before it was ready" + said);
    }
    if (steady_clock::now() > end) {
      throw Error(Fault::kRig, name_,
                  fmt::format("still {} after {:g} s", awaited.work, awaited.longest_s) + said,
                  "this computer may be too busy for it: end other work, then try again");
    }
    std::this_thread::sleep_for(kLook);
  }
}

PrivateFolder::PrivateFolder() {
  std::string name = (fs::temp_directory_path() / "lamella-XXXXXX").string();
  if (!mkdtemp(name.data())) {
    throw Error(Fault::kRig, name, std::string("cannot be created (") + std::strerror(errno) + ")");
  }
  path_ = name;
}

PrivateFolder::~PrivateFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = note_interrupt;
  for (int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(number, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(number, &action, nullptr);  // nohup stays nohup
  }
}

bool interrupted() { return interrupted_flag != 0; }

fs::path own_binary() { return fs::read_symlink("/proc/self/exe"); }

}  // namespace lamella::apps
