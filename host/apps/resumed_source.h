// A rig whose photographs pass through a folder on this disk: a run that was ended in the middle of
// one goes on, in the next run, at the byte that it had reached.
#pragma once

#include "io/burst_source.h"
#include "io/link_client.h"
#include "io/whole_file.h"

namespace lamella::apps {

class ResumedSource : public BurstSource {
 public:
  ResumedSource(LinkClient* rig, fs::path folder) : rig_(rig), folder_(std::move(folder)) {}

  std::string name() const override { return rig_->name(); }
  const v1::Welcome* answering() const override { return rig_->answering(); }
  std::vector<v1::HeldBurst> held() override { return rig_->held(); }
  std::string calibration(const Burst& burst) override { return rig_->calibration(burst); }
  std::vector<v1::FrameOffer> offers(const Burst& burst) override { return rig_->offers(burst); }
  v1::BurstDone ending(const Burst& burst) override { return rig_->ending(burst); }
  v1::TimingEdges timing(const Burst& burst) override { return rig_->timing(burst); }
  std::vector<uint8_t> photograph(const v1::FrameOffer& offer) override;

  // What has become a session is needed no longer.
  void forget(const std::vector<v1::FrameOffer>& offers);

 private:
  fs::path file_of(const v1::FrameOffer& offer) const;

  LinkClient* rig_;
  fs::path folder_;
};

}  // namespace lamella::apps
