// The folder on a rig's disk (PROTOCOL.md, "On the rig's disk"), read on a host: a disk that was
// taken out of a rig. Nothing in it is trusted and nothing is changed.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "io/burst_source.h"
#include "store.pb.h"

namespace lamella {

class StoreFolder : public BurstSource {
 public:
  // Throws Error (kBadInput) where there is no such folder, or it holds nothing that a rig wrote.
  explicit StoreFolder(std::filesystem::path folder);

  std::string name() const override { return folder_.string(); }
  std::vector<v1::HeldBurst> held() override;
  std::string calibration(const Burst& burst) override;
  std::vector<v1::FrameOffer> offers(const Burst& burst) override;
  v1::BurstDone ending(const Burst& burst) override;
  std::vector<uint8_t> photograph(const v1::FrameOffer& offer) override;
  v1::TimingEdges timing(const Burst& burst) override;

 private:
  struct Found {
    std::filesystem::path folder;
    v1::HeldBurst about;
    std::map<uint32_t, v1::FrameOffer> frames;  // whole, not acknowledged
  };

  void read_burst(uint64_t id, const std::filesystem::path& folder);
  const Found& found(uint64_t burst_id) const;

  std::filesystem::path folder_;
  std::map<uint64_t, Found> bursts_;
};

// Whether `folder` is where a rig keeps its bursts: its counter of bursts lies there.
bool is_rigs_store(const std::filesystem::path& folder);

// Throws Error where `place` is such a folder, or lies in one: what a host puts there a rig does
// not know, and it would not start again.
void require_outside_stores(const std::filesystem::path& place);

// The record at the front of `bytes`, from which it is cut; false where there is no sound one.
bool take_record(std::string* bytes, google::protobuf::MessageLite* message);

}  // namespace lamella
