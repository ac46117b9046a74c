// The option --rig, as every command that talks to a rig checks it.
#pragma once

#include "apps/command_line.h"

namespace lamella::apps {

enum class Simulated { kToo, kNot };

// A rig's HOST:PORT, or "sim" where that may be given. What cannot be one is refused before
// anything is begun, a name that nobody knows too.
ArgumentFault rig_address(Simulated simulated);

}  // namespace lamella::apps
