// The subject's motion during a burst: estimated from photographs that show the same skin, told,
// and taken out of them where it is more than its own sigma.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calib/photographs.h"
#include "fit/drift.h"

namespace lamella::fit {

// Where the subject was when one photograph of the left camera was taken, less where it was at the
// mean of the trigger times, which is where the maps have it.
struct FrameMotion {
  const Frame* frame;
  cv::Vec2d image_px{0, 0};  // in the photograph, at the depth of the rig's origin
  Vec3d moved_mm{0, 0, 0};   // rig frame; across the left camera's axis, along it unknown
};

struct Motion {
  std::vector<FrameMotion> frames;  // by time; empty: nothing can be told, for the reason in `why`
  // Between the two photographs that are farthest apart, across the camera's axis.
  double moved_mm = 0, moved_mm_stddev = 0;
  double moved_px = 0, moved_px_stddev = 0;
  bool is_mended = false;
  std::string why;                 // it was not mended
  std::vector<std::string> jerks;  // photographs that are off the smooth path, by how much
  DriftPath path;                  // in the picture, from the mean of the trigger times
  double mean_trigger_us = 0;
  std::array<Vec3d, 2> mm_per_px{};  // of a shift right and one down, at the rig's origin

  double time_s(double trigger_us) const;  // of the path
  Vec3d moved_mm_at(double trigger_us) const;

  // What was mended of a photograph of either camera; zero of a subject at rest.
  Vec3d mended_mm(double trigger_us) const;
  cv::Vec2d mended_px(const Camera& camera, double trigger_us) const;
  // The same in whole pixels for all photographs of a pattern of the left camera.
  cv::Vec2d mended_whole_px(const Session& session, Role pattern) const;
};

// From photographs of one kind of light among themselves (full and frontal gradient; the fringes'
// coarser levels, whose channels sum to white; stripes and their complements), and from those of
// LEDs and projector against each other. `labels` may be empty. Takes time linear in the pixels.
Motion estimate_motion(const Session& session, const Photographs& photographs,
                       const Labels& labels);

// Every photograph as it would show the subject at the mean of the trigger times, by shifting it:
// what lies nearer or farther than the rig's origin is off by its share of that. STRIPES and DOTS
// are finer than an interpolation keeps: they are shifted by whole pixels, and FRONT says how much
// brighter the skin is where it should be.
void mend_motion(const Session& session, const Motion& motion, Photographs* photographs);

}  // namespace lamella::fit
