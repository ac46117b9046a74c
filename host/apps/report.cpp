#include "apps/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace lamella::apps {

void print_json(const nlohmann::ordered_json& report) {
  fmt::print("{}\n", report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

std::string printable(const std::string& text) {
  using nlohmann::json;
  return json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace));
}

CLI::Validator whole_number() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        uint64_t value = 0;
        const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (failure == std::errc() && end == text.data() + text.size()) return "";
        return "\"" + text + "\" is no whole number from 0 to 18446744073709551615";
      },
      "");
}

}  // namespace lamella::apps
