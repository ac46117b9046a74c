#include "apps/commands.h"
#include "base/error.h"

namespace lamella::apps {

void add_check(CLI::App& app, int*) {
  app.add_subcommand("check")->callback([] { throw_bad_input("check", "not in this build"); });
}

}  // namespace lamella::apps
