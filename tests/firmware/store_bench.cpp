#include "store_bench.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstring>

extern "C" {
#include "crc32c.h"
}

namespace fs = std::filesystem;

namespace {

constexpr uint32_t kBenchEdges = 100;  // two pages

void bench_timing(const void* context, uint32_t first_edge, lamella_v1_TimingEdges* page) {
  (void)context;
  *page = lamella_v1_TimingEdges_init_zero;
  page->first_edge = first_edge;
  page->total_edges = kBenchEdges;
  for (uint32_t i = first_edge; i < kBenchEdges && page->edges_count < 64; i++) {
    page->edges[page->edges_count++].planned_us = i;
  }
}

std::vector<uint8_t> read_back(struct store* store, uint64_t burst_id, uint32_t frame_id) {
  std::vector<uint8_t> bytes(kBenchFrameBytes + 1);
  bytes.resize(store_read(store, burst_id, frame_id, 0, bytes.data(), bytes.size()));
  return bytes;
}

void expect_frame(struct store* store, uint64_t id, uint32_t frame, const std::string& when) {
  lamella_v1_FrameOffer offer;
  const held_burst* burst = store_find_burst(store, id);
  ASSERT_TRUE(burst_get_offer(&store->disk, burst, frame, &offer)) << when;
  const std::vector<uint8_t> bytes = read_back(store, id, frame);
  EXPECT_EQ(bytes, bench_bytes(id, frame)) << when << ": burst " << id << " frame " << frame;
  EXPECT_EQ(offer.crc32c, crc32c_extend(0, bytes.data(), bytes.size())) << when;
}

void expect_burst(struct store* store, const held_burst& burst, const Promises& promises,
                  const std::string& when) {
  if (promises.whole.count(burst.id)) {
    EXPECT_TRUE(burst.whole) << when << ": " << burst.why;
  }
  EXPECT_EQ(burst.whole, burst.why[0] == '\0') << when << ": " << burst.why;
  EXPECT_EQ(burst.named_whole, burst.whole) << when;
  for (uint32_t i = 0; i < STORE_MAX_PHOTOGRAPHS; i++) {
    if (burst.frames[i] == FRAME_HELD) expect_frame(store, burst.id, i, when);
  }
  lamella_v1_BurstEnd end;
  lamella_v1_TimingEdges page;
  if (!burst.whole) return;
  ASSERT_TRUE(burst_get_end(&store->disk, &burst, &end)) << when;
  ASSERT_TRUE(burst_get_timing(&store->disk, &burst, 90, &page)) << when;
  EXPECT_EQ(page.edges_count, kBenchEdges - 90) << when;
  EXPECT_EQ(page.edges[0].planned_us, 90) << when;
}

// Every photograph that was promised, unless a host said that it has it.
void expect_kept(struct store* store, const Promises& promises, const std::string& when) {
  for (const auto& [id, frames] : promises.kept) {
    const held_burst* burst = store_find_burst(store, id);
    for (const uint32_t frame : frames) {
      const bool asked = promises.acking.count(id) && promises.acking.at(id).count(frame);
      const bool said = promises.acked.count(id) && promises.acked.at(id).count(frame);
      const bool there = burst != nullptr && burst->frames[frame] == FRAME_HELD;
      const std::string which =
          when + ": burst " + std::to_string(id) + " frame " + std::to_string(frame);
      EXPECT_TRUE(there || asked) << which << " was lost";
      EXPECT_FALSE(there && said) << which << " came back";
    }
  }
}

}  // namespace

std::vector<uint8_t> bench_bytes(uint64_t burst_id, uint32_t frame_id) {
  std::vector<uint8_t> bytes(kBenchFrameBytes);
  for (size_t i = 0; i < bytes.size(); i++) {
    bytes[i] = static_cast<uint8_t>(burst_id * 41 + frame_id * 17 + i * 3 + 1);
  }
  return bytes;
}

// In memory where it can be: what a disk keeps is the model's to say, and syncs take time.
TemporaryFolder::TemporaryFolder() {
  std::string name = fs::exists("/dev/shm") ? "/dev/shm" : "/tmp";
  name += "/lamella-store-XXXXXX";
  path_ = mkdtemp(name.data());
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

StoreBench::StoreBench(const fs::path& folder, size_t memory)
    : folder_(folder), block_(memory), calibration_{'{', '}'} {
  store_init(&store, block_.data(), block_.size());
}

StoreBench::~StoreBench() { store_close(&store); }

bool StoreBench::open() {
  char error[200] = "";
  const lam_status status = store_open(&store, folder_.c_str(), calibration_.data(),
                                       calibration_.size(), error, sizeof error);
  why = error;
  return status == LAM_OK;
}

uint64_t StoreBench::begin(uint32_t frames) {
  char error[200] = "";
  uint64_t id = 0;
  const store_order order = {frames, kBenchFrameBytes, false, false, nullptr};
  const lam_status status = store_begin(&store, &order, &id, error, sizeof error);
  why = error;
  return status == LAM_OK ? id : 0;
}

bool StoreBench::keep(uint64_t burst_id, uint32_t frame_id) {
  const std::vector<uint8_t> bytes = bench_bytes(burst_id, frame_id);
  size_t room = 0;
  uint8_t* place = store_room(&store, &room);
  if (room < bytes.size()) return false;
  std::memcpy(place, bytes.data(), bytes.size());
  struct photograph photograph = {};
  photograph.frame_id = frame_id;
  photograph.size = bytes.size();
  photograph.crc32c = crc32c_extend(0, bytes.data(), bytes.size());
  return store_keep(&store, &photograph);
}

bool StoreBench::end(const char* reason) {
  store_ending ending = {};
  ending.why = reason;
  ending.timing = bench_timing;
  return store_end(&store, &ending) == LAM_OK;
}

uint64_t StoreBench::burst(uint32_t frames, Promises* promises) {
  const uint64_t id = begin(frames);
  if (id == 0) return 0;
  promises->begun.insert(id);
  for (uint32_t i = 0; i < frames; i++) {
    if (!keep(id, i)) return 0;
    while (!store_is_written(&store, 1000)) continue;
    if (store_held(&store) == i + 1) promises->kept[id].insert(i);
  }
  if (!end()) return 0;
  promises->whole.insert(id);
  return id;
}

void StoreBench::acknowledge(uint64_t burst_id, uint32_t frame_id, Promises* promises) {
  promises->acking[burst_id].insert(frame_id);
  if (store_acknowledge(&store, burst_id, frame_id) == LAM_OK) {
    promises->acked[burst_id].insert(frame_id);
  }
}

void expect_promises_kept(const fs::path& folder, const Promises& promises,
                          const std::string& when) {
  StoreBench after(folder);
  ASSERT_TRUE(after.open()) << when << ": " << after.why;
  for (size_t i = 0; i < after.store.burst_count; i++) {
    expect_burst(&after.store, after.store.bursts[i], promises, when);
  }
  expect_kept(&after.store, promises, when);
  const uint64_t newest = promises.begun.empty() ? 0 : *promises.begun.rbegin();
  const uint64_t next = after.begin(1);
  EXPECT_GT(next, newest) << when << ": an id was given twice; " << after.why;
}
