#include "io/whole_file.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
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

TEST(WholeFile, IsWrittenWhereALinkLeadsAndTheLinkStays) {
  const ScratchFolder scratch;
  fs::create_directory(scratch.path() / "disk");
  write_whole_text(scratch.path() / "disk" / "old.txt", "old");
  fs::create_symlink("disk/old.txt", scratch.path() / "there.txt");
  fs::create_symlink("there.txt", scratch.path() / "twice.txt");
  fs::create_symlink(scratch.path() / "disk" / "new.txt", scratch.path() / "not_yet.txt");
  for (const char* name : {"twice.txt", "not_yet.txt"}) {
    write_whole_text(scratch.path() / name, "text");
    EXPECT_TRUE(fs::is_symlink(scratch.path() / name)) << name;
    EXPECT_EQ(read_text(scratch.path() / name), "text");
  }
  EXPECT_TRUE(fs::is_symlink(scratch.path() / "there.txt"));
  EXPECT_EQ(scratch.contents(), (Names{"disk", "disk/new.txt", "disk/old.txt", "not_yet.txt",
                                       "there.txt", "twice.txt"}));
}

TEST(WholeFile, DoesNotTakeThePlaceOfALinkToWhatIsNoFile) {
  const ScratchFolder scratch;
  const fs::path pipe = scratch.path() / "pipe", link = scratch.path() / "link";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::ofstream opened(scratch.path() / "opened");
  const int fd = ::open((scratch.path() / "opened").c_str(), O_WRONLY);
  const std::string number = std::to_string(fd);
  for (const fs::path& leads_to : {pipe, fs::path("/dev/null"), fs::path("/proc/self/fd/" + number),
                                   fs::path("/dev/fd/" + number)}) {
    fs::remove(link);
    fs::create_symlink(leads_to, link);
    EXPECT_TRUE(names(complaint([&] { write_whole_text(link, "text"); }),
                      {link.string() + ": is no file"}));
    EXPECT_EQ(fs::read_symlink(link), leads_to);
  }
  ::close(fd);
  EXPECT_EQ(read_text(scratch.path() / "opened"), "");
}

