#include "apps/commands.h"
#include "base/error.h"

namespace lamella::apps {

void add_export(CLI::App& app, int*) {
  app.add_subcommand("export")->callback([] { throw_bad_input("export", "not in this build"); });
}

}  // namespace lamella::apps
