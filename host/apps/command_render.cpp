#include "apps/commands.h"
#include "base/error.h"

namespace lamella::apps {

void add_render(CLI::App& app, int*) {
  app.add_subcommand("render")->callback([] { throw_bad_input("render", "not in this build"); });
}

}  // namespace lamella::apps
