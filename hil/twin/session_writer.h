// A whole session of the twin's subject, written at once: the twenty photographs of both cameras.
#pragma once

#include "twin/studio.h"

namespace lamella::twin {

// The burst as the paper has it: every frame of one camera with the light it is taken under.
struct Shot {
  Frame frame;
  Exposure exposure;
};
std::vector<Shot> burst(const Session& rig, const std::string& camera);

// Works out the depolarized light of the whole burst, for both cameras, many states at once.
void prepare_burst(const Session& rig, Studio* studio);

// Takes and writes the frames and session.json, the subject drifting as the photographer has it;
// the sensor is the studio's. regions.png and truth/ come from write_truth.
void write_session(const fs::path& folder, const Photographer& photographer, Studio* studio);

}  // namespace lamella::twin
