#include "apps/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <span>
#include <string_view>
#include <type_traits>

#include "apps/report.h"
#include "base/error.h"

namespace lamella::apps {

namespace {

constexpr char kHelp[] = "help";
constexpr char kCommands[] = "Commands";  // above their list in --help

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

// A command's options follow it.
class CommandFormatter : public CLI::Formatter {
 public:
  std::string make_usage(const CLI::App* app, std::string name) const override {
    if (commands_of(*app).empty()) return CLI::Formatter::make_usage(app, name);
    return "Usage: " + name + " COMMAND [OPTIONS]\n";
  }
};

// "lamella capture is one; " where that is most likely what was meant by `word`, among the commands
// of `app`, which `path` leads to, and theirs.
std::string nearest_command(const CLI::App& app, const std::string& path, const std::string& word) {
  std::string nearest;
  size_t least = word.size() / 3 + 1;
  const auto look = [&](const CLI::App& in, const std::string& path_in) {
    for (const CLI::App* command : commands_of(in)) {
      const size_t edits = edits_between(word, command->get_name());
      if (edits >= least) continue;
      least = edits;
      nearest = path_in + " " + command->get_name() + " is one; ";
    }
  };
  look(app, path);
  for (const CLI::App* command : commands_of(app)) look(*command, path + " " + command->get_name());
  return nearest;
}

// nullptr where there is none.
const CLI::App* command_named(const CLI::App& app, const std::string& word) {
  const std::vector<const CLI::App*> commands = commands_of(app);
  const auto found = std::find_if(commands.begin(), commands.end(),
                                  [&](const CLI::App* c) { return c->get_name() == word; });
  return found == commands.end() ? nullptr : *found;
}

// `words` begin with an option where a command of `app` should stand.
[[noreturn]] void refuse_early_option(const CLI::App& app, const std::string& path,
                                      std::span<const std::string> words) {
  const std::string option = words[0].substr(0, words[0].find('='));
  const auto command = std::find_if(words.begin(), words.end(), [&](const std::string& word) {
    return command_named(app, word) != nullptr;
  });
  const std::string after = command == words.end() ? "COMMAND" : *command;
  throw_bad_input(option, "options follow the command: " + path + " " + after + " " + option,
                  "see " + path + " --help");
}

// Throws where what stands in the place of a command is none.
void require_commands(const CLI::App& root, std::span<const std::string> words) {
  const CLI::App* app = &root;
  std::string path = root.get_name();
  for (; !commands_of(*app).empty(); words = words.subspan(1)) {
    const std::string see = "see " + path + " --help";
    const std::string whose = app == &root ? "" : path;  // every line begins with the root's name
    if (words.empty()) throw_bad_input(whose, "needs a command", see);
    const std::string& word = words[0];
    if (app->get_option_no_throw(word)) return;  // its --help or --version
    if (word.starts_with("-")) refuse_early_option(*app, path, words);
    const CLI::App* command = command_named(*app, word);
    if (!command) {
      throw_bad_input("", "\"" + word + "\" is no command of \"" + path + "\"",
                      nearest_command(*app, path, word) + see);
    }
    app = command;
    path += " " + word;
  }
}

// "help COMMAND" is "COMMAND --help".
std::vector<std::string> words_of(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  if (words.empty() || words[0] != kHelp) return words;
  words.erase(words.begin());
  words.push_back("--help");
  return words;
}

// The command that the line names, as far as it was understood.
std::string command_in(const CLI::App& root) {
  std::string path = root.get_name();
  for (const CLI::App* app = &root; !app->get_subcommands().empty();) {
    app = app->get_subcommands().front();
    path += " " + app->get_name();
  }
  return path;
}

// In words that say what to mend.
std::string fault_in(const CLI::ParseError& e) {
  constexpr std::string_view kTooMany = "At Most 1 required but received ";
  std::string text = e.what();
  const size_t at = text.find(kTooMany);
  return at == std::string::npos ? text : text.replace(at, kTooMany.size(), "given ") + " times";
}

std::string fault_of_nothing(const std::string& text) {
  return text.empty() ? "\"\" is no name" : "";
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
  return Command(app_->add_subcommand(name, help)->group(kCommands));
}

void Command::require_command() const { app_->require_subcommand(1); }

template <class T>
CommandOption Command::add_option(const std::string& name, T& value,
                                  const std::string& help) const {
  const CommandOption option(app_->add_option(name, value, help));
  const bool is_name = !name.starts_with("-") || std::is_same_v<T, std::filesystem::path>;
  if (std::is_floating_point_v<T>) return option.check(fault_of_decimal);
  return is_name ? option.check(fault_of_nothing) : option;
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

CommandLine::CommandLine(const std::string& about, const std::string& footer,
                         const std::string& version)
    : Command(nullptr), whole_(std::make_unique<CLI::App>(about, "lamella")) {
  app_ = whole_.get();
  app_->footer(footer);
  app_->set_version_flag("--version", version, "Print the version and exit");
  app_->formatter(std::make_shared<CommandFormatter>());
  add_command(kHelp, "What a command takes: lamella help COMMAND");
}

CommandLine::~CommandLine() = default;

std::optional<int> CommandLine::run(int argc, char** argv) {
  std::vector<std::string> words = words_of(argc, argv);
  try {
    require_commands(*app_, words);
    std::reverse(words.begin(), words.end());  // as CLI11 takes them
    app_->parse(std::move(words));
  } catch (const CLI::Success& e) {  // help or the version was asked for
    return app_->exit(e);
  } catch (const CLI::ParseError& e) {
    std::fprintf(stderr, "lamella: %s; see %s --help\n", one_line(fault_in(e)).c_str(),
                 command_in(*app_).c_str());
    return 2;
  }
  return std::nullopt;
}

}  // namespace lamella::apps
