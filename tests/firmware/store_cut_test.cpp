// What is left when the daemon is killed, or the power goes, at any step of what it does to the
// disk. Killed: a process ends at its N-th step. Power: the steps are recorded and a disk is made
// of them that has only what was synced, and of the rest some, torn and in another order.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <random>

#include "store_bench.h"

namespace fs = std::filesystem;

namespace {

// Two bursts, the first given to a host; the third ends in a fault. A step of a working day each.
void work(StoreBench* bench, uint32_t frames, Promises* promises) {
  const uint64_t first = bench->burst(frames, promises);
  bench->burst(frames, promises);
  for (uint32_t i = 0; i < frames && first != 0; i++) bench->acknowledge(first, i, promises);
  const uint64_t third = bench->begin(frames);
  if (third == 0) return;
  promises->begun.insert(third);
  for (uint32_t i = 0; i + 1 < frames; i++) bench->keep(third, i);
  while (!store_is_written(&bench->store, 1000)) continue;
  for (uint32_t i = 0; i < store_held(&bench->store); i++) promises->kept[third].insert(i);
  bench->end("a camera missed a trigger");
}

struct Step {
  disk_action action;
  std::string path, to;
  std::vector<uint8_t> bytes;
};

// Steps in the order in which they were asked for, and what had been promised before each.
struct Recording {
  std::vector<Step> steps;
  std::vector<Promises> before;
  const Promises* now = nullptr;
};

int record(void* context, const disk_step* step) {
  auto* recording = static_cast<Recording*>(context);
  recording->steps.push_back({step->action, step->path, step->to != nullptr ? step->to : "", {}});
  if (step->size > 0) {
    recording->steps.back().bytes.assign(step->bytes, step->bytes + step->size);
  }
  recording->before.push_back(*recording->now);
  return 0;
}

// A disk as a power cut sees it: what is sure, and what is only on its way.
class CutDisk {
 public:
  void play(const Step& step) {
    switch (step.action) {
      case DISK_MAKE_FOLDER:
        return enter(step.path, make_file(true));
      case DISK_CREATE:
        return enter(step.path, make_file(false));
      case DISK_WRITE: {
        auto& now = files_[names_.at(step.path)].now;
        now.insert(now.end(), step.bytes.begin(), step.bytes.end());
        return;
      }
      case DISK_SYNC_FILE: {
        File& file = files_[names_.at(step.path)];
        file.sure = file.now;
        return;
      }
      case DISK_RENAME:
        return move(step.path, step.to);
      case DISK_SYNC_FOLDER:
        return sync(step.path);
      default:
        pending_.push_back({folder_of(step.path), step.path, "", 0});
        names_.erase(step.path);
    }
  }

  // Writes what is left into `place`.
  void cut(std::mt19937* seeded, const fs::path& place) const {
    std::map<std::string, int> left = sure_;
    const bool in_order = (*seeded)() % 2 == 0;  // a journal's promise; else any may be lost
    const size_t kept = pending_.empty() ? 0 : (*seeded)() % (pending_.size() + 1);
    for (size_t i = 0; i < pending_.size(); i++) {
      if (in_order ? i < kept : (*seeded)() % 2 == 0) apply(pending_[i], &left);
    }
    for (const auto& [path, file] : left) {
      if (files_[file].is_folder) fs::create_directories(place / path);
    }
    for (const auto& [path, file] : left) {
      // A file whose folder's name was lost is lost with it.
      if (files_[file].is_folder || !fs::exists((place / path).parent_path())) continue;
      write(place / path, torn(files_[file], seeded));
    }
  }

 private:
  struct File {
    bool is_folder = false;
    std::vector<uint8_t> sure, now;
  };
  // A change of names that no sync of its folder has made sure.
  struct Change {
    std::string folder, from, to;
    int file = 0;
  };

  static std::string folder_of(const std::string& path) {
    const size_t slash = path.rfind('/');
    return slash == std::string::npos ? "." : path.substr(0, slash);
  }

