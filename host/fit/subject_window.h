// What of a burst's photographs shows the subject: the rest is neither read nor fitted. A head
// leaves two fifths of its photographs dark.
#pragma once

#include "base/vec.h"
#include "calib/photographs.h"

namespace lamella::fit {

// Smallest part of `image` that has all of its light, with a margin; all of it where it is dark. It
// lies about the light alike wherever that is in the image.
cv::Rect lit_area(const Image3& image);

// Around all pixels that are not 0; empty where there are none.
cv::Rect bounds_of(const Mask& mask);

struct SubjectBurst {
  Session session;     // its cameras have no other pixels than those of the subject
  Photographs fronts;  // what was read on the way; by frames of `session`
};

// The pixels of a burst that FRONT lights, and those that labels name. Light on what has no label
// counts: it may cast shadows. Throws Error as `read_photograph` and `read_regions` do.
SubjectBurst find_subject(const Session& session);

}  // namespace lamella::fit
