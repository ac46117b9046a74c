#include "io/json.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/util/json_util.h>
#include <google/protobuf/util/type_resolver_util.h>

#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "io/whole_file.h"

namespace lamella {

namespace {

using google::protobuf::Descriptor;
using google::protobuf::EnumDescriptor;
using google::protobuf::FieldDescriptor;
using nlohmann::json;

constexpr size_t kLongestQuote = 40;

std::string quoted(const json& value) {
  std::string text = value.dump();
  if (text.size() > kLongestQuote) text = text.substr(0, kLongestQuote) + "...";
  return text;
}

std::string names_of(const EnumDescriptor* type) {
  std::string names;
  for (int i = 1; i < type->value_count(); ++i) {  // 0 is "unspecified"
    names += (i > 1 ? ", " : "") + type->value(i)->name();
  }
  return names;
}

// Compares JSON with a message type, so that every complaint can name its field: protobuf's own
// parser names few, and takes an enum value that it does not know for none at all.
class Comparison {
 public:
  Comparison(const std::string& where, NonFinite non_finite)
      : where_(where), non_finite_(non_finite) {}

  void message(const json& value, const Descriptor* type, const std::string& at) {
    if (!value.is_object()) complain(at, value, "an object");
    for (const auto& [name, child] : value.items()) {
      const std::string path = at.empty() ? name : at + "." + name;
      const FieldDescriptor* field = type->FindFieldByName(name);
      if (!field) field = type->FindFieldByCamelcaseName(name);
      if (!field) {
        unknown_.push_back(path);
      } else if (!child.is_null()) {  // null stands for "left out"
        this->field(child, field, path);
      }
    }
  }

  const std::vector<std::string>& unknown() const { return unknown_; }

 private:
  void field(const json& value, const FieldDescriptor* field, const std::string& at) {
    if (field->is_map()) {
      if (!value.is_object()) complain(at, value, "an object");
      for (const auto& [key, child] : value.items()) {
        single(child, field->message_type()->map_value(), at + "." + key);
      }
    } else if (field->is_repeated()) {
      if (!value.is_array()) complain(at, value, "a list");
      for (size_t i = 0; i < value.size(); ++i) {
        single(value[i], field, at + "[" + std::to_string(i) + "]");
      }
    } else {
      single(value, field, at);
    }
  }

  void single(const json& value, const FieldDescriptor* field, const std::string& at) {
    switch (field->cpp_type()) {
      case FieldDescriptor::CPPTYPE_MESSAGE:
        return message(value, field->message_type(), at);
      case FieldDescriptor::CPPTYPE_ENUM:
        return enumerator(value, field->enum_type(), at);
      case FieldDescriptor::CPPTYPE_STRING:
        if (!value.is_string()) complain(at, value, "a text");
        return;
      case FieldDescriptor::CPPTYPE_BOOL:
        if (!value.is_boolean()) complain(at, value, "true or false");
        return;
      case FieldDescriptor::CPPTYPE_UINT32:
        if (!is_count(value)) complain(at, value, "a whole number from 0 to 4294967295");
        return;
      default:
        return number(value, at);
    }
  }

  static bool is_count(const json& value) {
    if (!value.is_number()) return false;
    const double number = value.get<double>();
    return number >= 0 && number <= std::numeric_limits<uint32_t>::max() &&
           number == std::floor(number);
  }

  void enumerator(const json& value, const EnumDescriptor* type, const std::string& at) {
    const bool known = value.is_string() && type->FindValueByName(value.get<std::string>());
    if (!known) complain(at, value, "one of " + names_of(type));
  }

  void number(const json& value, const std::string& at) {
    if (value.is_number()) return;
    const std::string text = value.is_string() ? value.get<std::string>() : "";
    const bool non_finite = text == "NaN" || text == "Infinity" || text == "-Infinity";
    if (!non_finite || non_finite_ == NonFinite::kRefused) complain(at, value, "a number");
  }

  [[noreturn]] void complain(const std::string& at, const json& value,
                             const std::string& expected) const {
    throw_bad_input(at.empty() ? where_ : where_ + ": " + at,
                    quoted(value) + " where " + expected + " is expected");
  }

  const std::string& where_;
  NonFinite non_finite_;
  std::vector<std::string> unknown_;
};

// nlohmann's own words: where, and the text around it, which names the field.
json parsed(const std::string& text, const std::string& where) {
  try {
    return json::parse(text);
  } catch (const json::exception& e) {
    std::string why = e.what();
    if (const size_t end = why.find("] "); end != std::string::npos) why = why.substr(end + 2);
    if (why.size() > 200) why = why.substr(0, 200) + "...";
    throw_bad_input(where, "not JSON (" + why + ")", "repair or replace it");
  }
}

// The entries of a map by their keys, where protobuf itself has another order in every run.
std::string sorted_wire(const google::protobuf::Message& message) {
  std::string wire;
  google::protobuf::io::StringOutputStream stream(&wire);
  google::protobuf::io::CodedOutputStream coded(&stream);
  coded.SetSerializationDeterministic(true);
  message.SerializeToCodedStream(&coded);
  coded.Trim();
  return wire;
}

constexpr const char* kTypes = "type.googleapis.com";

google::protobuf::util::TypeResolver* known_types() {
  static const std::unique_ptr<google::protobuf::util::TypeResolver> types(
      google::protobuf::util::NewTypeResolverForDescriptorPool(
          kTypes, google::protobuf::DescriptorPool::generated_pool()));
  return types.get();
}

}  // namespace

std::vector<std::string> parse_json(const std::string& text, const std::string& where,
                                    google::protobuf::Message* message, NonFinite non_finite) {
  const std::string byte_order_mark = "\xef\xbb\xbf";  // which some editors put before UTF-8
  if (text.starts_with(byte_order_mark)) {
    return parse_json(text.substr(byte_order_mark.size()), where, message, non_finite);
  }
  Comparison comparison(where, non_finite);
  comparison.message(parsed(text, where), message->GetDescriptor(), "");
  google::protobuf::util::JsonParseOptions options;
  options.ignore_unknown_fields = true;
  const auto status = google::protobuf::util::JsonStringToMessage(text, message, options);
  if (!status.ok()) throw_bad_input(where, std::string(status.message()), "correct the field");
  return comparison.unknown();
}

std::vector<std::string> read_json(const std::filesystem::path& path,
                                   google::protobuf::Message* message, NonFinite non_finite) {
  return parse_json(read_text(path), path.string(), message, non_finite);
}

std::string to_json(const google::protobuf::Message& message, Defaults defaults) {
  google::protobuf::util::JsonPrintOptions options;
  options.add_whitespace = true;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = defaults == Defaults::kWritten;
  std::string text;
  const auto status = google::protobuf::util::BinaryToJsonString(
      known_types(), std::string(kTypes) + "/" + message.GetDescriptor()->full_name(),
      sorted_wire(message), &text, options);
  if (!status.ok()) throw_bad_input("json", std::string(status.message()));
  return text;
}

void write_json(const std::filesystem::path& path, const google::protobuf::Message& message,
                Defaults defaults) {
  write_whole_text(path, to_json(message, defaults));
}

}  // namespace lamella
