// proto3 JSON with field names in snake_case.
#pragma once

#include <google/protobuf/message.h>

#include <filesystem>
#include <string>
#include <vector>

namespace lamella {

// Parses `text` into `message`. A wrong type or value throws Error that names `where` and the field;
// unknown fields are ignored and come back, one line each.
std::vector<std::string> parse_json(const std::string& text, const std::string& where,
                                    google::protobuf::Message* message);

std::vector<std::string> read_json(const std::filesystem::path& path,
                                   google::protobuf::Message* message);

std::string to_json(const google::protobuf::Message& message);

// Whole or not at all.
void write_json(const std::filesystem::path& path, const google::protobuf::Message& message);

}  // namespace lamella
