// proto3 JSON with field names in snake_case.
#pragma once

#include <google/protobuf/message.h>

#include <filesystem>
#include <string>
#include <vector>

namespace lamella {

// proto3 JSON writes what is not a finite number as "NaN", "Infinity" or "-Infinity".
enum class NonFinite { kRefused, kAllowed };

// Parses `text` into `message`. A wrong type or value throws Error that names `where` and the
// field, like "session.json: frames[3].exposure_us"; unknown fields are ignored and come back, one
// each.
std::vector<std::string> parse_json(const std::string& text, const std::string& where,
                                    google::protobuf::Message* message,
                                    NonFinite non_finite = NonFinite::kRefused);

std::vector<std::string> read_json(const std::filesystem::path& path,
                                   google::protobuf::Message* message,
                                   NonFinite non_finite = NonFinite::kRefused);

// Fields that hold what proto3 calls their default (0, false, "") are left out, or written too.
enum class Defaults { kLeftOut, kWritten };

// The entries of a map stand by their keys: equal messages are equal texts.
std::string to_json(const google::protobuf::Message& message,
                    Defaults defaults = Defaults::kLeftOut);

// Whole or not at all.
void write_json(const std::filesystem::path& path, const google::protobuf::Message& message,
                Defaults defaults = Defaults::kLeftOut);

}  // namespace lamella
