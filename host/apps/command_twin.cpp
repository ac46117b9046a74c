#include "apps/commands.h"
#include "base/error.h"

namespace lamella::apps {

void add_twin(CLI::App& app, int*) {
  app.add_subcommand("twin")->callback([] { throw_bad_input("twin", "not in this build"); });
}

}  // namespace lamella::apps
