#include "apps/resumed_source.h"

#include <fmt/format.h>

#include <fstream>

#include "base/error.h"
#include "io/crc32c.h"

namespace lamella::apps {

namespace {

std::vector<uint8_t> read_bytes(const fs::path& path, size_t max_bytes) {
  if (!fs::exists(path) || fs::file_size(path) > max_bytes) return {};
  const std::string text = read_text(path, max_bytes);
  return {text.begin(), text.end()};
}

}  // namespace

// The CRC32C in the name keeps what one burst left from being taken for another's.
fs::path ResumedSource::file_of(const v1::FrameOffer& offer) const {
  return folder_ / fmt::format("burst-{:06}-frame-{:02}-{:08x}.raw", offer.burst_id(),
                               offer.frame_id(), offer.crc32c());
}

std::vector<uint8_t> ResumedSource::photograph(const v1::FrameOffer& offer) {
  const fs::path file = file_of(offer);
  std::vector<uint8_t> bytes = read_bytes(file, offer.size_bytes());
  fs::create_directories(folder_);
  {
    std::ofstream out(file, bytes.empty() ? std::ios::binary : std::ios::binary | std::ios::app);
    try {
      out.exceptions(std::ios::failbit | std::ios::badbit);
      rig_->continue_photograph(offer, &bytes, [&](std::span<const uint8_t> part) {
        out.write(reinterpret_cast<const char*>(part.data()), std::streamsize(part.size()));
      });
      out.flush();
    } catch (const std::ios::failure&) {
      throw_bad_input(file.string(), "cannot be written", "check the space on its disk");
    }
  }
  if (crc32c(bytes.data(), bytes.size()) == offer.crc32c()) return bytes;
  fs::remove(file);  // what lay there was spoilt, or came so: from the start, checked by the link
  return rig_->photograph(offer);
}

void ResumedSource::forget(const std::vector<v1::FrameOffer>& offers) {
  std::error_code ignored;
  for (const v1::FrameOffer& offer : offers) fs::remove(file_of(offer), ignored);
  if (fs::is_directory(folder_)) fs::remove(folder_, ignored);  // where it is empty
}

}  // namespace lamella::apps
