#include "apps/burst_fetch.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/progress.h"
#include "io/json_tree.h"

namespace lamella::apps {

namespace {

constexpr const char* kNote = "burst.json";
constexpr const char* kManifest = "session.json";

// What tells this burst from every other, with the reason why it is partial.
std::string note_of(const BurstSource& source, const v1::HeldBurst& held,
                    const std::vector<v1::FrameOffer>& offers) {
  nlohmann::ordered_json frames = nlohmann::ordered_json::array();
  for (const v1::FrameOffer& offer : offers) {
    frames.push_back({{"frame", offer.frame_id()}, {"crc32c", offer.crc32c()}});
  }
  const nlohmann::ordered_json note = {{"burst", held.burst_id()},
                                       {"begun_unix_us", held.begun_unix_us()},
                                       {"whole", held.whole()},
                                       {"why", held.why()},
                                       {"own_calibration", source.gives_own_calibration()},
                                       {"photographs", frames}};
  return json_text(note, 2) + "\n";
}

// An earlier run put the same burst there: every photograph still held is one of its own.
bool holds_burst(const fs::path& folder, const v1::HeldBurst& held,
                 const std::vector<v1::FrameOffer>& offers) {
  if (!fs::exists(folder / kNote) || !fs::exists(folder / kManifest)) return false;
  const auto note = json_tree(read_text(folder / kNote));
  if (!note.is_object() || note.value("burst", uint64_t(0)) != held.burst_id()) return false;
  if (note.value("begun_unix_us", int64_t(-1)) != held.begun_unix_us()) return false;
  const auto frames = note.value("photographs", nlohmann::json::array());
  for (const v1::FrameOffer& offer : offers) {
    const nlohmann::json wanted = {{"frame", offer.frame_id()}, {"crc32c", offer.crc32c()}};
    if (std::find(frames.begin(), frames.end(), wanted) == frames.end()) return false;
  }
  return true;
}

// The session of this burst that a capture put into `out` under a name of its own.
std::optional<fs::path> captured_in(const fs::path& out, const v1::HeldBurst& held,
                                    const std::vector<v1::FrameOffer>& offers) {
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(out, failed)) {
    const bool is_under_way = entry.path().filename().string().starts_with(".");
    try {
      if (!is_under_way && holds_burst(entry.path(), held, offers)) return entry.path();
    } catch (const Error&) {  // somebody else's file of that name
    }
  }
  return {};
}

fs::path place_for(const fs::path& out, const v1::HeldBurst& held,
                   const std::vector<v1::FrameOffer>& offers) {
  const std::string suffix = held.whole() ? "" : ".partial";
  for (int n = 1;; ++n) {
    const std::string other = n == 1 ? "" : fmt::format("-{}", n);
    const fs::path folder = out / fmt::format("burst-{:06}{}{}", held.burst_id(), other, suffix);
    if (!fs::exists(folder)) return captured_in(out, held, offers).value_or(folder);
    if (holds_burst(folder, held, offers)) return folder;
  }
}

void receive_into(WholeFolder* folder, BurstSource* source, const Burst& burst,
                  FetchedBurst* fetched) {
  const std::string title = fmt::format("burst {}", burst.id);
  Progress progress(title.c_str(), int(burst.frame_count));
  const Reception reception =
      receive_session(source, burst, *folder, [&](int n) { progress.advance(n); });
  write_burst_note(folder->path(), *source, fetched->held, reception.offers);
  fetched->offers = reception.offers;
  fetched->marked = burst.marked || !reception.marked.empty();
  fetched->unfit = reception.unfit;
  fetched->warnings = reception.warnings;
}

// Another run may have put the same burst there meanwhile, or another rig's of that number.
void settle(WholeFolder* folder, const fs::path& out, FetchedBurst* fetched) {
  while (!fetched->was_there && !folder->commit_at(fetched->folder)) {
    fetched->folder = place_for(out, fetched->held, fetched->offers);
    fetched->was_there = fs::exists(fetched->folder);
  }
}

void receive_at(const fs::path& out, BurstSource* source, const Burst& burst,
                FetchedBurst* fetched) {
  WholeFolder folder(fetched->folder);
  folder.blame_place([&] { receive_into(&folder, source, burst, fetched); });
  settle(&folder, out, fetched);
}

}  // namespace

void write_burst_note(const fs::path& session, const BurstSource& source, const v1::HeldBurst& held,
                      const std::vector<v1::FrameOffer>& offers) {
  write_whole_text(session / kNote, note_of(source, held, offers));
}

FetchedBurst fetch_burst(BurstSource* source, const v1::HeldBurst& held, const fs::path& out) {
  FetchedBurst fetched;
  fetched.held = held;
  const Burst burst = burst_of(source, held);
  fetched.offers = source->offers(burst);
  if (fetched.offers.empty()) return fetched;
  fetched.folder = place_for(out, held, fetched.offers);
  fetched.was_there = fs::exists(fetched.folder);
  if (!fetched.was_there) receive_at(out, source, burst, &fetched);
  sync_to_disk(fetched.folder);
  return fetched;
}

FetchedBurst try_to_fetch(BurstSource* source, const v1::HeldBurst& held, const fs::path& out) {
  FetchedBurst fetched;
  fetched.held = held;
  try {
    fetched = fetch_burst(source, held, out);
  } catch (const Error& error) {
    if (error.fault() != Fault::kRig) throw;
    source->held();  // throws where it is the source that is gone
    fetched.failed = error.what();
  }
  return fetched;
}

}  // namespace lamella::apps
