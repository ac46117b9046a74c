// How every command reports to a program, and what several of them take as arguments.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace lamella::apps {

// Prints `report` on standard output; a file name that is no UTF-8 is made printable.
void print_json(const nlohmann::ordered_json& report);

// `text` as UTF-8: bytes that are none are replaced.
std::string printable(const std::string& text);

// `text` of a rig or a file as a terminal may show it: what a terminal would obey stands as an
// escape, "\x1b". Ends of lines stay.
std::string shown(const std::string& text);

// The same on one line.
std::string one_line(const std::string& text);

// `value` with so many decimals; what rounds to nothing has no sign: "0.000".
std::string decimals(double value, int digits);

// The number that `text` is in decimal, as in a rig file; nothing where it is anything else, or
// more.
std::optional<double> decimal(const std::string& text);

// What keeps `text` from being one, empty where nothing does. CLI11 alone takes hexadecimal and
// nan.
std::string fault_of_decimal(const std::string& text);

// What keeps `text` from being a whole number from 0 to 2^64 - 1, empty where nothing does. CLI11
// alone takes "-1" for the largest of them.
std::string fault_of_whole_number(const std::string& text);

// "summary.p_L1_mean<=0.1": what an error may be at most.
struct FigureLimit {
  std::string figure;
  double value;
};

// Throws Error that names `option`, and such a limit as an `example`, where `text` is none.
FigureLimit figure_limit_from(const std::string& text, const std::string& option,
                              const std::string& example);

}  // namespace lamella::apps
