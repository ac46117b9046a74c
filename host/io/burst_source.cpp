#include "io/burst_source.h"

namespace lamella {

namespace {

// Photographs that a host had before are elsewhere: what is left is no whole burst.
std::string missing_of(const v1::HeldBurst& held) {
  if (!held.whole()) return held.why();
  return std::to_string(held.frames_acknowledged()) + " of its photographs went to a host before";
}

}  // namespace

void take_ending(const v1::BurstDone& done, Burst* burst) {
  burst->marked = done.marked();
  burst->late_edges = done.late_edges();
  burst->verdict = done.verdict();
  burst->shortfall = done.marked() ? done.verdict() : "";
}

Burst burst_of(BurstSource* source, const v1::HeldBurst& held) {
  Burst burst;
  burst.id = held.burst_id();
  burst.frame_count = held.frames_held();
  burst.flashing_confirmed = held.flashing_confirmed();
  burst.subject = held.subject();
  take_ending(source->ending(burst), &burst);
  if (!held.whole() || held.frames_acknowledged() > 0) burst.shortfall = missing_of(held);
  return burst;
}

std::string describe(const v1::FrameOffer& offer) {
  const v1::Frame& f = offer.frame();
  std::string text = "frame " + std::to_string(offer.frame_id()) + " (" + f.camera() + " " +
                     v1::Frame::Role_Name(f.role());
  if (f.has_index()) text += " " + std::to_string(f.index());
  return text + " " + v1::Frame::Analyser_Name(f.analyser()) + ")";
}

}  // namespace lamella
