// What is bad or missing of a session's burst, as its rig said when it handed it over: for people,
// who read it beside what the session lacks. No step of a fit asks for it.
#pragma once

#include <filesystem>
#include <string>

namespace lamella {

// "" where the rig said nothing of the kind. Throws as read_json().
std::string read_shortfall(const std::filesystem::path& session);

}  // namespace lamella
