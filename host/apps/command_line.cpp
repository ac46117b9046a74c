#include "apps/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <numeric>

#include "base/error.h"

namespace lamella::apps {

namespace {

// Letters to be changed, added or taken away to make one word of the other.
size_t edits_between(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t(0));
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0]++;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t kept = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({kept, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

// "capture is one; " where that is most likely what was meant by `word`.
std::string nearest_command(const CLI::App& app, const std::string& word) {
  const size_t most = word.size() / 3;
  std::string nearest;
  size_t least = most + 1;
  for (const CLI::App* command : commands_of(app)) {
    const size_t edits = edits_between(word, command->get_name());
    if (edits >= least) continue;
    least = edits;
    nearest = command->get_name() + " is one; ";
  }
  return nearest;
}

// Throws where a word in the place of a command is none.
void require_commands(const CLI::App& root, int argc, char** argv) {
  const CLI::App* app = &root;
  std::string path;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    const std::vector<const CLI::App*> commands = commands_of(*app);
    if (commands.empty()) return;
    const auto command = std::find_if(commands.begin(), commands.end(),
                                      [&](const CLI::App* c) { return c->get_name() == argv[i]; });
    if (command == commands.end()) {
      throw_bad_input("", "no command \"" + path + argv[i] + "\"",
                      nearest_command(*app, argv[i]) + "see lamella " + path + "--help");
    }
    app = *command;
    path += std::string(argv[i]) + " ";
  }
}

}  // namespace

CommandOption CommandOption::required() const {
  option_->required();
  return *this;
}

CommandOption CommandOption::shows_default() const {
  option_->capture_default_str();
  return *this;
}

CommandOption CommandOption::check(const ArgumentFault& fault) const {
  option_->check(CLI::Validator([fault](const std::string& text) { return fault(text); }, ""));
  return *this;
}

CommandOption CommandOption::within(int least, int most) const {
  option_->check(CLI::Range(least, most));
  return *this;
}

CommandOption CommandOption::within(double least, double most) const {
  option_->check(CLI::Range(least, most));
  return *this;
}

CommandOption CommandOption::one_of(const std::vector<std::string>& words) const {
  option_->check(CLI::IsMember(words));
  return *this;
}

Command Command::add_command(const std::string& name, const std::string& help) const {
  return Command(app_->add_subcommand(name, help));
}

void Command::require_command() const { app_->require_subcommand(1); }

template <class T>
CommandOption Command::add_option(const std::string& name, T& value,
                                  const std::string& help) const {
  return CommandOption(app_->add_option(name, value, help));
}

template CommandOption Command::add_option(const std::string&, std::string&,
                                           const std::string&) const;
template CommandOption Command::add_option(const std::string&, std::filesystem::path&,
                                           const std::string&) const;
template CommandOption Command::add_option(const std::string&, int&, const std::string&) const;
template CommandOption Command::add_option(const std::string&, uint64_t&, const std::string&) const;
template CommandOption Command::add_option(const std::string&, float&, const std::string&) const;
template CommandOption Command::add_option(const std::string&, double&, const std::string&) const;
template CommandOption Command::add_option(const std::string&, std::vector<std::string>&,
                                           const std::string&) const;

void Command::add_flag(const std::string& name, bool& value, const std::string& help) const {
  app_->add_flag(name, value, help);
}

bool Command::given(const std::string& name) const { return app_->count(name) > 0; }

void Command::runs(const std::function<void()>& what) const { app_->callback(what); }

CommandLine::CommandLine(const std::string& about, const std::string& footer)
    : Command(nullptr), whole_(std::make_unique<CLI::App>(about)) {
  app_ = whole_.get();
  app_->footer(footer);
}

CommandLine::~CommandLine() = default;

std::optional<int> CommandLine::run(int argc, char** argv) {
  try {
    require_commands(*app_, argc, argv);
    app_->parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app_->exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return app_->exit(e);
  } catch (const CLI::ParseError& e) {
    std::fprintf(stderr, "lamella: %s; see lamella --help\n", e.what());
    return 2;
  }
  return std::nullopt;
}

}  // namespace lamella::apps
