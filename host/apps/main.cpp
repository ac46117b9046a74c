// lamella: captures, fits, renders, compares, exports and shows layered facial reflectance.
#include <google/protobuf/stubs/logging.h>

#include <cstdio>
#include <filesystem>

#include "apps/commands.h"
#include "base/error.h"

int main(int argc, char** argv) {
  using namespace lamella;
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
  } catch (const std::exception& e) {
    std::fprintf(stderr, "lamella: internal error: %s\n", e.what());
    return 2;
  }
  return exit_code;
}
