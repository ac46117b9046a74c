// A source whose bursts were taken with a calibration that is of no use: another stands in for it.
#pragma once

#include <memory>

#include "io/burst_source.h"
#include "io/exr.h"

namespace lamella::apps {

class RecalibratedSource : public BurstSource {
 public:
  // Throws Error (kBadInput) where the file is no calibration.
  RecalibratedSource(std::unique_ptr<BurstSource> source, fs::path calibration);

  // Throws Error (kBadInput) where the file is not of the rig that took the burst: as far as its
  // own calibration, or else the rig that answers, says what that was.
  std::string calibration(const Burst& burst) override;
  bool gives_own_calibration() const override { return false; }

  // Throws Error (kBadInput) where the session in `folder`, of an earlier run, has another.
  void require_same_in(const fs::path& folder) const;

  std::string name() const override { return source_->name(); }
  const v1::Welcome* answering() const override { return source_->answering(); }
  std::vector<v1::HeldBurst> held() override { return source_->held(); }
  std::vector<v1::FrameOffer> offers(const Burst& burst) override { return source_->offers(burst); }
  v1::BurstDone ending(const Burst& burst) override { return source_->ending(burst); }
  v1::TimingEdges timing(const Burst& burst) override { return source_->timing(burst); }
  std::vector<uint8_t> photograph(const v1::FrameOffer& offer) override {
    return source_->photograph(offer);
  }

 private:
  void require_rig_of(const Burst& burst);
  void require_cameras_of(const Burst& burst);

  std::unique_ptr<BurstSource> source_;
  fs::path file_;
  std::string text_;
  v1::Session manifest_;
};

}  // namespace lamella::apps
