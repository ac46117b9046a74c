// Folders that are a rig's own store, and the commands that put sessions into folders.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "apps/run_lamella.h"
#include "io/fake_rig.h"
#include "io/fake_session.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;
using testing::FakeRig;
using testing::Outcome;
using testing::run_lamella;

class RigStores : public ::testing::Test {
 protected:
  testing::ScratchFolder scratch;
};

// A rig's counter of bursts, the first of them taken.
void make_store(const fs::path& folder) {
  fs::create_directory(folder);
  const std::string record("LMR1\x02\0\0\0\x08\x01\x72\x89\xdb\x89", 14);
  std::ofstream(folder / "counter", std::ios::binary) << record;
}

// A daemon does not start on a store in which a host's session lies.
TEST_F(RigStores, NoSessionIsPutIntoARigsOwnStore) {
  FakeRig rig;
  load_burst(&rig, testing::kFakeSize);
  rig.hold(testing::whole_burst());
  const fs::path store = scratch.path() / "store";
  make_store(store);
  fs::create_directory_symlink("store", scratch.path() / "link");
  const std::set<std::string> before = scratch.contents();
  for (const fs::path& place : {store, store / "sub", scratch.path() / "link"}) {
    const std::string to = place.string();
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"rig", "sync", "--rig", rig.address(), "--out", to},
          {"rig", "recover", "--rig", rig.address(), "--out", to},
          {"capture", "--rig", rig.address(), "--out", to + "/mine"}}) {
      const Outcome outcome = run_lamella(command);
      EXPECT_EQ(outcome.exit_code, 2) << command[1];
      EXPECT_NE(outcome.err.find("is in a rig's own store"), std::string::npos) << outcome.err;
    }
  }
  EXPECT_EQ(scratch.contents(), before);
  EXPECT_TRUE(rig.holds_burst());
}

TEST_F(RigStores, AStoreIsNotRecoveredIntoItselfThoughItsCounterIsLost) {
  const fs::path store = scratch.path() / "store";
  fs::create_directories(store / "burst-000001.partial");
  std::ofstream(store / "burst-000001.partial" / "burst.pb") << "spoilt";
  const std::set<std::string> before = scratch.contents();
  for (const fs::path& place : {store, store / "sessions", store / ""}) {
    const Outcome outcome =
        run_lamella({"rig", "recover", "--store", store.string(), "--out", place.string()});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(scratch.contents(), before) << outcome.err;
  }
}

}  // namespace
}  // namespace lamella