  int make_file(bool is_folder) {
    files_.push_back({is_folder, {}, {}});
    return static_cast<int>(files_.size()) - 1;
  }

  void enter(const std::string& path, int file) {
    names_[path] = file;
    pending_.push_back({folder_of(path), "", path, file});
  }

  void move(const std::string& from, const std::string& to) {
    const int file = names_.at(from);
    pending_.push_back({folder_of(from), from, to, file});
    rename_in(from, to, &names_);
    // Names below a folder that moves are of the folder itself, wherever it is called.
    for (Change& change : pending_) {
      if (change.folder == from) change.folder = to;
    }
  }

  // A folder takes what lies in it along.
  static void rename_in(const std::string& from, const std::string& to,
                        std::map<std::string, int>* names) {
    std::map<std::string, int> moved;
    for (auto it = names->begin(); it != names->end();) {
      const bool is_it = it->first == from || it->first.rfind(from + "/", 0) == 0;
      if (is_it) moved[to + it->first.substr(from.size())] = it->second;
      it = is_it ? names->erase(it) : std::next(it);
    }
    for (const auto& [path, file] : moved) (*names)[path] = file;
  }

  static void apply(const Change& change, std::map<std::string, int>* names) {
    if (change.to.empty()) {
      names->erase(change.from);
    } else if (!change.from.empty() && names->count(change.from)) {
      rename_in(change.from, change.to, names);
    } else if (change.from.empty() || change.from.find('/') != std::string::npos) {
      (*names)[change.to] = change.file;
    }
  }

  void sync(const std::string& folder) {
    std::vector<Change> rest;
    for (const Change& change : pending_) {
      if (change.folder == folder) {
        apply(change, &sure_);
      } else {
        rest.push_back(change);
      }
    }
    pending_ = rest;
  }

  static std::vector<uint8_t> torn(const File& file, std::mt19937* seeded) {
    if (file.sure == file.now) return file.now;
    std::vector<uint8_t> bytes = file.now;
    switch ((*seeded)() % 4) {
      case 0:
        return file.sure;
      case 1:  // a part
        bytes.resize((*seeded)() % (bytes.size() + 1));
        return bytes;
      case 2:  // its size, but not all of its blocks
        std::fill(bytes.begin() + static_cast<long>((*seeded)() % (bytes.size() + 1)), bytes.end(),
                  uint8_t(0));
        return bytes;
      default:
        return bytes;
    }
  }

