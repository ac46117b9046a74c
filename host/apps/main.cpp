// lamella: captures, fits, renders, compares, exports and shows layered facial reflectance.
#include <google/protobuf/stubs/logging.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

#include "apps/commands.h"
#include "apps/report.h"
#include "base/error.h"
#include "base/process_heap.h"
#include "io/link_client.h"

namespace {

using namespace lamella;
using apps::one_line;

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

int run(int argc, char** argv) {
  apps::CommandLine app(
      "Layered facial reflectance, from the rig to the engine.",
      "Exit codes: 0 done, 1 done but below the quality asked, 2 bad input, 3 rig or link failed.",
      "lamella " LAMELLA_VERSION " (link protocol " + std::to_string(kProtocolVersion) + ")");
  app.require_command();
  google::protobuf::SetLogHandler(nullptr);  // what is wrong with a message is ours to say
  int exit_code = 0;
  apps::add_capture(app, &exit_code);
  apps::add_rig(app, &exit_code);
  apps::add_twin(app, &exit_code);
  apps::add_check(app, &exit_code);
  apps::add_fit(app, &exit_code);
  apps::add_bench(app, &exit_code);
  apps::add_render(app, &exit_code);
  apps::add_compare(app, &exit_code);
  apps::add_export(app, &exit_code);
  apps::add_review(app, &exit_code);
  try {
    if (const auto refused = app.run(argc, argv)) return *refused;
  } catch (const Error& e) {
    std::fprintf(stderr, "lamella: %s\n", one_line(e.what()).c_str());
    return e.fault() == Fault::kBadInput ? 2 : 3;
  } catch (const std::filesystem::filesystem_error& e) {
    std::fprintf(stderr, "lamella: %s: %s\n", one_line(e.path1().string()).c_str(),
                 e.code().message().c_str());
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

int main(int argc, char** argv) {
  // A file that grows beyond what the shell allows (ulimit -f) is an error like a full disk, not a
  // signal that leaves it half written.
  std::signal(SIGXFSZ, SIG_IGN);
  keep_heap();
  return end_report(run(argc, argv));
}
