// Where a burst's photographs come from: a rig that answers (io/link_client.h), or the folder on a
// rig's disk (io/store_folder.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "link.pb.h"

namespace lamella {

struct Burst {
  uint64_t id = 0;
  uint32_t step_count = 0;
  double planned_us = 0;
  uint32_t frame_count = 0;
  bool flashing_confirmed = false;
  std::string subject;  // as it was asked for; empty: nobody named one
  bool marked = false;  // an edge came later than its tolerance
  uint32_t late_edges = 0;
  std::string verdict;
  std::string shortfall;    // what is bad or missing of it, in the rig's words; empty: nothing
  bool just_taken = false;  // by the rig as it is now; one that is held may be older than its files
};

class BurstSource {
 public:
  virtual ~BurstSource() = default;

  // As messages name it: "rig 10.0.0.7:7391", or the folder.
  virtual std::string name() const = 0;

  // What the rig says of itself; nullptr where only its disk is there.
  virtual const v1::Welcome* answering() const { return nullptr; }

  // Of every burst that is held, partial ones too.
  virtual std::vector<v1::HeldBurst> held() = 0;

  // The calibration of the rig when it took the burst: a lamella.v1.Session in proto3 JSON, without
  // frames.
  virtual std::string calibration(const Burst& burst) = 0;

  // False where another stands in for it.
  virtual bool gives_own_calibration() const { return true; }

  // Every photograph of the burst that is still there, in the rig's order.
  virtual std::vector<v1::FrameOffer> offers(const Burst& burst) = 0;

  // How the burst ended; without a verdict where it was cut off.
  virtual v1::BurstDone ending(const Burst& burst) = 0;

  // The raw bytes of one, its length and CRC32C checked.
  virtual std::vector<uint8_t> photograph(const v1::FrameOffer& offer) = 0;

  // Every edge of the burst, as planned and as it happened; of a partial one maybe none.
  virtual v1::TimingEdges timing(const Burst& burst) = 0;
};

// What the rig says of a burst that is over.
void take_ending(const v1::BurstDone& done, Burst* burst);

// The burst that is held, with all that its source says of it.
Burst burst_of(BurstSource* source, const v1::HeldBurst& held);

// "frame 7 (left STRIPES 2 CROSS)".
std::string describe(const v1::FrameOffer& offer);

}  // namespace lamella