  static void write(const fs::path& path, const std::vector<uint8_t>& bytes) {
    std::ofstream out(path, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
  }

  std::vector<File> files_;
  std::map<std::string, int> names_, sure_;  // as seen while there is power, and as synced
  std::vector<Change> pending_;
};

const char* const kActions[DISK_ACTIONS] = {"mkdir",  "create",      "write",  "fsync",
                                            "rename", "sync folder", "unlink", "rmdir"};

std::string described(const Step& step, size_t number, uint32_t seed) {
  return "cut before step " + std::to_string(number) + " (" + kActions[step.action] + " " +
         step.path + "), seed " + std::to_string(seed);
}

Recording recorded(uint32_t frames) {
  const TemporaryFolder folder;
  Promises promises;
  Recording recording;
  recording.now = &promises;
  StoreBench bench(folder.path());
  bench.store.disk.before = record;
  bench.store.disk.context = &recording;
  EXPECT_TRUE(bench.open()) << bench.why;
  work(&bench, frames, &promises);
  return recording;
}

int die_at_zero(void* context, const disk_step*) {
  if (--*static_cast<long*>(context) < 0) raise(SIGKILL);
  return 0;
}

}  // namespace

// Every step, and at each several ways in which the rest may have reached the disk.
TEST(StoreCut, APowerCutAtAnyStepLosesNothingThatWasPromised) {
  const Recording recording = recorded(4);
  std::set<disk_action> seen;
  CutDisk disk;
  for (size_t n = 0; n < recording.steps.size() && !::testing::Test::HasFailure(); n++) {
    for (uint32_t seed = 0; seed < 6; seed++) {
      std::mt19937 seeded(static_cast<uint32_t>(n) * 31 + seed);
      const TemporaryFolder place;
      disk.cut(&seeded, place.path());
      expect_promises_kept(place.path(), recording.before[n],
                           described(recording.steps[n], n, seed));
    }
    seen.insert(recording.steps[n].action);
    disk.play(recording.steps[n]);
  }
  EXPECT_EQ(seen.size(), size_t(DISK_ACTIONS));
  EXPECT_GT(recording.steps.size(), 100u);
}

// Fifty seeded points of a full burst, and the power goes again while what it left is recovered.
TEST(StoreCut, APowerCutDuringRecoveryLosesNothingEither) {
  const Recording recording = recorded(40);
  for (uint32_t seed = 0; seed < 50 && !::testing::Test::HasFailure(); seed++) {
    std::mt19937 seeded(seed);
    const size_t n = seeded() % recording.steps.size();
    CutDisk disk;
    for (size_t i = 0; i < n; i++) disk.play(recording.steps[i]);
    const TemporaryFolder place;
    disk.cut(&seeded, place.path());
    const long dies_after = seeded() % 4;
    const pid_t child = fork();
    if (child == 0) {
      long countdown = dies_after;
      StoreBench again(place.path());
      again.store.disk.before = die_at_zero;
      again.store.disk.context = &countdown;
      again.open();
      _exit(0);
    }
    waitpid(child, nullptr, 0);
    expect_promises_kept(place.path(), recording.before[n], described(recording.steps[n], n, seed));
  }
}

// A disk that forgets what was synced is found out: the model and the judge can fail.
TEST(StoreCut, TheJudgeFindsALostPhotograph) {
  const TemporaryFolder folder;
  Promises promises;
  {
    StoreBench bench(folder.path());
    ASSERT_TRUE(bench.open());
    bench.burst(4, &promises);
  }
  fs::resize_file(folder.path() / "burst-000001" / "frame-02.raw", 100);
  StoreBench after(folder.path());
  ASSERT_TRUE(after.open());
  EXPECT_EQ(after.store.bursts[0].frames[2], FRAME_NONE);
  EXPECT_FALSE(after.store.bursts[0].whole);
  EXPECT_STREQ(after.store.bursts[0].why,
               "ended well, but its disk lost some: 3 of 4 photographs are whole, 1 damaged");
}

// Without the sync of a folder the model does lose photographs: it is no kinder than a disk.
TEST(StoreCut, TheModelLosesWhatIsNotSynced) {
  Recording recording = recorded(4);
  int lost = 0;
  for (uint32_t seed = 0; seed < 40; seed++) {
    std::mt19937 seeded(seed);
    CutDisk disk;
    const size_t n = recording.steps.size() / 3;
    for (size_t i = 0; i < n; i++) {
      if (recording.steps[i].action != DISK_SYNC_FOLDER) disk.play(recording.steps[i]);
    }
    const TemporaryFolder place;
    disk.cut(&seeded, place.path());
    StoreBench after(place.path());
    ASSERT_TRUE(after.open());
    lost += after.store.burst_count == 0 || after.store.bursts[0].held < 4;
  }
  EXPECT_GT(lost, 20);
}

// The process really dies: SIGKILL before each of its steps.
TEST(StoreCut, AKilledDaemonLeavesWholeBurstsOrPlainlyPartialOnes) {
  const Recording recording = recorded(3);
  const size_t total = recording.steps.size();
  for (size_t n = 0; n <= total && !::testing::Test::HasFailure(); n++) {
    const TemporaryFolder folder;
    const pid_t child = fork();
    if (child == 0) {
      Promises promises;
      long countdown = static_cast<long>(n);
      StoreBench bench(folder.path());
      bench.store.disk.before = die_at_zero;
      bench.store.disk.context = &countdown;
      if (bench.open()) work(&bench, 3, &promises);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_EQ(WIFSIGNALED(status), n < total) << n;
    expect_promises_kept(folder.path(), recording.before[std::min(n, total - 1)],
                         "killed at step " + std::to_string(n));
  }
}
