// Outputs appear whole or not at all: written beside their place, then renamed into it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace lamella {

namespace fs = std::filesystem;

// Calls `write(temporary)` and renames the result to `path`, or, where that is a link, to the file
// that it leads to, which need not be there yet. On any exception the temporary is
// removed and the exception goes on, as an Error that names `path`. It has the name of `path`, in a
// folder beside it that says as a WholeFolder's does whether it is still being filled.
void write_whole_file(const fs::path& path, const std::function<void(const fs::path&)>& write);

void write_whole_text(const fs::path& path, const std::string& text);

// A folder that appears at `place` when committed; until then its files lie in `path()`, beside it.
// An older folder at `place` is replaced whole, but only where it is empty or holds the file
// `marker`, that is, where it is a thing of the same kind: a mistyped --out costs nobody a folder.
// A link is not followed: what it leads to may be another session's.
class WholeFolder {
 public:
  explicit WholeFolder(fs::path place, const std::string& marker = "");
  ~WholeFolder();  // not committed: everything is removed
  WholeFolder(const WholeFolder&) = delete;
  WholeFolder& operator=(const WholeFolder&) = delete;

  const fs::path& path() const { return temporary_; }
  void commit();

  // At `place`, beside its own, where nothing is; false, and nothing done, where another run has
  // put a folder there.
  bool commit_at(const fs::path& place);

  // A message about files in `path()`, which nobody finds there later: by their names in `place`,
  // or, where nothing comes of that, by those within the folder.
  std::string in_place(const std::string& message) const;
  std::string inside(const std::string& message) const;

  // Calls `fill()`; an Error from it that names `path()` names `place` instead.
  void blame_place(const std::function<void()>& fill) const;

 private:
  void settle();

  fs::path place_;
  fs::path temporary_;
  int lock_ = -1;  // tells other processes, on other computers too, that it is being filled
  bool replaceable_ = false;  // something stood there when it was begun
  bool committed_ = false;
};

// Throws Error where no file can be put at `path`: it has no name, or is a folder, a device or a
// pipe, or a link to one or to what a process has open. For commands that work long before they
// write.
void require_file_place(const fs::path& path);

// Where a file that is named `path` lies: the end of its links.
fs::path file_behind(const fs::path& path);

// Whether both name one file, by whatever links and spellings, be it there or not.
bool is_same_file(const fs::path& a, const fs::path& b);

// Whether `place` is `folder` or lies in it, by whatever links and spellings, be they there or not.
bool lies_in(const fs::path& place, const fs::path& folder);

// Throws Error where no folder can be at `path`: something else is there, or a link to nothing.
void require_folder_place(const fs::path& path);

// Removes every output that is begun and not yet in its place. Whoever writes one waits from then
// on for ever: for a program that is about to end, on ^C, and leaves nothing half-written.
void abandon_outputs();

// Removes from `folder` the outputs that were begun there by processes that were killed; returns
// how many that were. Only what has the name of one, and a lock that nobody holds.
int remove_abandoned(const fs::path& folder);

// Returns when what was written to the disk that holds `path` is really on it.
void sync_to_disk(const fs::path& path);

// The whole text of a file. Throws Error where it cannot be read or is over `max_bytes`.
std::string read_text(const fs::path& path, size_t max_bytes = 64u << 20);

}  // namespace lamella
