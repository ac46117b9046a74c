// Regions of a face that nobody has painted: where its skin is alike in colour, gloss and place.
#pragma once

#include <string>
#include <vector>

#include "fit/normals.h"

namespace lamella::fit {

struct FoundRegions {
  Labels labels;                   // 0 where `burst.regions` is
  std::vector<std::string> names;  // names[label]; what is known of a region and no more
};

// Each is large enough for the layers' fits: dots, and the peak of the lobe under FRONT. One region
// "face" where the photographs tell no skin from other skin.
FoundRegions find_regions(const Burst& burst, const Geometry& geometry, const Normals& normals);

// Labels of blocks of `step_px` pixels to those of pixels: at each pixel of `subject` the label
// that most of the four blocks around it have, by their nearness; of the nearest block that has one
// where none of the four does.
Labels labels_of_pixels(const Labels& blocks, int step_px, const Mask& subject);

}  // namespace lamella::fit
