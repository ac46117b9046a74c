#include "apps/recalibrated_source.h"

#include <fmt/format.h>

#include <optional>

#include "base/error.h"
#include "calib/same_rig.h"
#include "io/json.h"
#include "io/session_rig.h"
#include "io/whole_file.h"

namespace lamella::apps {

namespace {

// Empty where the two are of one rig.
std::string difference(const v1::Welcome& rig, const v1::Session& calibration) {
  try {
    require_same_rig(rig, calibration);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

// What a burst's own calibration says of the rig that took it; nothing where it cannot be read.
std::optional<v1::Welcome> rig_that_took(const Burst& burst, BurstSource* source) {
  v1::Session own;
  try {
    parse_json(source->calibration(burst), "its calibration", &own);
  } catch (const Error&) {
    return {};
  }
  return rig_of(own);
}

}  // namespace

RecalibratedSource::RecalibratedSource(std::unique_ptr<BurstSource> source, fs::path calibration)
    : source_(std::move(source)), file_(std::move(calibration)), text_(read_text(file_)) {
  Session session;
  manifest_ = calibration_from(text_, file_.string(), &session);
}

std::string RecalibratedSource::calibration(const Burst& burst) {
  require_rig_of(burst);
  require_cameras_of(burst);
  return text_;
}

void RecalibratedSource::require_rig_of(const Burst& burst) {
  const std::optional<v1::Welcome> own = rig_that_took(burst, source_.get());
  const v1::Welcome* now = source_->answering();
  if (own && difference(*own, manifest_).empty()) return;
  if (now && difference(*now, manifest_).empty()) return;
  if (!own && !now) return;
  throw_bad_input(file_.string(), fmt::format("is not of the rig that took burst {}: there {}",
                                              burst.id, difference(own ? *own : *now, manifest_)));
}

void RecalibratedSource::require_cameras_of(const Burst& burst) {
  for (const v1::FrameOffer& offer : source_->offers(burst)) {
    bool fits = false;
    for (const v1::Camera& camera : manifest_.rig().cameras()) {
      fits = fits || (camera.id() == offer.frame().camera() && camera.width() == offer.width() &&
                      camera.height() == offer.height());
    }
    if (fits) continue;
    throw_bad_input(file_.string(),
                    fmt::format("has no {} camera of {} x {} pixels, as burst {}",
                                offer.frame().camera(), offer.width(), offer.height(), burst.id));
  }
}

void RecalibratedSource::require_same_in(const fs::path& folder) const {
  v1::Session there;
  read_json(folder / "session.json", &there);
  if (to_json(there.rig()) == to_json(manifest_.rig()) &&
      to_json(there.patterns()) == to_json(manifest_.patterns())) {
    return;
  }
  throw_bad_input(folder.string(),
                  "holds this burst with another calibration than " + file_.string(),
                  "remove it, or choose another --out");
}

}  // namespace lamella::apps
