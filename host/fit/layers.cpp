#include "fit/layers.h"

#include <array>

#include "base/error.h"
#include "base/progress.h"
#include "fit/pattern_extinction.h"
#include "fit/report.h"

namespace lamella::fit {

namespace {

constexpr std::array<std::pair<const char*, Step>, 7> kSteps{{{"linearise", Step::kLinearise},
                                                              {"geometry", Step::kGeometry},
                                                              {"normals", Step::kNormals},
                                                              {"specular", Step::kSpecular},
                                                              {"separate", Step::kSeparate},
                                                              {"scattering", Step::kScattering},
                                                              {"albedo", Step::kAlbedo}}};

// The steps of one fit as they pass.
struct Course {
  v1::Layers* layers;
  Progress progress;
  int done = 0;
};

// Runs a step and notes its seconds under its name.
template <class Work>
auto timed(Course* course, const std::string& name, const Work& work) {
  const Stopwatch watch;
  auto result = work();
  (*course->layers->mutable_timings_s())[name] = watch.seconds();
  course->progress.advance(++course->done);
  return result;
}

// The rerendering that judges a whole fit is a step of its own.
int steps_until(Step until) { return int(until) + (until == Step::kAlbedo ? 2 : 1); }

}  // namespace

Step step_from_name(const std::string& name) {
  std::string known;
  for (const auto& [step_name, step] : kSteps) {
    if (name == step_name) return step;
    known += (known.empty() ? "" : ", ") + std::string(step_name);
  }
  throw_bad_input("--until", "no step \"" + name + "\"", "one of " + known);
}

LayeredFit fit_layers(const Session& session, Step until, LayerUse use) {
  LayeredFit fit;
  Course course{&fit.layers, Progress("fitting, step", steps_until(until))};
  Burst burst = timed(&course, "linearise", [&] { return linearise(session); });
  fit.check = burst.check;
  start_report(burst, &fit);
  if (until == Step::kLinearise) return fit;

  Geometry geometry = timed(&course, "geometry", [&] { return reconstruct_geometry(burst); });
  remove_pattern_extinction(geometry, &burst);
  if (until > Step::kGeometry) {
    const Normals normals =
        timed(&course, "normals", [&] { return estimate_normals(burst, &geometry); });
    report_normals(normals, &fit);
    SpecularFit specular;
    Separation separation;
    if (until >= Step::kSpecular) {
      specular = timed(&course, "specular", [&] { return fit_specular(burst, geometry, normals); });
      report_specular(specular, &fit);
    }
    if (until >= Step::kSeparate) {
      separation =
          timed(&course, "separate", [&] { return separate_layers(burst, geometry, normals); });
      Scattering scattering;
      if (until >= Step::kScattering) {
        scattering = timed(&course, "scattering", [&] {
          return fit_scattering(burst, geometry, normals, use, &separation);
        });
      }
      report_separation(separation, &fit);
      if (until >= Step::kScattering) report_scattering(scattering, &fit);
    }
    if (until >= Step::kAlbedo) {
      const Albedo albedo =
          timed(&course, "albedo", [&] { return fit_albedo(burst, geometry, normals); });
      report_albedo(albedo, &fit);
      const FittedLayers fitted{geometry, normals, specular, separation, albedo};
      report_rerender(timed(&course, "rerender", [&] { return rerender(burst, fitted); }), &fit);
    }
  }
  report_geometry(geometry, &fit);
  return fit;
}

}  // namespace lamella::fit
