#include "apps/recalibrated_source.h"

#include "io/session_rig.h"
#include "io/whole_file.h"

namespace lamella::apps {

RecalibratedSource::RecalibratedSource(std::unique_ptr<BurstSource> source,
                                       const fs::path& calibration)
    : source_(std::move(source)), calibration_(read_text(calibration)) {
  Session session;
  calibration_from(calibration_, calibration.string(), &session);
}

}  // namespace lamella::apps
