#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <thread>
#include <tuple>

#include "store_bench.h"

namespace fs = std::filesystem;

namespace {

// Every write after the first `left` bytes fails as on a full disk.
int full_after(void* context, const disk_step* step) {
  long* left = static_cast<long*>(context);
  if (step->action != DISK_WRITE) return 0;
  *left -= static_cast<long>(step->size);
  return *left < 0 ? ENOSPC : 0;
}

bool keep_all(StoreBench* bench, uint64_t id, uint32_t frames) {
  for (uint32_t i = 0; i < frames; i++) {
    if (!bench->keep(id, i)) return false;
  }
  while (!store_is_written(&bench->store, 1000)) continue;
  return store_fault(&bench->store)[0] == '\0';
}

// What a store on a small file system that cannot be written to says of a burst; "" where this
// process may mount none.
std::string refusal_on_a_read_only_disk(const fs::path& folder) {
  const fs::path told = folder / "told", disk = folder / "disk";
  fs::create_directory(disk);
  const pid_t child = fork();
  if (child == 0) {
    const bool mounted = unshare(CLONE_NEWUSER | CLONE_NEWNS) == 0 &&
                         mount("none", disk.c_str(), "tmpfs", MS_RDONLY, "size=64k") == 0;
    if (!mounted) _exit(0);
    StoreBench bench(disk);
    if (!bench.open()) _exit(1);
    const store_order order = {40, 1e6, false, false, nullptr};
    uint64_t id = 0;
    char why[160];
    if (store_begin(&bench.store, &order, &id, why, sizeof why) != LAM_HARDWARE) _exit(2);
    std::ofstream(told) << why;
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  std::ifstream in(told);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST(Store, ABurstIsWholeOnDiskOnceItHasEnded) {
  const TemporaryFolder folder;
  Promises promises;
  StoreBench bench(folder.path());
  ASSERT_TRUE(bench.open()) << bench.why;
  const uint64_t id = bench.burst(40, &promises);
  EXPECT_EQ(id, 1u);
  EXPECT_EQ(store_held(&bench.store), 40u);
  EXPECT_TRUE(fs::exists(folder.path() / "burst-000001" / "frame-39.raw"));
  EXPECT_FALSE(fs::exists(folder.path() / "burst-000001.partial"));
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
  }
}

TEST(Store, MemoryForTwoPhotographsIsEnoughForForty) {
  const TemporaryFolder folder;
  Promises promises;
  StoreBench bench(folder.path(), 2 * kBenchFrameBytes + 50);
  ASSERT_TRUE(bench.open());
  const uint64_t id = bench.begin(40);
  EXPECT_TRUE(keep_all(&bench, id, 40)) << store_fault(&bench.store);
  EXPECT_TRUE(bench.end());
  bench.store.disk.before = nullptr;
  store_close(&bench.store);
  promises.begun = promises.whole = {id};
  for (uint32_t i = 0; i < 40; i++) promises.kept[id].insert(i);
  expect_promises_kept(folder.path(), promises, "after forty");
}

TEST(Store, AFullDiskIsAFaultThatSaysSoAndWhatWasWholeStays) {
  const TemporaryFolder folder;
  long left = 20 * static_cast<long>(kBenchFrameBytes);
  StoreBench bench(folder.path());
  ASSERT_TRUE(bench.open());
  const uint64_t id = bench.begin(40);
  bench.store.disk.context = &left;
  bench.store.disk.before = full_after;
  EXPECT_FALSE(keep_all(&bench, id, 40));
  EXPECT_STREQ(store_fault(&bench.store),
               "the rig's disk does not take the photographs: No space left on device");
  EXPECT_FALSE(bench.end());
  const size_t whole = store_held(&bench.store);
  EXPECT_GT(whole, 10u);
  EXPECT_TRUE(bench.end(store_fault(&bench.store)));
  const held_burst* held = store_find_burst(&bench.store, id);
  ASSERT_NE(held, nullptr);
  EXPECT_FALSE(held->whole);
  EXPECT_NE(std::string(held->why).find("No space left on device; " + std::to_string(whole) +
                                        " of 40 photographs are whole"),
            std::string::npos)
      << held->why;
  store_close(&bench.store);
  StoreBench after(folder.path());
  ASSERT_TRUE(after.open());
  EXPECT_EQ(after.store.bursts[0].held, whole);
}

TEST(Store, ABurstThatTheDiskHasNoRoomForIsRefusedBeforeItBegins) {
  const TemporaryFolder folder;
  StoreBench bench(folder.path());
  ASSERT_TRUE(bench.open());
  const store_order order = {40, 1e15, false, false, nullptr};
  uint64_t id = 0;
  char why[160];
  EXPECT_EQ(store_begin(&bench.store, &order, &id, why, sizeof why), LAM_STORE_FULL);
  EXPECT_NE(std::string(why).find("MB free and a burst needs"), std::string::npos) << why;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 0);
}

TEST(Store, ADiskThatDoesNotTakeABurstIsNotCalledFullButByItsFaultWithWhatToDo) {
  static int fault;
  for (const auto& [error, status, says] : std::vector<std::tuple<int, lam_status, std::string>>{
           {EROFS, LAM_HARDWARE, "disk: Read-only file system: mount it read-write"},
           {EACCES, LAM_HARDWARE, "disk: Permission denied: the user that lamella-rigd runs as"},
           {EIO, LAM_HARDWARE, "disk: Input/output error: the disk fails"},
           {ENOSPC, LAM_STORE_FULL, "disk: No space left on device"}}) {
    const TemporaryFolder folder;
    StoreBench bench(folder.path());
    ASSERT_TRUE(bench.open());
    fault = error;
    bench.store.disk.before = [](void*, const disk_step*) { return fault; };
    const store_order order = {40, kBenchFrameBytes, false, false, nullptr};
    uint64_t id = 0;
    char why[160];
    EXPECT_EQ(store_begin(&bench.store, &order, &id, why, sizeof why), status) << why;
    EXPECT_NE(std::string(why).find("a burst cannot be begun on the rig's " + says),
              std::string::npos)
        << why;
  }
}

TEST(Store, AReadOnlyDiskIsSaidToBeSoThoughItHasNoRoomEither) {
  const TemporaryFolder folder;
  const std::string why = refusal_on_a_read_only_disk(folder.path());
  if (why.empty()) GTEST_SKIP() << "nothing may be mounted here";
  EXPECT_NE(why.find("Read-only file system: mount it read-write"), std::string::npos) << why;
}

TEST(Store, ATrialOfAReadOnlyDiskSaysWhatToDo) {
  const TemporaryFolder folder;
  StoreBench bench(folder.path());
  ASSERT_TRUE(bench.open());
  bench.store.disk.before = [](void*, const disk_step*) { return EROFS; };
  double free_bytes = 0, bytes_per_s = 0;
  char error[112];
  EXPECT_FALSE(store_measure(&bench.store, &free_bytes, &bytes_per_s, error));
  EXPECT_NE(std::string(error).find("bytes: Read-only file system: mount it read-write"),
            std::string::npos)
      << error;
}

TEST(Store, TellsWhetherABurstMayBringMorePhotographsThanItBeganWith) {
  const TemporaryFolder folder;
  StoreBench bench(folder.path());
  EXPECT_TRUE(store_has_room(&bench.store, 2, 1e18));  // in memory the budget has said so
  ASSERT_TRUE(bench.open()) << bench.why;
  const uint64_t burst = bench.begin(1);
  ASSERT_TRUE(bench.keep(burst, 0));
  EXPECT_TRUE(store_has_room(&bench.store, 2, kBenchFrameBytes));
  EXPECT_FALSE(store_has_room(&bench.store, 2, 1e18));
}

TEST(Store, AnIdIsNeverGivenTwiceWhateverBecomesOfTheBursts) {
  const TemporaryFolder folder;
  Promises promises;
  for (uint64_t expected = 1; expected <= 3; expected++) {
    StoreBench bench(folder.path());
    ASSERT_TRUE(bench.open());
    EXPECT_EQ(bench.burst(1, &promises), expected);
    bench.acknowledge(expected, 0, &promises);
    EXPECT_FALSE(fs::exists(folder.path() / "burst-000001"));
  }
  std::ofstream(folder.path() / "counter") << "spoilt";
  StoreBench bench(folder.path());
  ASSERT_TRUE(bench.open());
  EXPECT_GT(bench.begin(1), 1000000000u);  // the time since 1970
}

TEST(Store, ASpoiltCounterIsSaidAndTheNextIdIsNoneOfABurstThatStands) {
  const TemporaryFolder folder;
  constexpr uint64_t kLater = 99999999999;  // than the seconds since 1970
  Promises promises;
  {
    StoreBench bench(folder.path());
    ASSERT_TRUE(bench.open());
    bench.store.last_burst_id = kLater - 1;
    ASSERT_EQ(bench.burst(1, &promises), kLater);
  }
  for (const std::string spoilt : {"spoilt", "", "LMR1"}) {
    std::ofstream(folder.path() / "counter") << spoilt;
    testing::internal::CaptureStderr();
    StoreBench bench(folder.path());
    EXPECT_TRUE(bench.open());
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "lamella-rigd: store: 'counter' is spoilt: the next burst is number " +
                  std::to_string(kLater + 1) + ", which no burst here had\n");
    EXPECT_EQ(bench.store.last_burst_id, kLater);
  }
  {
    StoreBench bench(folder.path());
    ASSERT_TRUE(bench.open());
    EXPECT_EQ(bench.burst(1, &promises), kLater + 1);
  }
  testing::internal::CaptureStderr();
  StoreBench bench(folder.path());
  EXPECT_TRUE(bench.open());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "that burst has written it anew";
}

