#include "apps/commands.h"
#include "base/error.h"

namespace lamella::apps {

void add_compare(CLI::App& app, int*) {
  app.add_subcommand("compare")->callback([] { throw_bad_input("compare", "not in this build"); });
}

}  // namespace lamella::apps
