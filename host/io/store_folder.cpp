#include "io/store_folder.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>

#include "base/error.h"
#include "io/crc32c.h"

namespace lamella {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMaxPhotographBytes = 256u << 20;
constexpr size_t kMaxRecordsBytes = 1u << 20;
constexpr uint32_t kMaxFrameId = 255;
constexpr const char* kPartial = ".partial";

uint32_t little_endian(const char* at) {
  uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | uint8_t(at[i]);
  return value;
}

// Nothing where there is no such plain file, or it is too large.
std::optional<std::string> read_file(const fs::path& path, size_t max_bytes) {
  std::error_code failed;
  if (!fs::is_regular_file(fs::symlink_status(path, failed))) return {};
  const auto size = fs::file_size(path, failed);
  if (failed || size > max_bytes) return {};
  std::ifstream in(path, std::ios::binary);
  if (!in) return {};
  return std::string(std::istreambuf_iterator<char>(in), {});
}

bool read_record(const fs::path& path, google::protobuf::MessageLite* message) {
  std::optional<std::string> bytes = read_file(path, kMaxRecordsBytes);
  return bytes && take_record(&*bytes, message);
}

std::string frame_name(uint32_t id) {
  return "frame-" + std::string(id < 10 ? "0" : "") + std::to_string(id);
}

// "burst-000012" or "burst-000012.partial"; 0 where it is neither.
uint64_t id_of(std::string name) {
  if (name.ends_with(kPartial)) name.resize(name.size() - std::strlen(kPartial));
  if (!name.starts_with("burst-") || name.size() < 12) return 0;
  uint64_t id = 0;
  const char* end = name.data() + name.size();
  const auto [at, failed] = std::from_chars(name.data() + 6, end, id);
  return failed == std::errc() && at == end ? id : 0;
}

bool is_sound(const fs::path& raw, const v1::FrameOffer& offer) {
  const std::optional<std::string> bytes = read_file(raw, kMaxPhotographBytes);
  return bytes && bytes->size() == offer.size_bytes() &&
         crc32c(bytes->data(), bytes->size()) == offer.crc32c();
}

std::string count(size_t n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

// What a person wants to know of a burst that is not whole.
std::string explanation(const v1::HeldBurst& burst, const v1::BurstEnd* end, size_t damaged) {
  const uint32_t whole = burst.frames_held() + burst.frames_acknowledged();
  std::string text;
  if (end && !end->why().empty()) {
    text = end->why();
  } else if (end) {
    text = "the burst ended well, but its disk lost some of it since";
  } else if (burst.frames_expected() > 0) {
    text = "power or the daemon was cut before the burst's end was on disk";
  } else if (whole + damaged > 0) {
    text = "its first record is lost, so that nobody knows how many photographs it had";
  } else {
    return "power or the daemon was cut as the burst began: nothing was photographed";
  }
  text +=
      "; " + std::to_string(whole) +
      (burst.frames_expected() > 0 ? " of " + count(burst.frames_expected(), "photograph") : "") +
      (whole == 1 ? " is whole" : " are whole");
  if (damaged > 0) text += ", " + std::to_string(damaged) + " damaged";
  return text;
}

}  // namespace

bool take_record(std::string* bytes, google::protobuf::MessageLite* message) {
  constexpr size_t kHead = 8, kCrc = 4;
  if (bytes->size() < kHead + kCrc || bytes->compare(0, 4, "LMR1") != 0) return false;
  const size_t length = little_endian(bytes->data() + 4);
  if (length > bytes->size() - kHead - kCrc || length > kMaxRecordsBytes) return false;
  const size_t checked = kHead + length;
  if (little_endian(bytes->data() + checked) != crc32c(bytes->data(), checked)) return false;
  if (!message->ParseFromArray(bytes->data() + kHead, int(length))) return false;
  bytes->erase(0, checked + kCrc);
  return true;
}

bool is_rigs_store(const fs::path& folder) {
  v1::BurstCounter counter;
  return read_record(folder / "counter", &counter);
}

void require_outside_stores(const fs::path& place) {
  std::error_code failed;  // then it is looked at as it is named
  fs::path at = fs::weakly_canonical(fs::absolute(place), failed);
  if (failed) at = fs::absolute(place);
  for (; at.has_relative_path(); at = at.parent_path()) {
    if (!is_rigs_store(at)) continue;
    throw_bad_input(place.string(), "is in a rig's own store, " + at.string(),
                    "name a folder outside it");
  }
}

StoreFolder::StoreFolder(fs::path folder) : folder_(std::move(folder)) {
  if (!fs::is_directory(folder_)) {
    throw_bad_input(folder_.string(), "is no folder",
                    "give the folder that lamella-rigd stores in");
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const uint64_t id = id_of(entry.path().filename().string());
    if (id != 0 && fs::exists(entry.path() / "session.json")) {
      throw_bad_input(entry.path().string(), "is a session, not a burst that a rig keeps",
                      "give the folder that lamella-rigd stores in");
    }
    if (id != 0 && entry.is_directory()) read_burst(id, entry.path());
  }
  if (bursts_.empty() && !fs::exists(folder_ / "counter")) {
    throw_bad_input(folder_.string(), "holds no bursts of a rig",
                    "give the folder that lamella-rigd stores in");
  }
}

void StoreFolder::read_burst(uint64_t id, const fs::path& folder) {
  Found& found = bursts_[id];
  found.folder = folder;
  v1::HeldBurst& about = found.about;
  about.set_burst_id(id);
  v1::BurstBegin begin;
  if (read_record(folder / "begin", &begin) && begin.burst_id() == id) {
    about.set_begun_unix_us(begin.begun_unix_us());
    about.set_frames_expected(begin.frames_expected());
    about.set_flashing_confirmed(begin.flashing_confirmed());
    about.set_subject(begin.subject());
  }
  std::vector<uint32_t> there;
  size_t damaged = 0;
  for (uint32_t i = 0; i <= kMaxFrameId; ++i) {
    const fs::path raw = folder / (frame_name(i) + ".raw");
    v1::FrameOffer offer;
    if (fs::exists(folder / (frame_name(i) + ".acked"))) {
      about.set_frames_acknowledged(about.frames_acknowledged() + 1);
      there.push_back(i);
      continue;
    }
    // A record that power left beside its place counts where the photograph bears it out.
    const bool placed = fs::exists(folder / (frame_name(i) + ".record"));
    const std::string record = frame_name(i) + (placed ? ".record" : ".record.tmp");
    const bool read =
        read_record(folder / record, &offer) && offer.burst_id() == id && offer.frame_id() == i;
    if (read && is_sound(raw, offer)) {
      about.set_frames_held(about.frames_held() + 1);
      about.set_bytes_held(about.bytes_held() + offer.size_bytes());
      found.frames[i] = offer;
      there.push_back(i);
    } else if (placed) {
      ++damaged;
    }
  }
  v1::BurstEnd end;
  const bool ended = read_record(folder / "end", &end) && end.burst_id() == id;
  const bool all = std::all_of(end.frame_ids().begin(), end.frame_ids().end(), [&](uint32_t frame) {
    return std::find(there.begin(), there.end(), frame) != there.end();
  });
  about.set_whole(ended && end.why().empty() && all);
  if (!about.whole()) about.set_why(explanation(about, ended ? &end : nullptr, damaged));
}

const StoreFolder::Found& StoreFolder::found(uint64_t burst_id) const {
  const auto it = bursts_.find(burst_id);
  if (it == bursts_.end()) {
    throw_bad_input(folder_.string(), "holds no burst " + std::to_string(burst_id),
                    "`lamella rig recover` lists those that it holds");
  }
  return it->second;
}

std::vector<v1::HeldBurst> StoreFolder::held() {
  std::vector<v1::HeldBurst> held;
  for (const auto& [id, burst] : bursts_) held.push_back(burst.about);
  return held;
}

std::string StoreFolder::calibration(const Burst& burst) {
  const fs::path path = found(burst.id).folder / "calibration.json";
  const std::optional<std::string> text = read_file(path, kMaxRecordsBytes);
  if (!text) throw_bad_input(path.string(), "cannot be read", "the burst cannot be developed");
  return *text;
}

std::vector<v1::FrameOffer> StoreFolder::offers(const Burst& burst) {
  std::vector<v1::FrameOffer> offers;
  for (const auto& [id, offer] : found(burst.id).frames) offers.push_back(offer);
  return offers;
}

v1::BurstDone StoreFolder::ending(const Burst& burst) {
  v1::BurstEnd end;
  const bool ended = read_record(found(burst.id).folder / "end", &end);
  return ended && end.burst_id() == burst.id ? end.done() : v1::BurstDone();
}

std::vector<uint8_t> StoreFolder::photograph(const v1::FrameOffer& offer) {
  const fs::path raw = found(offer.burst_id()).folder / (frame_name(offer.frame_id()) + ".raw");
  const std::optional<std::string> bytes = read_file(raw, kMaxPhotographBytes);
  if (!bytes || crc32c(bytes->data(), bytes->size()) != offer.crc32c()) {
    throw_bad_input(raw.string(), "has other bytes than a moment ago");
  }
  return {bytes->begin(), bytes->end()};
}

v1::TimingEdges StoreFolder::timing(const Burst& burst) {
  v1::TimingEdges timing, page;
  std::optional<std::string> bytes = read_file(found(burst.id).folder / "timing", kMaxRecordsBytes);
  while (bytes && take_record(&*bytes, &page)) {
    timing.set_total_edges(page.total_edges());
    timing.set_zero_us(page.zero_us());
    *timing.mutable_latency() = page.latency();
    timing.mutable_edges()->MergeFrom(page.edges());
  }
  return timing;
}

}  // namespace lamella
