// A twin of one page for the firmware's tests. Its subject is a row of pixels: pixel i sees LED i
// alone, the last one the projector; each reflects S = D = 1/2. What it answers follows from the
// report by the contract of light in proto/PROTOCOL.md and nothing else.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

extern "C" {
#include "proto/twin.pb.h"
}

class FakeTwin {
 public:
  enum class Mood { kHonest, kSaysError, kHangsUpMidway, kDamagesBytes, kIsTooLarge };

  explicit FakeTwin(int rows = 1, Mood mood = Mood::kHonest);
  ~FakeTwin();
  FakeTwin(const FakeTwin&) = delete;
  FakeTwin& operator=(const FakeTwin&) = delete;

  const std::string& path() const { return path_; }
  std::vector<lamella_v1_ExposureReport> reports() const;

 private:
  void serve();
  bool answer_one(int host);
  void send_photograph(int host, const std::vector<uint8_t>& bytes);

  std::string path_;
  int rows_;
  Mood mood_;
  int listener_;
  std::atomic<int> host_{-1};
  mutable std::mutex mutex_;
  std::vector<lamella_v1_ExposureReport> reports_;
  std::thread thread_;
};

constexpr int kFakePixels = 151;       // of one row: 150 LEDs and the projector
constexpr double kFakeWhiteDn = 4000;  // of a pixel of radiance 1

// Brightness of every pixel under what a report says.
std::vector<double> fake_radiance(const lamella_v1_ExposureReport& report);

// The first row of a packed photograph, first channel, as radiance.
std::vector<double> unpack_first_row(const uint8_t* bytes);
