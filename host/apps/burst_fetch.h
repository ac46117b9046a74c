// A burst that a rig holds, or that lies on a disk from one, as a session on this disk.
#pragma once

#include <string>

#include "calib/receive.h"
#include "io/burst_source.h"
#include "io/whole_file.h"

namespace lamella::apps {

struct FetchedBurst {
  v1::HeldBurst held;
  fs::path folder;         // empty: nothing of it was whole
  bool was_there = false;  // another run had brought it: one that was cut off, or is at it now
  bool marked = false;     // a photograph is bad or missing, and was not retaken
  std::string unfit;       // why it cannot be fitted; empty: it can, or was there
  std::vector<std::string> warnings;
  std::string failed;  // why it could not be fetched; empty: it could
  std::vector<v1::FrameOffer> offers;
};

// Says in the folder of a session which burst it is of, so that a later fetch finds it there.
void write_burst_note(const fs::path& session, const BurstSource& source, const v1::HeldBurst& held,
                      const std::vector<v1::FrameOffer>& offers);

// The burst in OUT/burst-000012, or OUT/burst-000012.partial with what is whole of it, and on the
// disk when this returns. A folder that holds another burst of that number (of another rig) is left
// alone: the new one gets a name with -2, -3 and so on.
FetchedBurst fetch_burst(BurstSource* source, const v1::HeldBurst& held, const fs::path& out);

// The same, but a burst that the source cannot give is `failed` and no Error, as long as the source
// itself still answers: one that is damaged does not keep those after it from being fetched.
FetchedBurst try_to_fetch(BurstSource* source, const v1::HeldBurst& held, const fs::path& out);

}  // namespace lamella::apps
