// A store on a folder of its own, photographs whose bytes follow from their number, and what was
// promised about them: told before anything may be cut.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

extern "C" {
#include "store.h"
}

constexpr size_t kBenchFrameBytes = 300;

std::vector<uint8_t> bench_bytes(uint64_t burst_id, uint32_t frame_id);

// What somebody was told.
struct Promises {
  std::map<uint64_t, std::set<uint32_t>> kept;    // photographs counted as held
  std::map<uint64_t, std::set<uint32_t>> acking;  // asked to be forgotten, maybe not answered
  std::map<uint64_t, std::set<uint32_t>> acked;   // said to be forgotten
  std::set<uint64_t> begun, whole;
};

class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

class StoreBench {
 public:
  explicit StoreBench(const std::filesystem::path& folder, size_t memory = 2000);
  ~StoreBench();
  StoreBench(const StoreBench&) = delete;
  StoreBench& operator=(const StoreBench&) = delete;

  bool open();  // false: `why` says it
  uint64_t begin(uint32_t frames);
  bool keep(uint64_t burst_id, uint32_t frame_id);
  // Takes a burst; returns its id. `told` is called with every promise as it is made.
  uint64_t burst(uint32_t frames, Promises* promises);
  void acknowledge(uint64_t burst_id, uint32_t frame_id, Promises* promises);
  bool end(const char* why = nullptr);

  struct store store;
  std::string why;

 private:
  std::filesystem::path folder_;
  std::vector<uint8_t> block_;
  std::vector<uint8_t> calibration_;
};

// Opens what is left in the folder, as the daemon would, and holds it against what was promised.
void expect_promises_kept(const std::filesystem::path& folder, const Promises& promises,
                          const std::string& when);
