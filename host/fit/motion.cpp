#include "fit/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "base/parallel.h"
#include "fit/registration.h"
#include "fit/texture_carriers.h"

namespace lamella::fit {

namespace {

constexpr double kSigmasOfMotion = 3;  // less than this is rest
constexpr double kLeastMotionMm = 0.05;
constexpr double kMostSigmaMm = 0.1;  // of the motion itself: worse than this it is not known
constexpr double kSigmasOfJerk = 6;
constexpr double kDepthError = 0.1;  // of mm per pixel: skin is nearer than the rig's origin

// The left camera's frames in the order of their times, which do not depend on the manifest's.
std::vector<const Frame*> frames_by_time(const Session& session) {
  std::vector<const Frame*> frames;
  for (const Frame& frame : session.frames) {
    if (frame.camera == session.left.id && frame.role != Role::kValidation) {
      frames.push_back(&frame);
    }
  }
  const auto key = [](const Frame* f) {
    return std::tuple(f->trigger_us, f->role, f->index, f->analyser);
  };
  std::sort(frames.begin(), frames.end(),
            [&](const Frame* a, const Frame* b) { return key(a) < key(b); });
  return frames;
}

double mean_trigger_us(const std::vector<const Frame*>& frames) {
  double sum = 0;
  for (const Frame* frame : frames) sum += frame->trigger_us;
  return sum / double(frames.size());
}

std::vector<ShiftBetween> measure_shifts(const TextureCarriers& textures, double zero_us,
                                         std::vector<std::string>* names) {
  std::vector<Registration> found(textures.links.size());
  parallel_for(int(found.size()), [&](int i) {
    const CarrierLink& link = textures.links[size_t(i)];
    found[size_t(i)] =
        register_textures(textures.carriers[link.from].texture, textures.carriers[link.to].texture);
  });
  std::vector<ShiftBetween> shifts;
  for (size_t i = 0; i < found.size(); ++i) {
    if (!found[i].is_found) continue;
    const CarrierLink& link = textures.links[i];
    const TextureCarrier &from = textures.carriers[link.from], &to = textures.carriers[link.to];
    const double own_px = link.sigma_mm / textures.pixel_mm;
    ShiftBetween s{
        (from.time_us - zero_us) * 1e-6, (to.time_us - zero_us) * 1e-6, found[i].shift_px, {}};
    for (int a = 0; a < 2; ++a) s.sigma[a] = std::hypot(found[i].sigma_px[a], own_px);
    s.shift *= double(textures.bin_px);
    s.sigma *= double(textures.bin_px);
    shifts.push_back(s);
    names->push_back(to.name);
  }
  return shifts;
}

// What a shift in the picture is at the rig's origin.
std::array<Vec3d, 2> mm_per_px(const Camera& left) {
  const double depth_mm = left.depth_mm({0, 0, 0});
  const Mat33d rig_from_cam = left.cam_from_rig.t();
  return {rig_from_cam * Vec3d(depth_mm / left.fx, 0, 0),
          rig_from_cam * Vec3d(0, depth_mm / left.fy, 0)};
}

void put_extent(Motion* m) {
  for (const FrameMotion& a : m->frames) {
    for (const FrameMotion& b : m->frames) {
      const cv::Vec2d apart = b.image_px - a.image_px;
      if (!(cv::norm(apart) > m->moved_px)) continue;
      const cv::Vec2d sigma =
          m->path.sigma(m->time_s(a.frame->trigger_us), m->time_s(b.frame->trigger_us));
      m->moved_px = cv::norm(apart);
      m->moved_px_stddev = std::hypot(sigma[0] * apart[0], sigma[1] * apart[1]) / m->moved_px;
      m->moved_mm = cv::norm(b.moved_mm - a.moved_mm);
      m->moved_mm_stddev = m->moved_px_stddev * m->moved_mm / m->moved_px;
    }
  }
}

void judge(Motion* motion) {
  if (motion->moved_mm_stddev > kMostSigmaMm) {
    motion->why = fmt::format("it is known to {:.2f} mm only: the skin shows too little texture",
                              motion->moved_mm_stddev);
  } else if (motion->moved_mm < kSigmasOfMotion * motion->moved_mm_stddev) {
    motion->why = fmt::format("it is within {:g} sigmas of rest", kSigmasOfMotion);
  } else if (motion->moved_mm < kLeastMotionMm) {
    motion->why = fmt::format("it is under {:g} mm", kLeastMotionMm);
  } else {
    motion->is_mended = true;
  }
}

Motion unknown(const std::string& why) {
  Motion motion;
  motion.why = why;
  return motion;
}

}  // namespace

double Motion::time_s(double trigger_us) const { return (trigger_us - mean_trigger_us) * 1e-6; }

Vec3d Motion::moved_mm_at(double trigger_us) const {
  const cv::Vec2d px = path.at(time_s(trigger_us));
  return mm_per_px[0] * px[0] + mm_per_px[1] * px[1];
}

Vec3d Motion::mended_mm(double trigger_us) const {
  return is_mended ? moved_mm_at(trigger_us) : Vec3d(0, 0, 0);
}

Motion estimate_motion(const Session& session, const Photographs& photographs,
                       const Labels& labels) {
  const std::vector<const Frame*> frames = frames_by_time(session);
  if (frames.back()->trigger_us == frames.front()->trigger_us) {
    return unknown("the frames have no times of their own (trigger_us)");
  }
  Motion motion;
  motion.mean_trigger_us = mean_trigger_us(frames);
  motion.mm_per_px = mm_per_px(session.left);
  std::vector<std::string> names;
  const std::vector<ShiftBetween> shifts = measure_shifts(
      texture_carriers(session, session.left, photographs, labels), motion.mean_trigger_us, &names);
  motion.path = DriftPath(shifts);
  if (motion.path.degree() == 0) return unknown("no two photographs show the same texture");
  for (const Frame* frame : frames) {
    motion.frames.push_back({frame, motion.path.at(motion.time_s(frame->trigger_us)),
                             motion.moved_mm_at(frame->trigger_us)});
  }
  put_extent(&motion);
  judge(&motion);
  motion.moved_mm_stddev = std::hypot(motion.moved_mm_stddev, kDepthError * motion.moved_mm);
  for (size_t i = 0; i < shifts.size(); ++i) {
    const double off = motion.path.off_sigmas(shifts[i]);
    if (off < kSigmasOfJerk) continue;
    motion.jerks.push_back(fmt::format("{} by {:.0f} sigmas", names[i], off));
  }
  return motion;
}

cv::Vec2d Motion::mended_px(const Camera& camera, double trigger_us) const {
  const Vec3d cam_mm = camera.cam_from_rig * mended_mm(trigger_us);
  const double depth_mm = camera.depth_mm({0, 0, 0});
  return {cam_mm[0] * camera.fx / depth_mm, cam_mm[1] * camera.fy / depth_mm};
}

cv::Vec2d Motion::mended_whole_px(const Session& session, Role pattern) const {
  cv::Vec2d sum(0, 0);
  double count = 0;
  for (const FrameMotion& f : frames) {
    if (f.frame->role != pattern) continue;
    sum += mended_px(session.left, f.frame->trigger_us);
    ++count;
  }
  return {std::round(sum[0] / std::max(1., count)), std::round(sum[1] / std::max(1., count))};
}

}  // namespace lamella::fit
