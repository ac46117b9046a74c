// A source whose bursts were taken with a calibration that is of no use: another stands in for it.
#pragma once

#include <memory>

#include "io/burst_source.h"
#include "io/exr.h"

namespace lamella::apps {

class RecalibratedSource : public BurstSource {
 public:
  // Throws Error (kBadInput) where the file is no calibration.
  RecalibratedSource(std::unique_ptr<BurstSource> source, const fs::path& calibration);

  std::string name() const override { return source_->name(); }
  const v1::Welcome* answering() const override { return source_->answering(); }
  std::vector<v1::HeldBurst> held() override { return source_->held(); }
  std::string calibration(const Burst&) override { return calibration_; }
  std::vector<v1::FrameOffer> offers(const Burst& burst) override { return source_->offers(burst); }
  v1::BurstDone ending(const Burst& burst) override { return source_->ending(burst); }
  v1::TimingEdges timing(const Burst& burst) override { return source_->timing(burst); }
  std::vector<uint8_t> photograph(const v1::FrameOffer& offer) override {
    return source_->photograph(offer);
  }

 private:
  std::unique_ptr<BurstSource> source_;
  std::string calibration_;
};

}  // namespace lamella::apps
