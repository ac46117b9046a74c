#include "apps/commands.h"
#include "base/error.h"

namespace lamella::apps {

void add_review(CLI::App& app, int*) {
  app.add_subcommand("review")->callback([] { throw_bad_input("review", "not in this build"); });
}

}  // namespace lamella::apps