TEST(Store, ABurstWithoutPhotographsIsReleasedAndOneWithThemIsNot) {
  const TemporaryFolder folder;
  Promises promises;
  StoreBench bench(folder.path());
  ASSERT_TRUE(bench.open());
  const uint64_t empty = bench.begin(4);
  EXPECT_TRUE(bench.end("aborted by the operator"));
  EXPECT_STREQ(store_find_burst(&bench.store, empty)->why,
               "aborted by the operator; 0 of 4 photographs are whole");
  const uint64_t full = bench.burst(4, &promises);
  EXPECT_EQ(store_release(&bench.store, empty), LAM_OK);
  EXPECT_EQ(store_release(&bench.store, full), LAM_WRONG_STATE);
  EXPECT_EQ(store_find_burst(&bench.store, empty), nullptr);
  EXPECT_FALSE(fs::exists(folder.path() / "burst-000001.partial"));
}

TEST(Store, ABurstWhoseRestCannotBeReadStaysUntilSomebodyHasHeardOfIt) {
  const TemporaryFolder folder;
  Promises promises;
  {
    StoreBench bench(folder.path());
    ASSERT_TRUE(bench.open());
    bench.acknowledge(bench.burst(3, &promises), 0, &promises);
  }
  for (const char* name : {"frame-01.raw", "frame-02.raw"}) {
    fs::resize_file(folder.path() / "burst-000001" / name, 7);
  }
  StoreBench after(folder.path());
  ASSERT_TRUE(after.open());
  ASSERT_NE(store_find_burst(&after.store, 1), nullptr);
  EXPECT_STREQ(store_find_burst(&after.store, 1)->why,
               "ended well, but its disk lost some: 1 of 3 photographs are whole, 2 damaged");
  EXPECT_TRUE(fs::exists(folder.path() / "burst-000001" / "frame-01.raw"));
  EXPECT_EQ(store_release(&after.store, 1), LAM_OK);
  EXPECT_FALSE(fs::exists(folder.path() / "burst-000001"));
}

