#include "apps/commands.h"
#include "base/error.h"

namespace lamella::apps {

void add_capture(CLI::App& app, int*) {
  app.add_subcommand("capture")->callback([] { throw_bad_input("capture", "not in this build"); });
}

}  // namespace lamella::apps
