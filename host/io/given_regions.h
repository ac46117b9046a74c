// Regions that are given apart from a session: painted by somebody, or those of a fit, edited.
#pragma once

#include "io/session.h"

namespace lamella {

// The label image `png` takes the place of the session's regions. Names are those of the file of
// the same name that ends in .json ({"names": ["background", ...]}), as a fit writes it; where
// there is none, every grey value above 0 is a region named after it, "region 128". Throws Error
// where the image is none, of another size than the left camera, all 0, has a label without a name,
// a name without a label, or without names more grey values than anybody paints regions with.
void give_regions(const fs::path& png, Session* session);

}  // namespace lamella
