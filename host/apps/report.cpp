#include "apps/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

#include "io/json_tree.h"

namespace lamella::apps {

namespace {

// Nothing that is measured or planned is known to more than twelve digits: what is beyond them is
// noise of binary fractions.
void drop_noise(nlohmann::ordered_json* value) {
  if (value->is_number_float()) {
    *value = std::strtod(fmt::format("{:.12g}", value->get<double>()).c_str(), nullptr);
  }
  if (!value->is_structured()) return;
  for (auto& part : *value) drop_noise(&part);
}

}  // namespace

void print_json(const nlohmann::ordered_json& report) {
  nlohmann::ordered_json tidy = report;
  drop_noise(&tidy);
  fmt::print("{}\n", json_text(tidy, 2));
}

std::string printable(const std::string& text) {
  return json_tree(json_text(nlohmann::json(text), -1));
}

std::string one_line(const std::string& text) {
  std::string line = printable(text);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return line;
}

std::string fault_of_whole_number(const std::string& text) {
  uint64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure == std::errc() && end == text.data() + text.size()) return "";
  return "\"" + text + "\" is no whole number from 0 to 18446744073709551615";
}

}  // namespace lamella::apps
