// What the firmware wrote, read by the host: two implementations that check each other.
#include "io/store_folder.h"

#include <gtest/gtest.h>

#include <fstream>

#include "io/crc32c.h"
#include "io/expect_error.h"
#include "io/fake_session.h"
#include "io/stored_by_firmware.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using testing::ScratchFolder;

constexpr size_t kBytes = 500;

Burst numbered(uint64_t id) {
  Burst burst;
  burst.id = id;
  return burst;
}

TEST(StoreFolder, ReadsAWholeBurstThatTheFirmwareWrote) {
  const ScratchFolder disk;
  const uint64_t id = stored_by_firmware(disk.path().c_str(), 40, kBytes, nullptr, 0);
  StoreFolder folder(disk.path());
  const auto held = folder.held();
  ASSERT_EQ(held.size(), 1u);
  EXPECT_EQ(held[0].burst_id(), id);
  EXPECT_TRUE(held[0].whole()) << held[0].why();
  EXPECT_EQ(held[0].frames_held(), 40u);
  EXPECT_EQ(held[0].bytes_held(), 40 * kBytes);
  EXPECT_GT(held[0].begun_unix_us(), 0);
  EXPECT_TRUE(held[0].flashing_confirmed());
  EXPECT_EQ(held[0].subject(), "Ada");
  const auto offers = folder.offers(numbered(id));
  ASSERT_EQ(offers.size(), 40u);
  EXPECT_EQ(folder.photograph(offers[7]), std::vector<uint8_t>(kBytes, 7));
  EXPECT_EQ(folder.calibration(numbered(id)), "{}");
  const v1::TimingEdges timing = folder.timing(numbered(id));
  ASSERT_EQ(timing.edges_size(), 100);
  EXPECT_EQ(timing.edges(99).planned_us(), 99);
  EXPECT_EQ(timing.zero_us(), 5);
  EXPECT_EQ(timing.latency().lead_us(), 1.5);
}

// `rig sync` names them as a store names its bursts.
TEST(StoreFolder, AFolderOfSessionsIsNotTakenForARigs) {
  const ScratchFolder sessions;
  fs::create_directories(sessions.path() / "burst-000001" / "frames");
  std::ofstream(sessions.path() / "burst-000001" / "session.json") << "{}";
  const std::string says = testing::complaint([&] { StoreFolder folder(sessions.path()); });
  EXPECT_TRUE(testing::names(says, {"burst-000001: is a session, not a burst that a rig keeps",
                                    "give the folder that lamella-rigd stores in"}));
}

TEST(StoreFolder, ExplainsABurstThatEndedInAFault) {
  const ScratchFolder disk;
  stored_by_firmware(disk.path().c_str(), 5, kBytes, "a camera missed a trigger", 2);
  StoreFolder folder(disk.path());
  const v1::HeldBurst burst = folder.held().at(0);
  EXPECT_FALSE(burst.whole());
  EXPECT_EQ(burst.why(), "a camera missed a trigger; 5 of 5 photographs are whole");
  EXPECT_EQ(burst.frames_held(), 3u);
  EXPECT_EQ(burst.frames_acknowledged(), 2u);
  EXPECT_FALSE(burst.flashing_confirmed());
  EXPECT_EQ(burst.subject(), "");
  const Burst fetched = burst_of(&folder, burst);
  EXPECT_EQ(fetched.shortfall, burst.why());
  EXPECT_EQ(fetched.frame_count, 3u);
}

// Each file cut short, spoilt or taken away: both say partial, or both say whole.
TEST(StoreFolder, AgreesWithTheFirmwareAboutEverythingThatCanBeMissing) {
  int partial = 0;
  for (const char* file : {"begin", "calibration.json", "timing", "end", "frame-02.raw",
                           "frame-02.record", "frame-04.raw"}) {
    for (const int spoil : {0, 1, 2}) {
      const ScratchFolder disk;
      const uint64_t id = stored_by_firmware(disk.path().c_str(), 5, kBytes, nullptr, 0);
      const fs::path named = disk.path() / "burst-000001", path = named / file;
      if (spoil == 0) fs::remove(path);
      if (spoil == 1) fs::resize_file(path, fs::file_size(path) / 2);
      if (spoil == 2) std::ofstream(path, std::ios::app) << "x";
      fs::rename(named, disk.path() / "burst-000001.partial");
      const v1::HeldBurst host = StoreFolder(disk.path()).held().at(0);
      char why[160] = "";
      const bool whole = explained_by_firmware(disk.path().c_str(), id, why) != 0;
      EXPECT_EQ(host.whole(), whole) << file << " " << spoil << ": " << host.why() << " / " << why;
      partial += !whole;
    }
  }
  EXPECT_GT(partial, 8);
}

TEST(StoreFolder, SaysAsTheFirmwareDoesThatTheRecordOfABurstsBeginningIsLost) {
  const ScratchFolder disk;
  const uint64_t id = stored_by_firmware(disk.path().c_str(), 5, kBytes, nullptr, 0);
  const fs::path partial = disk.path() / "burst-000001.partial";
  fs::rename(disk.path() / "burst-000001", partial);
  fs::remove(partial / "begin");
  fs::remove(partial / "end");
  const v1::HeldBurst host = StoreFolder(disk.path()).held().at(0);
  char why[160] = "";
  EXPECT_EQ(explained_by_firmware(disk.path().c_str(), id, why), 0);
  for (const std::string& said : {host.why(), std::string(why)}) {
    EXPECT_EQ(said.find("its first record is lost"), 0u) << said;
    EXPECT_NE(said.find("5 are whole"), std::string::npos) << said;
  }
}

TEST(StoreFolder, FindsADamagedPhotographInABurstThatIsNamedWhole) {
  const ScratchFolder disk;
  stored_by_firmware(disk.path().c_str(), 5, kBytes, nullptr, 0);
  std::fstream raw(disk.path() / "burst-000001" / "frame-03.raw", std::ios::in | std::ios::out);
  raw.seekp(100) << 'x';
  raw.close();
  StoreFolder folder(disk.path());
  EXPECT_EQ(folder.held().at(0).why(),
            "the burst ended well, but its disk lost some of it since; 4 of 5 photographs are "
            "whole, 1 damaged");
  EXPECT_EQ(folder.offers(numbered(1)).size(), 4u);
}

TEST(StoreFolder, RefusesAFolderThatNoRigWrote) {
  const ScratchFolder disk;
  EXPECT_NE(testing::complaint([&] { StoreFolder folder(disk.path()); }).find("holds no bursts"),
            std::string::npos);
  EXPECT_NE(testing::complaint([&] { StoreFolder folder(disk.path() / "x"); }).find("is no folder"),
            std::string::npos);
}

TEST(StoreFolder, TakesNoRecordThatIsTornOrTooLong) {
  v1::BurstCounter counter;
  for (const std::string& bytes :
       {std::string(), std::string("LMR1"), std::string("LMR1\xff\xff\xff\xff 1234567890"),
        std::string("LMR1\0\0\0\0\0\0\0\0", 12), std::string(200, 'x')}) {
    std::string left = bytes;
    EXPECT_FALSE(take_record(&left, &counter)) << bytes;
    EXPECT_EQ(left, bytes);
  }
}

}  // namespace
}  // namespace lamella
