// What every photograph of a burst is looked at for: light of every colour, and none beyond what
// the sensor takes.
#pragma once

#include "calib/check.h"

namespace lamella {

struct CheckedFrames {
  const Session& session;
  const Photographs& photographs;
  const std::vector<cv::Point>& left_pixels;   // of the subject
  const std::vector<cv::Point>& right_pixels;  // the same in the right camera; may be empty
};

// "left FRINGE 2 CROSS"
std::string name_of(const Frame& frame);

// A share that should be next to nothing, and is poor above `most`.
CheckLine share_line(const std::string& name, double figure, double most, const std::string& of);

// Unusable where a photograph that should have light has none, or none of some colour.
CheckLine check_lit(const CheckedFrames& frames);

// A line for the left camera's photographs by the LEDs, one for those by the projector, and one for
// the right camera. Unusable where most of the subject is clipped in frames that nothing replaces.
std::vector<CheckLine> check_clipping(const CheckedFrames& frames);

}  // namespace lamella
