#include "apps/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

#include "base/error.h"
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

std::string decimals(double value, int digits) {
  const std::string text = fmt::format("{:.{}f}", value, digits);
  const bool is_nothing = text.find_first_of("123456789") == std::string::npos;
  return is_nothing && text.front() == '-' && std::isfinite(value) ? text.substr(1) : text;
}

std::string printable(const std::string& text) {
  return json_tree(json_text(nlohmann::json(text), -1));
}

std::string shown(const std::string& text) {
  const std::string utf8 = printable(text);
  std::string safe;
  for (size_t i = 0; i < utf8.size(); ++i) {
    const auto byte = static_cast<unsigned char>(utf8[i]);
    const auto next = static_cast<unsigned char>(i + 1 < utf8.size() ? utf8[i + 1] : 0);
    if (byte == 0xc2 && next < 0xa0) {  // U+0080 to U+009F: control characters of one byte once
      safe += fmt::format("\\x{:02x}", next);
      ++i;
    } else if ((byte < 0x20 && byte != '\n') || byte == 0x7f) {
      safe += fmt::format("\\x{:02x}", byte);
    } else {
      safe += utf8[i];
    }
  }
  return safe;
}

std::string one_line(const std::string& text) {
  std::string line = shown(text);
  for (size_t at = 0; (at = line.find('\n', at)) != std::string::npos;) line.replace(at, 1, "\\n");
  return line;
}

std::optional<double> decimal(const std::string& text) {
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [at, failure] = std::from_chars(text.data(), end, number);
  if (failure != std::errc() || at != end || !std::isfinite(number)) return {};
  return number;
}

std::string fault_of_decimal(const std::string& text) {
  return decimal(text) ? "" : "\"" + text + "\" is no decimal number";
}

std::string fault_of_whole_number(const std::string& text) {
  uint64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure == std::errc() && end == text.data() + text.size()) return "";
  return "\"" + text + "\" is no whole number from 0 to 18446744073709551615";
}

FigureLimit figure_limit_from(const std::string& text, const std::string& option,
                              const std::string& example) {
  const size_t at = text.find("<=");
  const auto value = at == std::string::npos ? std::nullopt : decimal(text.substr(at + 2));
  if (value) return {text.substr(0, at), *value};
  throw_bad_input(option, "\"" + text + "\" is not FIGURE<=VALUE", "for example " + example);
}

}  // namespace lamella::apps
