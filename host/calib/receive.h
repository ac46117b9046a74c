// A burst taken off a rig and made into a session: photographs developed, timing attested.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/exr.h"
#include "io/link_client.h"
#include "io/whole_file.h"
#include "session.pb.h"

namespace lamella {

struct Reception {
  v1::Session manifest;
  std::vector<v1::FrameOffer> offers;  // to be acknowledged once the session is in its place
  v1::TimingEdges timing;
  size_t raw_bytes = 0;
  double transfer_s = 0;
  std::vector<std::string> marked;   // photographs to be taken again, in words
  std::vector<std::string> retaken;  // photographs that the rig took again itself
  std::string unfit;                 // why it cannot be fitted; empty: it can
  std::vector<std::string> warnings;
};

// Fetches every photograph of the burst and writes frames/, timing.json and session.json into
// `folder`, which is the caller's to commit. Photographs are developed and written while the next
// ones arrive; `progress(done)` is called after each has arrived. What the rig sends is checked
// against its own calibration; where it disagrees, or lacks what the burst does not say that it
// lacks, an Error (kRig) that names rig and burst says so. Regions are a picture of a subject,
// which no rig sends: where its calibration names some they are left out, with a warning.
Reception receive_session(BurstSource* rig, const Burst& burst, const WholeFolder& folder,
                          const std::function<void(int)>& progress);

enum class Replaced { kToo, kNot };  // edges of photographs that were taken again

// Largest |actual - planned| over these edges, us; 0 where there are none.
double largest_edge_error_us(const v1::TimingEdges& timing, Replaced replaced);

// frames/left/07_stripes_2_cross.exr; one that was replaced: frames/retaken/left/..._shot_7.exr
std::string frame_file(const v1::Frame& frame);

}  // namespace lamella
