// lamella rig plan: the burst that a rig file would play, before anything moves; status, abort: a
// rig that answers.
#include <fmt/format.h>

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "apps/commands.h"
#include "apps/counted.h"
#include "apps/plan_chart.h"
#include "apps/process_killed.h"
#include "apps/process_rig.h"
#include "apps/report.h"
#include "apps/rig_option.h"
#include "base/error.h"
#include "io/link_client.h"
#include "io/paired_link.h"
#include "io/vcd.h"
#include "io/whole_file.h"

namespace lamella::apps {

namespace {

struct PlanArguments {
  std::string rig_file = "sim";
  fs::path svg, vcd;
  bool json = false;
};

// What every exposure waited for, summed by name; the exposures themselves too.
std::map<std::string, double> terms_us(const v1::Plan& plan) {
  std::map<std::string, double> terms;
  for (const v1::PlannedStep& step : plan.steps()) {
    terms["exposures"] += step.close_us() - step.open_us();
    if (step.wait_us() > 0) terms["waiting for " + step.wait()] += step.wait_us();
  }
  if (plan.steps_size() > 0) {
    const v1::PlannedStep& last = plan.steps(plan.steps_size() - 1);
    terms["last readout"] = last.read_out_us() - last.close_us();
  }
  return terms;
}

// IEC 62471, for an eye that looks into it during the whole burst.
void print_dose(const std::string& source, const v1::PlanDose& dose) {
  fmt::print(
      "  an eye that looks into {}: {:.0f} J/m2sr of blue light, so at most {} a day; {:.2g} % of "
      "the thermal limit\n",
      source, dose.blue_j_per_m2_sr(), counted(uint64_t(dose.bursts_per_day()), "burst"),
      100 * dose.thermal_share());
}

void print_table(const v1::Plan& plan, const std::string& rig) {
  fmt::print("{}: {} photographs in {:.1f} ms\n\n", rig, plan.steps_size(),
             plan.duration_us() / 1000);
  fmt::print("  {:<3} {:<14} {:>9} {:>9} {:>11} {:>9}\n", "", "frame", "opens, ms", "closes, ms",
             "after, ms", "for");
  int number = 0;
  for (const v1::PlannedStep& s : plan.steps()) {
    // Names hold a sign of three bytes that is one column wide.
    fmt::print("  {:<3} {:<{}} {:>9.2f} {:>10.2f} {:>11.2f} {:>9}\n", number++, short_name(s),
               s.analyser() == v1::Frame::CROSS ? 15 : 16, s.open_us() / 1000, s.close_us() / 1000,
               s.wait_us() / 1000, s.wait());
  }
  if (plan.trigger_active_low()) fmt::print("\n  TRIGGER's line is 0 while the cameras expose\n");
  fmt::print("\n  where the time goes\n");
  for (const auto& [name, us] : terms_us(plan)) {
    fmt::print("  {:<24} {:>9.1f} ms {:>6.1f} %\n", name, us / 1000, 100 * us / plan.duration_us());
  }
  fmt::print(
      "\n  no order takes less than {:.1f} ms; this one costs at most {:.1f} % more than any\n",
      plan.least_duration_us() / 1000, 100 * (plan.cost_us() / plan.least_cost_us() - 1));
  const v1::PlanBudget& b = plan.budget();
  fmt::print(
      "\n  white behind the analyser: {:.0f} % of saturation by LEDs, {:.0f} % by projector\n",
      100 * b.leds_share(), 100 * b.projector_share());
  fmt::print("  hottest LED junction {:.1f} C; {:.0f} LED flashes in the worst second\n",
             b.junction_c(), b.flashes_per_s());
  fmt::print("  photographs {:.0f} MB, of which {:.0f} MB are in memory at the end\n",
             b.frames_bytes() * 1e-6, b.memory_bytes() * 1e-6);
  print_dose("an LED", b.leds_dose());
  print_dose("the projector's lens", b.projector_dose());
  fmt::print(
      "  the projector's label, its risk group and hazard distance (IEC 62471-5), holds besides\n");
}

nlohmann::ordered_json dose_json(const v1::PlanDose& dose) {
  return {{"blue_j_per_m2_sr", dose.blue_j_per_m2_sr()},
          {"bursts_per_day", dose.bursts_per_day()},
          {"thermal_share", dose.thermal_share()}};
}

void print_plan_json(const v1::Plan& plan, const std::string& rig) {
  nlohmann::ordered_json steps = nlohmann::ordered_json::array();
  for (const v1::PlannedStep& s : plan.steps()) {
    steps.push_back({{"role", v1::Frame::Role_Name(s.role())},
                     {"index", s.index()},
                     {"analyser", v1::Frame::Analyser_Name(s.analyser())},
                     {"open_us", s.open_us()},
                     {"close_us", s.close_us()},
                     {"light_on_us", s.light_on_us()},
                     {"light_off_us", s.light_off_us()},
                     {"wait_us", s.wait_us()},
                     {"waits_for", s.wait()}});
  }
  const v1::PlanBudget& b = plan.budget();
  print_json({{"rig", rig},
              {"duration_us", plan.duration_us()},
              {"cost_us", plan.cost_us()},
              {"least_duration_us", plan.least_duration_us()},
              {"least_cost_us", plan.least_cost_us()},
              {"trigger_active", plan.trigger_active_low() ? "low" : "high"},
              {"refusal", plan.refusal()},
              {"steps", steps},
              {"terms_us", terms_us(plan)},
              {"budget",
               {{"leds_share", b.leds_share()},
                {"projector_share", b.projector_share()},
                {"junction_c", b.junction_c()},
                {"frames_bytes", b.frames_bytes()},
                {"memory_bytes", b.memory_bytes()},
                {"flashes_per_s", b.flashes_per_s()},
                {"leds_dose", dose_json(b.leds_dose())},
                {"projector_dose", dose_json(b.projector_dose())}}}});
}

int run_plan(const PlanArguments& args) {
  for (const fs::path& out : {args.svg, args.vcd}) {
    if (out.empty()) continue;
    require_file_place(out);
    clear_half_written_beside(out);
  }
  const fs::path rig_file = find_rig_file(args.rig_file);
  for (const fs::path& out : {args.svg, args.vcd}) {
    for (const fs::path& read : files_of_rig(rig_file)) {
      if (!is_same_file(out, read)) continue;
      throw_bad_input(out.string(),
                      read == rig_file ? "is the rig file itself" : "is the rig's list of LEDs",
                      "name another file");
    }
  }
  if (is_same_file(args.svg, args.vcd)) {
    throw_bad_input(args.vcd.string(), "is the chart and the edges at once", "name two files");
  }
  const v1::Plan plan = plan_of_rig_file(args.rig_file);
  const std::string rig = fs::path(args.rig_file).stem().string();
  if (!args.svg.empty()) write_whole_text(args.svg, plan_chart(plan, rig));
  std::set<std::string> active_low;
  if (plan.trigger_active_low()) active_low.insert("TRIGGER");
  if (!args.vcd.empty()) {
    write_whole_text(args.vcd, vcd_text(plan.edges(), EdgeTime::kPlanned, active_low));
  }
  if (args.json) {
    print_plan_json(plan, rig);
  } else {
    print_table(plan, rig);
  }
  if (plan.refusal().empty()) return 0;
  std::fflush(stdout);
  throw_bad_input(args.rig_file, "the rig would not play this: " + plan.refusal());
}

struct RigArguments {
  std::string rig;
  bool json = false;
};

void print_status(const LinkClient& client, const v1::Status& status, const RigArguments& args) {
  const std::string state = v1::RigState_Name(status.state());
  if (args.json) {
    print_json({{"rig", args.rig},
                {"state", state},
                {"fault", status.fault()},
                {"burst", status.burst_id()},
                {"frames_held", status.frames_held()},
                {"latency",
                 {{"waits", status.latency().waits()},
                  {"median_us", status.latency().median_us()},
                  {"p99_us", status.latency().p99_us()},
                  {"highest_us", status.latency().highest_us()},
                  {"lead_us", status.latency().lead_us()}}},
                {"bursts_held", status.bursts_held()},
                {"unfit", std::vector<std::string>(status.unfit().begin(), status.unfit().end())},
                {"hal", client.welcome().hal()},
                {"firmware", client.welcome().firmware_version()}});
    return;
  }
  const std::string fault = status.fault().empty() ? "" : ", " + one_line(status.fault());
  fmt::print("{}: {}{}\n", args.rig, state, fault);
  for (const std::string& part : status.unfit()) fmt::print("  unfit: {}\n", one_line(part));
  fmt::print("  firmware {}, {} hardware, {} LEDs, {} cameras\n",
             one_line(client.welcome().firmware_version()), one_line(client.welcome().hal()),
             client.welcome().led_count(), client.welcome().camera_count());
  fmt::print("  waits end {:.1f} us late in the median, at most {:.1f} us, of {} at its start\n",
             status.latency().median_us(), status.latency().highest_us(),
             counted(status.latency().waits(), "wait"));
  if (status.burst_id() == 0) {
    fmt::print("  no burst was taken yet\n");
  } else {
    fmt::print("  holds {}; of burst {}, the newest, {}\n", counted(status.bursts_held(), "burst"),
               status.burst_id(), counted(status.frames_held(), "photograph"));
  }
}

LinkOptions link_to(const std::string& address) {
  LinkOptions link;
  link.tls = tls_for(address, config_folder());
  return link;
}

// Exit 1 while the rig is in FAULT.
int run_status(const RigArguments& args) {
  LinkClient client(args.rig, link_to(args.rig));
  const v1::Status status = client.status();
  print_status(client, status, args);
  if (status.state() != v1::FAULT) return 0;
  const Error fault(Fault::kRig, "rig " + args.rig, "is in FAULT: " + status.fault(),
                    "once its cause is gone, lamella rig abort --rig " + args.rig + " clears it");
  fmt::print(stderr, "lamella: {}\n", one_line(fault.what()));
  return 1;
}

int run_abort(const RigArguments& args) {
  LinkClient client(args.rig, link_to(args.rig));
  print_status(client, client.abort(), args);
  return 0;
}

void add_rig_command(const Command& rig, const std::string& name, const std::string& help,
                     const std::function<void(const RigArguments&)>& run) {
  auto args = std::make_shared<RigArguments>();
  const Command command = rig.add_command(name, help);
  command.add_option("--rig", args->rig, "HOST:PORT; else the one paired rig on this network")
      .check(rig_address(Simulated::kNot));
  command.add_flag("--json", args->json, "Report as JSON");
  command.runs([args, run] {
    if (args->rig.empty()) args->rig = the_paired_rig();
    run(*args);
  });
}

}  // namespace

void add_rig(const Command& app, int* exit_code) {
  const Command rig =
      app.add_command("rig", "A rig: what it would do, does and holds, and how it is");
  rig.require_command();
  auto args = std::make_shared<PlanArguments>();
  const Command plan = rig.add_command("plan", "The burst that a rig file would play");
  plan.add_option("--rig-file", args->rig_file,
                  "A rig file, or the name of one that ships: " + shipped_rigs())
      .shows_default();
  plan.add_option("--svg", args->svg, "Chart to write");
  plan.add_option("--vcd", args->vcd, "Edges to write, for a logic analyser's viewer");
  plan.add_flag("--json", args->json, "Report as JSON");
  plan.runs([args, exit_code] { *exit_code = run_plan(*args); });
  add_rig_command(rig, "status", "What a rig is doing, and what it holds",
                  [exit_code](const RigArguments& a) { *exit_code = run_status(a); });
  add_rig_list(rig, exit_code);
  add_rig_pair(rig, exit_code);
  add_rig_command(rig, "abort", "Lights off: drops the burst under way, clears a fault",
                  [exit_code](const RigArguments& a) { *exit_code = run_abort(a); });
  add_rig_selftest(rig, exit_code);
  add_rig_bursts(rig, exit_code);
}

}  // namespace lamella::apps
