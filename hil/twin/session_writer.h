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

// Takes and writes the frames and session.json; regions.png and truth/ come from write_truth.
void write_session(const fs::path& folder, const Photographer& photographer, Studio* studio);

}  // namespace lamella::twin