TEST(Store, OnlyOneDaemonKeepsItsPhotographsInAFolder) {
  const TemporaryFolder folder;
  StoreBench first(folder.path()), second(folder.path());
  ASSERT_TRUE(first.open());
  EXPECT_FALSE(second.open());
  EXPECT_NE(second.why.find("another daemon"), std::string::npos) << second.why;
  StoreBench nowhere("/nowhere");
  EXPECT_FALSE(nowhere.open());
  EXPECT_NE(nowhere.why.find("no such folder: make one"), std::string::npos) << nowhere.why;
}

TEST(Store, WhatLiesInTheFolderAndIsNotItsOwnIsLeftAlone) {
  const TemporaryFolder folder;
  for (const char* name : {"burst-7", "burst-000007.old", "burst-x", "lost+found"}) {
    fs::create_directory(folder.path() / name);
  }
  StoreBench bench(folder.path());
  ASSERT_TRUE(bench.open());
  EXPECT_EQ(bench.store.burst_count, 0u);
  EXPECT_TRUE(fs::exists(folder.path() / "burst-000007.old"));
}

// `rig sync` names a host's sessions as a store names its bursts.
TEST(Store, AFolderOfSessionsIsRefusedBeforeAnythingInItIsTouched) {
  const std::vector<std::string> named = {"burst-000001", "burst-000001.partial",
                                          "burst-000001.gone"};
  for (const std::string& name : named) {
    const TemporaryFolder folder;
    fs::create_directories(folder.path() / "burst-000002.partial");
    fs::create_directories(folder.path() / "burst-000003.gone");
    fs::create_directories(folder.path() / name / "frames");
    std::ofstream(folder.path() / name / "session.json") << "{}";
    StoreBench bench(folder.path());
    EXPECT_FALSE(bench.open()) << name;
    EXPECT_EQ(bench.why, "--store " + folder.path().string() + ": " + name +
                             " is a host's session, not a burst that a rig keeps: "
                             "give the store a folder of its own");
    EXPECT_TRUE(fs::exists(folder.path() / name / "session.json")) << name;
    EXPECT_TRUE(fs::exists(folder.path() / "burst-000003.gone")) << "it was cleared";
  }
}

