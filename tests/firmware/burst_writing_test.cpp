// Raw frames reach the disk while the burst runs, and no edge moves for it.
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>

#include "store_bench.h"
#include "test_rig.h"

extern "C" {
#include "hal_sim.h"
#include "session.h"
}

namespace fs = std::filesystem;
using namespace std::chrono_literals;

namespace {

constexpr unsigned kFrames = 2 * BURST_STEPS;

// A disk that stands still at its first photograph until it is let go.
class SlowDisk {
 public:
  static int before(void* self, const disk_step* step) {
    return static_cast<SlowDisk*>(self)->stand_still(*step);
  }
  // Until a photograph waits for it.
  void await_photograph() {
    std::unique_lock lock(mutex_);
    moved_.wait(lock, [this] { return waits_; });
  }
  void let_go() {
    const std::lock_guard lock(mutex_);
    goes_ = true;
    moved_.notify_all();
  }

 private:
  int stand_still(const disk_step& step) {
    const bool photograph = step.action == DISK_WRITE && std::strstr(step.path, ".raw") != nullptr;
    std::unique_lock lock(mutex_);
    if (!photograph) return 0;
    waits_ = true;
    moved_.notify_all();
    moved_.wait(lock, [this] { return goes_; });
    return 0;
  }

  std::mutex mutex_;
  std::condition_variable moved_;
  bool waits_ = false, goes_ = false;
};

// A rig whose cameras are read while it plays, as a board's are, and a disk.
struct WritingBench {
  WritingBench() : rig(test_rig("vm")), block(4 << 20) {
    EXPECT_EQ(hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, kSimNoFaults, nullptr), LAM_OK);
    EXPECT_EQ(hal_sim_use_test_frames(&sim), LAM_OK) << sim.hal.error;
    store_init(&store, block.data(), block.size());
    EXPECT_EQ(store_open(&store, folder.path().c_str(), nullptr, 0, why, sizeof why), LAM_OK)
        << why;
    session_init(&session, &rig, &sim.hal, &store);
  }
  ~WritingBench() {
    session_close(&session);
    sim.hal.close(&sim);
    store_close(&store);
  }

  size_t photographs_on_disk() const {
    size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      count += entry.path().extension() == ".record";
    }
    return count;
  }

  // Ten seconds are more than any machine takes where nothing waits for the disk.
  void play_to_the_last_edge(SlowDisk* disk) {
    const auto end = std::chrono::steady_clock::now() + 10s;
    ASSERT_EQ(session_request_burst(&session, false), LAM_OK) << session.refusal;
    do {
      session_work(&session);
      if (session.offered > 0) disk->await_photograph();
      ASSERT_LT(std::chrono::steady_clock::now(), end) << "edges wait for the disk";
    } while (session.playing);
  }

  void expect_no_edge_moved() const {
    const take& played = session.roll.takes[0];
    for (size_t i = 0; i < played.timeline.count; i++) {
      ASSERT_TRUE(played.player.played[i].done) << i;
      EXPECT_NEAR(played.player.played[i].actual_us, played.timeline.edges[i].t_us, 0.5) << i;
    }
    EXPECT_EQ(session.roll.take_count, 1u);
  }

  struct rig rig;
  std::vector<uint8_t> block;
  const TemporaryFolder folder;
  char why[200];
  struct hal_sim sim;
  struct store store;
  struct session session;
};

}  // namespace

TEST(BurstWriting, PhotographsAreOnTheDiskBeforeTheLastEdgeIsPlayed) {
  WritingBench bench;
  ASSERT_EQ(session_request_burst(&bench.session, false), LAM_OK) << bench.session.refusal;
  size_t most_while_playing = 0;
  while (session_work(&bench.session)) {
    if (!bench.session.playing || bench.session.offered < BURST_STEPS / 2) continue;
    // Time stands still while we look: the disk gets what it needs of it.
    while (collector_done(&bench.session.collector) < 2 * bench.session.offered) {
      collector_wait(&bench.session.collector, 1e3);
    }
    while (!store_is_written(&bench.store, 100)) continue;
    most_while_playing = std::max(most_while_playing, bench.photographs_on_disk());
  }
  EXPECT_GE(most_while_playing, kFrames / 2);
  EXPECT_LT(most_while_playing, kFrames);
  EXPECT_EQ(bench.photographs_on_disk(), kFrames);
  EXPECT_FALSE(bench.session.done.marked) << bench.session.done.verdict;
  bench.expect_no_edge_moved();
}

TEST(BurstWriting, ADiskThatStandsStillMovesNoEdge) {
  WritingBench bench;
  SlowDisk disk;
  bench.store.disk.before = SlowDisk::before;
  bench.store.disk.context = &disk;
  bench.play_to_the_last_edge(&disk);
  EXPECT_EQ(bench.photographs_on_disk(), 0u);
  bench.expect_no_edge_moved();
  disk.let_go();
  while (session_work(&bench.session)) continue;
  EXPECT_EQ(bench.photographs_on_disk(), kFrames);
  EXPECT_FALSE(bench.session.done.marked) << bench.session.done.verdict;
}

TEST(BurstWriting, TestFramesNeedARigFileThatSaysWhatItsCamerasAre) {
  struct rig rig = test_rig();
  struct hal_sim sim;
  ASSERT_EQ(hal_sim_open(&sim, &rig, SIM_CLOCK_VIRTUAL, kSimNoFaults, nullptr), LAM_OK);
  EXPECT_EQ(hal_sim_use_test_frames(&sim), LAM_BAD_INPUT);
  EXPECT_NE(std::string(sim.hal.error).find("camera.width_px"), std::string::npos) << sim.hal.error;
  sim.hal.close(&sim);
}
