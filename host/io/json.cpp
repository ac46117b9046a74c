#include "io/json.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/json_util.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "io/whole_file.h"

namespace lamella {

namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

void list_unknown(const nlohmann::json& json, const Descriptor* type, const std::string& at,
                  std::vector<std::string>* unknown);

void list_unknown_in_field(const nlohmann::json& value, const FieldDescriptor* field,
                           const std::string& at, std::vector<std::string>* unknown) {
  if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE || field->is_map()) return;
  if (field->is_repeated() && value.is_array()) {
    for (size_t i = 0; i < value.size(); ++i) {
      list_unknown(value[i], field->message_type(), at + "[" + std::to_string(i) + "]", unknown);
    }
  } else {
    list_unknown(value, field->message_type(), at, unknown);
  }
}

void list_unknown(const nlohmann::json& json, const Descriptor* type, const std::string& at,
                  std::vector<std::string>* unknown) {
  if (!json.is_object()) return;
  for (const auto& [name, value] : json.items()) {
    const std::string path = at.empty() ? name : at + "." + name;
    const FieldDescriptor* field = type->FindFieldByName(name);
    if (!field) field = type->FindFieldByCamelcaseName(name);
    if (field) {
      list_unknown_in_field(value, field, path, unknown);
    } else {
      unknown->push_back(path);
    }
  }
}

nlohmann::json parsed(const std::string& text, const std::string& where) {
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& e) {
    throw_bad_input(where, std::string("not JSON (") + e.what() + ")", "repair or replace it");
  }
}

}  // namespace

std::vector<std::string> parse_json(const std::string& text, const std::string& where,
                                    google::protobuf::Message* message) {
  const nlohmann::json json = parsed(text, where);
  if (!json.is_object()) throw_bad_input(where, "not a JSON object");
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  const auto status = google::protobuf::util::JsonStringToMessage(text, message, options);
  if (!status.ok()) throw_bad_input(where, std::string(status.message()), "correct the field");
  std::vector<std::string> unknown;
  list_unknown(json, message->GetDescriptor(), "", &unknown);
  return unknown;
}

std::vector<std::string> read_json(const std::filesystem::path& path,
                                   google::protobuf::Message* message) {
  return parse_json(read_text(path), path.string(), message);
}

std::string to_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
  if (!status.ok()) throw_bad_input("json", std::string(status.message()));
  return text;
}

void write_json(const std::filesystem::path& path, const google::protobuf::Message& message) {
  write_whole_text(path, to_json(message));
}

}  // namespace lamella
