#include "io/json_tree.h"

#include <nlohmann/json.hpp>

namespace lamella {

namespace {

template <class Json>
std::string text_of(const Json& tree, int indent) {
  return tree.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

nlohmann::json json_tree(const std::string& text) {
  return nlohmann::json::parse(text, nullptr, false);
}

std::string json_text(const nlohmann::json& tree, int indent) { return text_of(tree, indent); }

std::string json_text(const nlohmann::ordered_json& tree, int indent) {
  return text_of(tree, indent);
}

}  // namespace lamella
