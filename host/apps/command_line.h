// What a command takes on its line. CLI11 stands behind it and is compiled once, in
// command_line.cpp: included by every command it would be most of what there is to compile.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace lamella::apps {

// What is wrong with an argument, in words that follow its name; empty where nothing is.
using ArgumentFault = std::function<std::string(const std::string& text)>;

class CommandOption {
 public:
  explicit CommandOption(CLI::Option* option) : option_(option) {}

  CommandOption required() const;
  // --help shows what stands where it is not given.
  CommandOption shows_default() const;
  CommandOption check(const ArgumentFault& fault) const;
  CommandOption within(int least, int most) const;
  CommandOption within(double least, double most) const;
  CommandOption one_of(const std::vector<std::string>& words) const;

 private:
  CLI::Option* option_;
};

class Command {
 public:
  Command add_command(const std::string& name, const std::string& help) const;
  // One of its commands must be given.
  void require_command() const;

  // `name` with dashes is an option, without them a positional argument. T: std::string, a path,
  // int, uint64_t, float, double, a vector of strings. `value` must live until the line is parsed.
  // A path or a positional argument may not be empty.
  template <class T>
  CommandOption add_option(const std::string& name, T& value, const std::string& help) const;
  void add_flag(const std::string& name, bool& value, const std::string& help) const;

  // On the line, whatever its value is.
  bool given(const std::string& name) const;

  // What is done once the line is known to be good.
  void runs(const std::function<void()>& what) const;

 protected:
  explicit Command(CLI::App* app) : app_(app) {}

  CLI::App* app_;
};

class CommandLine : public Command {
 public:
  // Its --version prints `version`.
  CommandLine(const std::string& about, const std::string& footer, const std::string& version);
  ~CommandLine();

  // Runs the command that is named there; what that throws passes. The exit code where none ran:
  // help or the version was asked for and printed, or the line is no good, which is said on
  // standard error.
  std::optional<int> run(int argc, char** argv);

 private:
  std::unique_ptr<CLI::App> whole_;
};

}  // namespace lamella::apps
