#include <algorithm>

#include "base/parallel.h"
#include "fit/motion.h"
#include "fit/registration.h"

namespace lamella::fit {

namespace {

constexpr float kLeastWhite = 1e-4f;  // of FRONT: darker says nothing of the skin
constexpr float kMostBrighter = 2;    // within a pixel, but for noise

bool has_fine_pattern(const Frame& frame) {
  return frame.role == Role::kStripes || frame.role == Role::kDots;
}

// Times what the skin shows at a pixel over what it shows `rest_px` before it.
void put_texture_in_place(const Image3& white, const Image3& white_before, Image3* image) {
  for (int y = 0; y < image->rows; ++y) {
    for (int x = 0; x < image->cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float here = white(y, x)[c], before = white_before(y, x)[c];
        if (here < kLeastWhite || before < kLeastWhite) continue;
        (*image)(y, x)[c] *= std::clamp(here / before, 1 / kMostBrighter, kMostBrighter);
      }
    }
  }
}

class Mender {
 public:
  Mender(const Session& session, const Motion& motion, const Photographs& photographs)
      : session_(session), motion_(motion) {
    const Frame* front = session.find(session.left.id, Role::kFront, 0, Analyser::kCross);
    front_ = photographs.at(front).radiance;
    front_by_px_ = motion.mended_px(session.left, front->trigger_us);
  }

  Photograph mended(const Frame& frame, const Photograph& taken) const {
    const cv::Vec2d by_px = motion_.mended_px(session_.camera(frame.camera), frame.trigger_us);
    if (!has_fine_pattern(frame)) {
      return {shifted(taken.radiance, by_px), shifted_mask(taken.clipped, by_px)};
    }
    const cv::Vec2d whole_px = motion_.mended_whole_px(session_, frame.role);
    Photograph out{shifted(taken.radiance, whole_px), shifted_mask(taken.clipped, whole_px)};
    put_texture_in_place(shifted(front_, front_by_px_),
                         shifted(front_, front_by_px_ - (by_px - whole_px)), &out.radiance);
    return out;
  }

 private:
  const Session& session_;
  const Motion& motion_;
  Image3 front_;  // cross, of the left camera, as it was taken
  cv::Vec2d front_by_px_;
};

}  // namespace

void mend_motion(const Session& session, const Motion& motion, Photographs* photographs) {
  if (!motion.is_mended) return;
  const Mender mender(session, motion, *photographs);
  std::vector<std::pair<const Frame*, Photograph*>> all;
  for (auto& [frame, photograph] : *photographs) all.push_back({frame, &photograph});
  parallel_for(int(all.size()), [&](int i) {
    const auto& [frame, photograph] = all[size_t(i)];
    *photograph = mender.mended(*frame, *photograph);
  });
}

}  // namespace lamella::fit
