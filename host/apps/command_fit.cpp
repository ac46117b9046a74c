#include "apps/commands.h"
#include "base/error.h"

namespace lamella::apps {

void add_fit(CLI::App& app, int*) {
  app.add_subcommand("fit")->callback([] { throw_bad_input("fit", "not in this build"); });
}

}  // namespace lamella::apps
