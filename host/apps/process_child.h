// A program of ours run beside this one. It never outlives us.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace lamella::apps {

namespace fs = std::filesystem;

struct Awaited {
  std::string line;  // how it begins
  double longest_s;
  std::string work;  // what the program does until then, for whoever waited in vain
};

class ChildProcess {
 public:
  // Starts `arguments[0]` with its output in `folder`/NAME.out and NAME.err. Throws Error (kRig).
  ChildProcess(std::string name, const std::vector<std::string>& arguments, const fs::path& folder);

  // Asks it to end, waits a little, then ends it.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // What follows the awaited beginning on the first line of its output that has it. Throws Error
  // (kRig) with its last words where it ends first or the time says so, and where `interrupted`
  // does, which is nothing that the child said.
  std::string wait_for_line(const Awaited& awaited, const std::function<bool()>& interrupted);

  bool has_ended();

  // Its exit code, once it has ended of itself; -1 where a signal ended it.
  int wait();

  // All that it has written to its standard output so far.
  std::string output() const;

  // Its last line on standard error; empty where it said nothing.
  std::string last_words() const;

  // Its first line on standard error, and how many more it wrote.
  std::string complaint() const;

 private:
  std::string name_;
  fs::path out_, err_;
  pid_t pid_ = -1;
  int exit_code_ = -1;
};

// A folder for this process alone (mode 0700), removed with everything in it.
class PrivateFolder {
 public:
  PrivateFolder();
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// From now on SIGINT, SIGTERM and SIGHUP, unless ignored before, only set a flag, so that what was
// begun is cleaned up.
void catch_interrupts();
bool interrupted();

// The file that is being run.
fs::path own_binary();

}  // namespace lamella::apps
