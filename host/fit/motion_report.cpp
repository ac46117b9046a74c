#include "fit/motion_report.h"

#include <fmt/format.h>

namespace lamella::fit {

namespace {

// A head of the twin that moves so far is fitted as one at rest, but for its position, which is off
// by what it moved along the axis; nothing was tried beyond.
constexpr double kMostMendedMm = 2.5;

std::string frame_name(const Frame& frame) {
  const bool numbered = frame.role == Role::kFringe || frame.role == Role::kStripes;
  return fmt::format("{}{} {}", role_name(frame.role),
                     numbered ? fmt::format(" {}", frame.index) : "",
                     analyser_name(frame.analyser));
}

}  // namespace

v1::Motion message_from_motion(const Motion& motion) {
  v1::Motion out;
  out.set_mended(motion.is_mended);
  out.set_why(motion.why);
  if (motion.is_mended && motion.moved_mm > kMostMendedMm) {
    out.set_why(fmt::format("at most {:g} mm can be", kMostMendedMm));
  }
  if (motion.frames.empty()) return out;
  const Vec3d drift = motion.frames.back().moved_mm - motion.frames.front().moved_mm;
  for (int a = 0; a < 3; ++a) out.add_drift_mm(drift[a]);
  out.set_moved_mm(motion.moved_mm);
  out.set_moved_mm_stddev(motion.moved_mm_stddev);
  out.set_moved_px(motion.moved_px);
  out.set_moved_px_stddev(motion.moved_px_stddev);
  for (const FrameMotion& f : motion.frames) {
    v1::FrameMotion* frame = out.add_frames();
    frame->set_frame(frame_name(*f.frame));
    frame->set_trigger_us(f.frame->trigger_us);
    for (int a = 0; a < 3; ++a) frame->add_moved_mm(f.moved_mm[a]);
    for (int a = 0; a < 2; ++a) frame->add_moved_px(f.image_px[a]);
  }
  return out;
}

std::vector<CheckLine> judge_motion(const Motion& motion) {
  std::vector<CheckLine> lines;
  if (motion.is_mended && motion.moved_mm > kMostMendedMm) {
    lines.push_back(
        {Grade::kPoor, "motion",
         fmt::format("the subject moved {:.2f} mm during the burst, at most {:g} mm can "
                     "be mended; take the burst again",
                     motion.moved_mm, kMostMendedMm),
         motion.moved_mm, "mm", kMostMendedMm});
  }
  std::string jerks;
  for (const std::string& jerk : motion.jerks) jerks += (jerks.empty() ? "" : ", ") + jerk;
  if (!jerks.empty()) {
    lines.push_back({Grade::kPoor, "motion",
                     "the subject did not move smoothly: " + jerks +
                         " off its path; take the burst "
                         "again",
                     double(motion.jerks.size()), "", 0});
  }
  return lines;
}

}  // namespace lamella::fit
