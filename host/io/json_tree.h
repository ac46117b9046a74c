// JSON of which no message lists the fields. The library's parser and writer are compiled once,
// here: in every file that reads or writes some they would be most of what there is to compile.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lamella {

// is_discarded() where `text` is no JSON.
nlohmann::json json_tree(const std::string& text);

// One line to a value, each level `indent` spaces further in. Bytes that are no UTF-8 are replaced.
std::string json_text(const nlohmann::json& tree, int indent);
std::string json_text(const nlohmann::ordered_json& tree, int indent);

}  // namespace lamella
