// What a session's manifest says of its rig, which a rig's calibration is too.
#pragma once

#include <string>

#include "io/session.h"
#include "session.pb.h"

namespace lamella {

// Lights, cameras, projector and patterns into `session`. Throws Error (kBadInput) with `where` and
// the field where a number is none that a rig can have.
void rig_from_message(const v1::Session& message, const std::string& where, Session* session);

// The patterns that a rig with this calibration shows: what it leaves out is the format's default.
v1::Patterns patterns_of(const v1::Session& message);

// The message of a rig's calibration, proto3 JSON; `session` becomes a rig of the same numbers.
// Throws as above, and where it is no JSON of a session.
v1::Session calibration_from(const std::string& json, const std::string& where, Session* session);

}  // namespace lamella
