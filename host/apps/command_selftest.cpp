// lamella rig selftest: what the rig finds when it tests itself, reading by reading.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>

#include "apps/commands.h"
#include "apps/counted.h"
#include "apps/process_rig.h"
#include "apps/report.h"
#include "apps/rig_option.h"
#include "base/error.h"
#include "base/progress.h"
#include "io/identity.h"
#include "io/link_client.h"
#include "io/paired_link.h"
#include "twin/rig.h"

namespace lamella::apps {

namespace {

const std::vector<std::string> kParts{"chain",     "blank", "leds",        "actuator", "cameras",
                                      "projector", "disk",  "temperature", "estop",    "latency"};

constexpr char kRow[] = "  {:<12} {:<30} {:<18} {:<24} {:<8} {}\n";

struct SelftestArguments {
  std::string rig;
  std::vector<std::string> only;
  std::vector<std::string> inject;
  fs::path led_reference;
  std::string subject = "sphere";
  bool learn = false, json = false;
};

// A number never without its unit.
std::string with_unit(const std::string& numbers, const v1::SelftestReading& r) {
  return r.unit().empty() ? numbers : numbers + " " + r.unit();
}

// Of four digits, and never with an exponent.
std::string figure(double value) {
  return std::abs(value) < 1e3 ? fmt::format("{:.4g}", value) : fmt::format("{:.0f}", value);
}

std::string value_text(const v1::SelftestReading& r) {
  if (!r.has_value()) return "";
  if (r.unit() == "yes/no") return r.value() != 0 ? "yes" : "no";
  return with_unit(figure(r.value()), r);
}

std::string limit_text(const v1::SelftestReading& r) {
  if (!r.has_low() && !r.has_high()) return "";
  if (r.unit() == "yes/no") return r.low() != 0 ? "yes" : "no";
  if (!r.has_low()) return with_unit("at most " + figure(r.high()), r);
  if (!r.has_high()) return with_unit("at least " + figure(r.low()), r);
  if (r.low() == r.high()) return with_unit(figure(r.low()), r);
  return with_unit(figure(r.low()) + " to " + figure(r.high()), r);
}

std::string verdict_text(const v1::SelftestReading& r) {
  if (r.verdict() == v1::SelftestReading::GOOD) return "good";
  return r.verdict() == v1::SelftestReading::BAD ? "BAD" : "skipped";
}

void print_result_table(const v1::SelftestResult& result, const std::string& rig) {
  fmt::print("{}: {}\n\n", rig,
             result.bad() == 0 ? std::string("good")
                               : fmt::format("{} {} not good", counted(result.bad(), "reading"),
                                             result.bad() == 1 ? "is" : "are"));
  fmt::print(kRow, "part", "what", "reading", "limit", "verdict", "");
  for (const v1::SelftestReading& r : result.readings()) {
    fmt::print(kRow, one_line(r.part()), one_line(r.what()), one_line(value_text(r)),
               one_line(limit_text(r)), verdict_text(r), one_line(r.note()));
  }
}

void print_result_json(const v1::SelftestResult& result, const std::string& rig) {
  nlohmann::ordered_json readings = nlohmann::ordered_json::array();
  for (const v1::SelftestReading& r : result.readings()) {
    nlohmann::ordered_json reading{{"part", r.part()}, {"what", r.what()}};
    if (r.has_value()) reading["value"] = r.value();
    if (!r.unit().empty()) reading["unit"] = r.unit();
    if (r.has_low()) reading["low"] = r.low();
    if (r.has_high()) reading["high"] = r.high();
    reading["verdict"] = verdict_text(r);
    if (!r.note().empty()) reading["note"] = r.note();
    readings.push_back(reading);
  }
  print_json({{"rig", rig}, {"bad", result.bad()}, {"readings", readings}});
}

void require_for_simulated_rig(bool given, const std::string& option) {
  if (given) throw_bad_input(option, "is for the simulated rig alone", "give --rig sim with it");
}

// Part by part, as their readings come.
v1::SelftestResult test_with(LinkClient rig, const SelftestArguments& args) {
  const size_t total =
      args.only.empty() ? kParts.size() : std::set(args.only.begin(), args.only.end()).size();
  Progress progress("self-test, parts read", int(total));
  return rig.selftest(args.only, args.learn, [&](const v1::SelftestResult& so_far) {
    std::set<std::string> read;
    for (const v1::SelftestReading& r : so_far.readings()) read.insert(r.part());
    progress.advance(int(read.size()));
  });
}

void require_learning_of_leds(const SelftestArguments& args) {
  const bool reads_leds =
      args.only.empty() || std::count(args.only.begin(), args.only.end(), "leds");
  if (args.learn && !reads_leds) {
    throw_bad_input("--learn", "learns how the LEDs light the stage, which --only leaves out",
                    "add leds to --only");
  }
}

v1::SelftestResult test(const SelftestArguments& args) {
  require_learning_of_leds(args);
  LinkOptions link;
  link.interrupted = interrupted;
  catch_interrupts();
  if (args.rig != "sim") {
    require_for_simulated_rig(!args.inject.empty(), "--inject");
    require_for_simulated_rig(!args.led_reference.empty(), "--led-reference");
    link.tls = tls_for(args.rig, config_folder());
    link.once_interrupted = "the rig ends its test by itself; test again to see what it finds";
    return test_with(LinkClient(args.rig, link), args);
  }
  SimulatedRigOptions options;
  options.subject = args.subject;
  options.scale = twin::kLeastScale;  // what an LED lights is weighed with 4 x 4 tents
  options.takes_bursts = false;
  options.inject = args.inject;
  options.led_reference = args.led_reference;
  require_simulated_rig(options);
  link.outlives_us = false;
  const SimulatedRig sim(options);
  return test_with(LinkClient(sim.address(), link), args);
}

}  // namespace

void add_rig_selftest(const Command& rig, int* exit_code) {
  auto args = std::make_shared<SelftestArguments>();
  const Command command = rig.add_command("selftest", "The rig tests itself, part by part");
  command.add_option("--rig", args->rig, "sim, or HOST:PORT of a rig")
      .check(rig_address(Simulated::kToo))
      .required();
  command.add_option("--only", args->only, "Parts to test; all of them where none is given")
      .one_of(kParts);
  command.add_flag("--learn", args->learn,
                   "The LEDs are good: take how they light the empty stage as the reference");
  command.add_option(
      "--inject", args->inject,
      "Faults of the simulated rig: dead-led:17, ... (lamella-rigd --help lists them)");
  command.add_option("--led-reference", args->led_reference,
                     "Where the simulated rig keeps what it learns");
  command.add_flag("--json", args->json, "Report as JSON");
  command.runs([args, exit_code] {
    const v1::SelftestResult result = test(*args);
    (args->json ? print_result_json : print_result_table)(result, args->rig);
    *exit_code = result.bad() > 0 ? 1 : 0;
  });
}

}  // namespace lamella::apps
