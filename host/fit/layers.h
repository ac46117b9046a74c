// The fit: twenty photographs to the layers of the model, one page, step by step as the paper
// has it.
#pragma once

#include <string>
#include <vector>

#include "calib/check.h"
#include "fit/doubt.h"
#include "fit/layer_choice.h"
#include "fit/quality.h"
#include "io/layer_maps.h"
#include "io/mesh_file.h"
#include "io/session.h"

namespace lamella::fit {

// Steps in order; `--until` names the last one to run.
enum class Step {
  kLinearise,
  kGeometry,
  kNormals,
  kRegions,
  kSpecular,
  kSeparate,
  kScattering,
  kAlbedo
};

// Throws Error that lists the names where `name` is none of them.
Step step_from_name(const std::string& name);

// What is said of one layer of one region: "eyelids", "single", "cannot be judged ...".
struct DoubtedLayer {
  std::string region, layer, why;
  Doubt doubt;
};

struct LayeredFit {
  LayerMaps maps;
  v1::Layers layers;
  std::vector<DoubtedLayer> doubted;
  std::vector<std::string> notes;  // what was done otherwise than asked, and why
  SessionCheck check;              // its poor lines are what to expect less of the fit for
};

// Throws Error on bad input; what the data cannot tell is said in the result. `mesh`: the subject's
// shape, instead of what the fringes say of it.
LayeredFit fit_layers(const Session& session, Step until, LayerUse use = LayerUse::kAuto,
                      const Quality& quality = {}, const TriangleMesh* mesh = nullptr);

}  // namespace lamella::fit
