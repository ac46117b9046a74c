// lamella: captures, fits, renders, compares, exports and shows layered facial reflectance.
#include <google/protobuf/stubs/logging.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <numeric>
#include <string>
#include <system_error>
#include <vector>

#include "apps/commands.h"
#include "base/error.h"

namespace {

using namespace lamella;

int lose_report(const std::string& why) {
  std::fprintf(stderr,
               "lamella: standard output: the report cannot be written there (%s); what the "
               "command did besides is done\n",
               why.c_str());
  return 2;
}

// Where a command went well nobody has said yet that its report went nowhere.
int end_report(int exit_code) {
  const bool written = std::fflush(stdout) == 0 && !std::ferror(stdout);
  return written || exit_code > 1 ? exit_code : lose_report(std::strerror(errno));
}

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

int run(int argc, char** argv) {
  CLI::App app{"Layered facial reflectance, from the rig to the engine."};
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 done but below the quality asked, 2 bad input, 3 rig or link failed.");
  google::protobuf::SetLogHandler(nullptr);  // what is wrong with a message is ours to say
  int exit_code = 0;
  apps::add_capture(app, &exit_code);
  apps::add_rig(app, &exit_code);
  apps::add_twin(app, &exit_code);
  apps::add_check(app, &exit_code);
  apps::add_fit(app, &exit_code);
  apps::add_render(app, &exit_code);
  apps::add_compare(app, &exit_code);
  apps::add_export(app, &exit_code);
  apps::add_review(app, &exit_code);
  try {
    require_commands(app, argc, argv);
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    std::fprintf(stderr, "lamella: %s; see lamella --help\n", e.what());
    return 2;
  } catch (const Error& e) {
    std::fprintf(stderr, "lamella: %s\n", e.what());
    return e.fault() == Fault::kBadInput ? 2 : 3;
  } catch (const std::filesystem::filesystem_error& e) {
    std::fprintf(stderr, "lamella: %s: %s\n", e.path1().c_str(), e.code().message().c_str());
    return 2;
  } catch (const std::system_error& e) {
    if (std::ferror(stdout)) return lose_report(e.code().message());
    std::fprintf(stderr, "lamella: internal error: %s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "lamella: internal error: %s\n", e.what());
    return 2;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) { return end_report(run(argc, argv)); }
