// lamella check SESSION: is this session fit to fit, and why not.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/report.h"
#include "base/error.h"
#include "calib/check.h"

namespace lamella::apps {

namespace {

struct CheckArguments {
  fs::path session;
  bool json = false;
};

const char* verdict(Grade worst) {
  if (worst == Grade::kUnusable) return "not usable";
  return worst == Grade::kPoor ? "usable, below the quality asked" : "fit to fit";
}

void print_table(const SessionCheck& check) {
  for (const CheckLine& l : check.lines) {
    fmt::print("{:<9} {:<30} {}\n", grade_name(l.grade), l.name, one_line(l.text));
  }
  fmt::print("\n{}\n", verdict(check.worst()));
}

void print_report(const CheckArguments& args, const SessionCheck& check) {
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  for (const CheckLine& l : check.lines) {
    nlohmann::ordered_json line = {
        {"grade", grade_name(l.grade)}, {"name", l.name}, {"text", l.text}};
    if (!l.unit.empty() || l.limit > 0) {
      line["figure"] = l.figure;
      line["unit"] = l.unit;
    }
    if (l.limit > 0) line["limit"] = l.limit;
    lines.push_back(line);
  }
  const nlohmann::ordered_json report = {{"session", args.session.string()},
                                         {"grade", grade_name(check.worst())},
                                         {"verdict", verdict(check.worst())},
                                         {"lines", lines}};
  print_json(report);
}

int run_check(const CheckArguments& args) {
  const SessionCheck check = check_session(args.session);
  if (args.json) {
    print_report(args, check);
  } else {
    print_table(check);
  }
  std::fflush(stdout);
  require_usable(check);
  return check.worst() == Grade::kPoor ? 1 : 0;
}

}  // namespace

void add_check(const Command& app, int* exit_code) {
  auto args = std::make_shared<CheckArguments>();
  const Command command = app.add_command("check", "Is this session fit to fit, and why not");
  command.add_option("session", args->session, "Session folder").required();
  command.add_flag("--json", args->json, "Report as JSON");
  command.runs([args, exit_code] { *exit_code = run_check(*args); });
}

}  // namespace lamella::apps
