// The truth of a session in the terms of the fit's steps: what a step is given when everything
// but what it estimates is to be known. For the bench alone: no fit ever reads it.
#pragma once

#include <vector>

#include "fit/lobe_fit.h"
#include "fit/scattering.h"
#include "io/layer_maps.h"

namespace lamella::apps {

struct Truth {
  fs::path folder;
  LayerMaps maps;  // of the left camera's size
  v1::Layers layers;
};

// From `folder`, about the subject of `session`. Throws Error where there is none, it is of another
// size, or lacks a map.
Truth read_truth(const fs::path& folder, const Session& session);

// Regions and their names.
void take_regions(const Truth& truth, fit::Burst* burst);

fit::Geometry true_geometry(const fit::Burst& burst, const Truth& truth);

// `estimated`: of the same burst, on true geometry; lends the visibility, which no truth tells.
fit::Normals true_normals(const fit::Normals& estimated, const Truth& truth);

// Lobe and single scattering of every region, by label - 1, and a clean interface's c; a typical
// lobe where the truth has none.
std::vector<fit::RegionFit> true_skin(const Truth& truth);

// The mean g of the channels.
float true_asymmetry(const Truth& truth);

fit::Separation true_separation(const Truth& truth);

}  // namespace lamella::apps