TEST(Store, ABurstsFolderThatNoRigBeganIsRefusedByItsName) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "burst-000004" / "photographs");
  StoreBench bench(folder.path());
  EXPECT_FALSE(bench.open());
  EXPECT_NE(bench.why.find(": burst-000004 has nothing that a rig wrote: move it elsewhere, or "
                           "give the store a folder of its own"),
            std::string::npos)
      << bench.why;
  EXPECT_TRUE(fs::exists(folder.path() / "burst-000004" / "photographs"));
}

TEST(Store, ARecoveryThatFailsNamesThePathAndWhatToDo) {
  const TemporaryFolder folder;
  fs::create_directories(folder.path() / "burst-000001.gone" / "notes");
  StoreBench bench(folder.path());
  EXPECT_FALSE(bench.open());
  EXPECT_EQ(bench.why, "--store " + folder.path().string() +
                           ": recovery: burst-000001.gone/notes: Is a directory: lamella-rigd "
                           "made none there: move it elsewhere");
  EXPECT_TRUE(fs::exists(folder.path() / "burst-000001.gone" / "notes"));
}

TEST(Store, PhotographsAreKeptByOneThreadWhileAnotherAsksAndGivesEarlierOnesAway) {
  const TemporaryFolder folder;
  Promises promises;
  StoreBench bench(folder.path());
  ASSERT_TRUE(bench.open());
  const uint64_t first = bench.burst(30, &promises);
  const uint64_t second = bench.begin(40);
  std::thread collector([&] {
    for (uint32_t i = 0; i < 40; i++) EXPECT_TRUE(bench.keep(second, i));
  });
  for (uint32_t i = 0; i < 30; i++) {
    uint8_t bytes[kBenchFrameBytes];
    EXPECT_EQ(store_read(&bench.store, first, i, 0, bytes, sizeof bytes), sizeof bytes);
    bench.acknowledge(first, i, &promises);
    EXPECT_LE(store_held(&bench.store), 40u);
    EXPECT_STREQ(store_fault(&bench.store), "");
  }
  collector.join();
  EXPECT_TRUE(bench.end());
  EXPECT_EQ(store_held(&bench.store), 40u);
  EXPECT_EQ(promises.acked[first].size(), 30u);
}