TEST(WholeFile, OfADiskThatIsFullSaysThatItIsFull) {
  const ScratchFolder scratch;
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{4096, before.rlim_max};
  for (const size_t bytes : {5000, 1 << 20}) {  // fails as it is closed, or as it is written
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string line =
        complaint([&] { write_whole_text(scratch.path() / "y.svg", std::string(bytes, 'x')); });
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_TRUE(names(line, {"y.svg: cannot be written (File too large)"}));
  }
  std::signal(SIGXFSZ, SIG_DFL);
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

TEST(WholeFile, OfWhatCannotBeWrittenTellsTheNameThatWasGivenAndNoOther) {
  const fs::path read_only = "/proc/lamella";  // for root too
  for (const std::function<void()>& write : std::vector<std::function<void()>>{
           [&] { write_whole_text(read_only, "text"); },
           [&] {
             write_whole_file(read_only, [](const fs::path& temporary) {
               throw_bad_input(temporary.string(), "cannot be opened");
             });
           },
           [&] {
             write_whole_file(read_only, [](const fs::path& temporary) {
               throw std::runtime_error("cannot open " + temporary.string());
             });
           },
           [&] { const WholeFolder folder(read_only); }}) {
    const std::string line = complaint(write);
    EXPECT_TRUE(names(line, {read_only.string(), "cannot"}));
    EXPECT_EQ(line.find(".part"), std::string::npos) << line;
    EXPECT_EQ(line.find("filesystem error"), std::string::npos) << line;
    EXPECT_EQ(line.find("iostream"), std::string::npos) << line;
  }
}

TEST(WholeFolder, IsNotPutInThePlaceOfALinkNorOfTheFolderThatItLeadsTo) {
  const ScratchFolder scratch;
  const fs::path link = scratch.path() / "fit", other = scratch.path() / "other";
  fs::create_directories(other);
  fs::create_directory_symlink(other, link);
  for (const bool is_fit : {false, true}) {
    if (is_fit) write_whole_text(other / "layers.json", "{}");
    const Names before = scratch.contents();
    EXPECT_TRUE(names(complaint([&] { const WholeFolder folder(link / "", "layers.json"); }),
                      {link.string() + ": is a link to " + other.string(), "remove the link"}));
    EXPECT_EQ(scratch.contents(), before);
  }
}

TEST(WholeFolder, IsNotPutInThePlaceOfALinkThatLeadsNowhere) {
  const ScratchFolder scratch;
  const fs::path link = scratch.path() / "burst-000042", gone = scratch.path() / "gone";
  fs::create_directory_symlink(gone, link);
  EXPECT_TRUE(names(complaint([&] { const WholeFolder folder(link); }),
                    {link.string(), "is a link to " + gone.string(), "not there", "remove"}));
  EXPECT_TRUE(fs::is_symlink(link));
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

// A process that is killed in the middle of filling `place`.
void be_killed_while_filling(const fs::path& place) {
  const pid_t child = fork();
  if (child == 0) {
    const WholeFolder folder(place);
    std::ofstream(folder.path() / "half.exr") << "half";
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
}

TEST(RemoveAbandoned, TakesAwayWhatAKilledProcessLeft) {
  const ScratchFolder scratch;
  be_killed_while_filling(scratch.path() / "burst-000007");
  be_killed_while_filling(scratch.path() / "burst-000008.partial");
  EXPECT_EQ(scratch.contents().size(), 6u);  // each: a folder, its lock, a file
  EXPECT_EQ(remove_abandoned(scratch.path()), 2);
  EXPECT_TRUE(scratch.contents().empty());
}

TEST(RemoveAbandoned, TakesAwayTheFileThatAKilledProcessWrote) {
  const ScratchFolder scratch;
  write_whole_text(scratch.path() / "face.exr", "old");
  const pid_t child = fork();
  if (child == 0) {
    write_whole_file(scratch.path() / "face.exr", [](const fs::path& temporary) {
      std::ofstream(temporary) << "half";
      kill(getpid(), SIGKILL);
    });
  }
  waitpid(child, nullptr, 0);
  EXPECT_GT(scratch.contents().size(), 1u);
  EXPECT_EQ(remove_abandoned(scratch.path()), 1);
  EXPECT_EQ(scratch.contents(), Names{"face.exr"});
  EXPECT_EQ(read_text(scratch.path() / "face.exr"), "old");
}

TEST(RemoveAbandoned, LeavesAFileThatIsStillBeingWritten) {
  const ScratchFolder scratch;
  write_whole_file(scratch.path() / "face.exr", [&](const fs::path& temporary) {
    std::ofstream(temporary) << "whole";
    EXPECT_EQ(remove_abandoned(scratch.path()), 0);
  });
  EXPECT_EQ(read_text(scratch.path() / "face.exr"), "whole");
}

TEST(RemoveAbandoned, LeavesWhatAProcessStillFillsAndWhatIsNotOurs) {
  const ScratchFolder scratch;
  const WholeFolder under_way(scratch.path() / "burst-000009");
  const pid_t gone = fork();
  if (gone == 0) _exit(0);
  waitpid(gone, nullptr, 0);
  const std::string end = ".part-" + std::to_string(gone) + "-0";
  fs::create_directories(scratch.path() / (".thesis" + end) / "chapter");
  fs::create_directories(scratch.path() / (".mine" + end + ".bak"));
  fs::create_directories(scratch.path() / ("mine" + end));
  fs::create_directories(scratch.path() / ".fetching");
  write_whole_text(scratch.path() / (".a file" + end), "text");
  fs::create_directory_symlink(scratch.path() / ".fetching", scratch.path() / (".link" + end));
  // All that is left of a session whose replacement was cut short.
  fs::create_directories(scratch.path() / (".session.old-" + std::to_string(gone) + "-1"));
  const Names before = scratch.contents();
  EXPECT_EQ(remove_abandoned(scratch.path()), 0);
  EXPECT_EQ(scratch.contents(), before);
}

TEST(WholeFolder, ReplacesNothingThatWasNotThereWhenItWasBegun) {
  const ScratchFolder scratch;
  const fs::path place = scratch.path() / "session";
  WholeFolder folder(place, "session.json");
  write_whole_text(place / "session.json", "of another run");
  EXPECT_TRUE(names(complaint([&] { folder.commit(); }), {place.string(), "meanwhile"}));
  EXPECT_EQ(read_text(place / "session.json"), "of another run");
}

TEST(WholeFolder, IsCommittedAtAnotherPlaceWhereItsOwnWasTakenMeanwhile) {
  const ScratchFolder scratch;
  const fs::path place = scratch.path() / "burst-000001";
  {
    WholeFolder folder(place);
    write_whole_text(folder.path() / "a.txt", "ours");
    write_whole_text(place / "a.txt", "of another run");
    EXPECT_FALSE(folder.commit_at(place));
    EXPECT_TRUE(folder.commit_at(scratch.path() / "burst-000001-2"));
  }
  EXPECT_EQ(scratch.contents(), (Names{"burst-000001", "burst-000001/a.txt", "burst-000001-2",
                                       "burst-000001-2/a.txt"}));
  EXPECT_EQ(read_text(place / "a.txt"), "of another run");
}

TEST(RemoveAbandoned, GoesByTheLockAndNotByTheNumberOfAProcess) {
  const ScratchFolder scratch;
  const pid_t gone = fork();
  if (gone == 0) _exit(0);
  waitpid(gone, nullptr, 0);
  for (const pid_t pid : {gone, getppid(), getpid()}) {  // ended, another's, our own
    const fs::path folder = scratch.path() / (".session.part-" + std::to_string(pid) + "-0");
    {
      const WholeFolder elsewhere(scratch.path() / "session");  // of another container, say
      fs::rename(elsewhere.path(), folder);
      EXPECT_EQ(remove_abandoned(scratch.path()), 0) << pid;
    }
    EXPECT_EQ(remove_abandoned(scratch.path()), 1) << pid;
  }
  EXPECT_EQ(remove_abandoned(scratch.path() / "none"), 0);
}

TEST(RemoveAbandoned, TakesAwayWhatAKilledProcessLeftThatNobodyHasWaitedFor) {
  const ScratchFolder scratch;
  const pid_t child = fork();
  if (child == 0) {
    const WholeFolder folder(scratch.path() / "burst-000007");
    kill(getpid(), SIGKILL);
  }
  siginfo_t how;
  ASSERT_EQ(waitid(P_PID, id_t(child), &how, WEXITED | WNOWAIT), 0);  // a zombie from here on
  EXPECT_EQ(remove_abandoned(scratch.path()), 1);
  waitpid(child, nullptr, 0);
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
