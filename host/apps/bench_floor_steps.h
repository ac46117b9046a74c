// One step of the fit at a time, all that it does not estimate being known.
#pragma once

#include <string>
#include <vector>

#include "apps/bench_truth.h"
#include "fit/layers.h"

namespace lamella::apps {

// A burst with what is known of its subject.
struct KnownScene {
  fit::Burst burst;
  Truth truth;
  fit::Geometry geometry;
  fit::Normals estimated;  // from the photographs and the true geometry
  fit::Normals normals;
};

// Reads the photographs of `session`, which must outlive the result, and what folder `truth` says
// of its subject.
KnownScene know_scene(const Session& session, const fs::path& truth);

struct FloorStep {
  std::vector<std::string> figures;                            // by their names in bench.csv
  const char* given;                                           // what is taken from truth
  void (*run)(const KnownScene& scene, fit::LayeredFit* fit);  // adds its maps and numbers
};

const std::vector<FloorStep>& floor_steps();

// The one that makes `figure`; throws Error where none does.
const FloorStep& step_of_figure(const std::string& figure);

}  // namespace lamella::apps
