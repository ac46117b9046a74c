#include "apps/run_lamella.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace lamella::testing {

namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

[[noreturn]] void become(std::vector<char*> arguments, const fs::path& folder,
                         const std::string& out_path) {
  const int out = open(out_path.c_str(), O_WRONLY | O_CREAT, 0600);
  const int err = open((folder / "err").c_str(), O_WRONLY | O_CREAT, 0600);
  dup2(out, 1);
  dup2(err, 2);
  execv(arguments[0], arguments.data());
  _exit(127);
}

// Runs it, calls `meanwhile` with its process, and waits for its end.
Outcome run(const std::vector<std::string>& arguments, const char* out,
            const std::function<void(pid_t)>& meanwhile) {
  std::string name = (fs::temp_directory_path() / "lamella-run-XXXXXX").string();
  if (!mkdtemp(name.data())) return {};
  std::vector<char*> pointers{const_cast<char*>(LAMELLA_BINARY)};
  for (const std::string& a : arguments) pointers.push_back(const_cast<char*>(a.c_str()));
  pointers.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) become(pointers, name, out ? out : (fs::path(name) / "out").string());
  meanwhile(child);
  int status = 0;
  waitpid(child, &status, 0);
  Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(fs::path(name) / "out"),
                  text_of(fs::path(name) / "err")};
  fs::remove_all(name);
  return outcome;
}

}  // namespace

std::vector<std::string> Outcome::complaints() const {
  std::vector<std::string> lines;
  std::istringstream in(err);
  for (std::string line; std::getline(in, line);) {
    if (line.find("warning") == std::string::npos) lines.push_back(line);
  }
  return lines;
}

Outcome run_lamella(const std::vector<std::string>& arguments, const char* out) {
  return run(arguments, out, [](pid_t) {});
}

Outcome interrupt_lamella(const std::vector<std::string>& arguments,
                          const std::function<bool()>& is_time) {
  return run(arguments, nullptr, [&](pid_t child) {
    while (!is_time()) usleep(1000);
    kill(child, SIGINT);
  });
}

}  // namespace lamella::testing
