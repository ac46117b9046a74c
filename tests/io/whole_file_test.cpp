#include "io/whole_file.h"

#include <sys/stat.h>

#include <fstream>

#include "io/expect_error.h"
#include "io/fake_session.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;
using testing::ScratchFolder;
using Names = std::set<std::string>;

TEST(WholeFile, AppearsOnlyWhenItIsWhole) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "report.txt";
  write_whole_file(file, [&](const fs::path& temporary) {
    std::ofstream(temporary) << "half";
    EXPECT_FALSE(fs::exists(file));
  });
  EXPECT_EQ(read_text(file), "half");
  EXPECT_EQ(scratch.contents(), Names{"report.txt"});
}

TEST(WholeFile, DoesNotTakeThePlaceOfAPipe) {
  const ScratchFolder scratch;
  const fs::path pipe = scratch.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(write_whole_text(pipe, "text"), Error);
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(WholeFile, LikeAWholeFolderMayBeGivenByABareName) {
  const ScratchFolder scratch;
  const fs::path before = fs::current_path();
  fs::current_path(scratch.path());
  write_whole_text("bare.txt", "here");
  WholeFolder whole("bare_folder");
  whole.commit();
  EXPECT_EQ(read_text("bare.txt"), "here");
  EXPECT_TRUE(fs::is_directory("bare_folder"));
  fs::current_path(before);
}

TEST(WholeFile, LeavesTheOldOneWhereTheNewOneFails) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "report.txt";
  write_whole_text(file, "old");
  const std::string line = complaint([&] {
    write_whole_file(file, [](const fs::path& temporary) {
      std::ofstream(temporary) << "new";
      throw std::runtime_error("disk full");
    });
  });
  EXPECT_TRUE(names(line, {"report.txt", "disk full"}));
  EXPECT_EQ(read_text(file), "old");
  EXPECT_EQ(scratch.contents(), Names{"report.txt"});
}

TEST(WholeFile, TakesTheFoldersItMadeAwayAgain) {
  const ScratchFolder scratch;
  const auto fails = [](const fs::path&) { throw std::runtime_error("no"); };
  complaint([&] { write_whole_file(scratch.path() / "a" / "b" / "c.txt", fails); });
  EXPECT_TRUE(scratch.contents().empty());
}

TEST(WholeFolder, AppearsOnlyWhenCommitted) {
  const ScratchFolder scratch;
  {
    WholeFolder folder(scratch.path() / "out");
    write_whole_text(folder.path() / "a.txt", "a");
    EXPECT_FALSE(fs::exists(scratch.path() / "out"));
    folder.commit();
  }
  EXPECT_EQ(scratch.contents(), (Names{"out", "out/a.txt"}));
}

TEST(WholeFolder, LeavesNothingWhereItIsNotCommitted) {
  const ScratchFolder scratch;
  {
    WholeFolder folder(scratch.path() / "deep" / "down" / "out");
    write_whole_text(folder.path() / "a.txt", "a");
  }
  EXPECT_TRUE(scratch.contents().empty());
}

TEST(WholeFolder, ReplacesAnOlderOneOfItsKindWhole) {
  const ScratchFolder scratch;
  for (const char* name : {"old.txt", "new.txt"}) {
    WholeFolder folder(scratch.path() / "out/", "session.json");
    write_whole_text(folder.path() / "session.json", "{}");
    write_whole_text(folder.path() / name, name);
    folder.commit();
  }
  EXPECT_EQ(scratch.contents(), (Names{"out", "out/session.json", "out/new.txt"}));
}

TEST(WholeFolder, KeepsAnOlderOneWhereTheNewOneIsNotCommitted) {
  const ScratchFolder scratch;
  write_whole_text(scratch.path() / "out" / "session.json", "old");
  { WholeFolder folder(scratch.path() / "out", "session.json"); }
  EXPECT_EQ(read_text(scratch.path() / "out" / "session.json"), "old");
  EXPECT_EQ(scratch.contents(), (Names{"out", "out/session.json"}));
}

TEST(WholeFolder, NeverReplacesAFolderOfAnotherKind) {
  const ScratchFolder scratch;
  write_whole_text(scratch.path() / "home" / "letters.txt", "dear");
  const std::string line =
      complaint([&] { WholeFolder folder(scratch.path() / "home", "session.json"); });
  EXPECT_TRUE(names(line, {"home", "session.json", "not replaced"}));
  EXPECT_EQ(scratch.contents(), (Names{"home", "home/letters.txt"}));
}

TEST(ReadText, SaysWhichFileCannotBeRead) {
  const ScratchFolder scratch;
  EXPECT_TRUE(names(complaint([&] { read_text(scratch.path() / "gone.json"); }), {"gone.json"}));
  EXPECT_TRUE(names(complaint([&] { read_text(scratch.path()); }), {scratch.path().string()}));
  write_whole_text(scratch.path() / "long.txt", std::string(100, 'x'));
  EXPECT_TRUE(names(complaint([&] { read_text(scratch.path() / "long.txt", 99); }), {"long.txt"}));
}

TEST(FilePlace, IsNoFolderAndHasAName) {
  const ScratchFolder scratch;
  EXPECT_THROW(require_file_place(scratch.path()), Error);
  EXPECT_THROW(require_file_place(""), Error);
  EXPECT_NO_THROW(require_file_place(scratch.path() / "new" / "file.exr"));
}

}  // namespace
}  // namespace lamella
