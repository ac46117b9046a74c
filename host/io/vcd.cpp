#include "io/vcd.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

namespace lamella {

namespace {

constexpr int64_t kPulse_ns = 10000;

bool is_moment(const std::string& line) {
  static const std::set<std::string> moments{"SHIFT", "COMMIT", "VBLANK", "ARRIVED"};
  return moments.count(line) > 0;
}

struct Change {
  int64_t t_ns;
  char symbol;
  bool level;
};

int64_t nanoseconds(const v1::TimedEdge& edge, EdgeTime time) {
  const double us = time == EdgeTime::kPlanned ? edge.planned_us() : edge.actual_us();
  return std::max<int64_t>(0, std::llround(us * 1e3));
}

}  // namespace

std::string vcd_text(const google::protobuf::RepeatedPtrField<v1::TimedEdge>& edges, EdgeTime time,
                     const std::set<std::string>& active_low) {
  std::map<std::string, char> symbols;
  for (const v1::TimedEdge& edge : edges) symbols.emplace(edge.line(), '\0');
  std::string text = "$timescale 1 ns $end\n$scope module rig $end\n";
  char next = '!';
  for (auto& [line, symbol] : symbols) {
    symbol = next++;
    text += fmt::format("$var wire 1 {} {} $end\n", symbol, line);
  }
  text += "$upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n";
  for (const auto& [line, symbol] : symbols) {
    const bool level = (line == "BLANK") != (active_low.count(line) > 0);
    text += fmt::format("{}{}\n", level ? '1' : '0', symbol);
  }
  text += "$end\n";
  std::vector<Change> changes;
  for (const v1::TimedEdge& edge : edges) {
    const int64_t t_ns = nanoseconds(edge, time);
    const char symbol = symbols[edge.line()];
    const bool moment = is_moment(edge.line());
    const bool level = (edge.value() != 0) != (active_low.count(edge.line()) > 0);
    changes.push_back({t_ns, symbol, moment || level});
    if (moment) changes.push_back({t_ns + kPulse_ns, symbol, false});
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const Change& a, const Change& b) { return a.t_ns < b.t_ns; });
  int64_t now_ns = 0;
  for (const Change& change : changes) {
    if (change.t_ns != now_ns) text += fmt::format("#{}\n", change.t_ns);
    now_ns = change.t_ns;
    text += fmt::format("{}{}\n", change.level ? '1' : '0', change.symbol);
  }
  return text;
}

}  // namespace lamella
