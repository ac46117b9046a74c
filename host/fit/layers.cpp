#include "fit/layers.h"

#include <array>

#include "base/error.h"
#include "base/progress.h"
#include "fit/binned.h"
#include "fit/find_regions.h"
#include "fit/pattern_extinction.h"
#include "fit/report.h"

namespace lamella::fit {

namespace {

constexpr std::array<std::pair<const char*, Step>, 8> kSteps{{{"linearise", Step::kLinearise},
                                                              {"geometry", Step::kGeometry},
                                                              {"normals", Step::kNormals},
                                                              {"regions", Step::kRegions},
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

// Runs `work` and notes its seconds under its name.
template <class Work>
auto note_time(v1::Layers* layers, const std::string& name, const Work& work) {
  const Stopwatch watch;
  auto result = work();
  (*layers->mutable_timings_s())[name] = watch.seconds();
  return result;
}

// The same, for a step.
template <class Work>
auto timed(Course* course, const std::string& name, const Work& work) {
  auto result = note_time(course->layers, name, work);
  course->progress.advance(++course->done);
  return result;
}

// The rerendering that judges a whole fit is a step of its own.
int steps_until(Step until) { return int(until) + (until == Step::kAlbedo ? 2 : 1); }

// Regions are the session's; where it has none they are found, once the surface is known.
bool settle_regions(const Geometry& geometry, const Normals& normals, Burst* burst) {
  if (burst->has_given_regions) return false;
  FoundRegions found = find_regions(*burst, geometry, normals);
  burst->regions = found.labels;
  burst->region_names = found.names;
  return true;
}

void run_steps(Step until, LayerUse use, Burst* burst, Course* course, LayeredFit* fit) {
  start_report(*burst, fit);
  if (until == Step::kLinearise) return;

  Geometry geometry = timed(course, "geometry", [&] { return reconstruct_geometry(*burst); });
  remove_pattern_extinction(geometry, burst);
  if (until > Step::kGeometry) {
    const Normals normals =
        timed(course, "normals", [&] { return estimate_normals(*burst, &geometry); });
    report_normals(normals, fit);
    if (until >= Step::kRegions) {
      timed(course, "regions", [&] { return settle_regions(geometry, normals, burst); });
      report_regions(*burst, fit);
    }
    SpecularFit specular;
    Separation separation;
    if (until >= Step::kSpecular) {
      specular = timed(course, "specular", [&] { return fit_specular(*burst, geometry, normals); });
      report_specular(specular, fit);
    }
    if (until >= Step::kSeparate) {
      separation =
          timed(course, "separate", [&] { return separate_layers(*burst, geometry, normals); });
      Scattering scattering;
      if (until >= Step::kScattering) {
        scattering = timed(course, "scattering", [&] {
          return fit_scattering(*burst, geometry, normals, use, &separation);
        });
      }
      report_separation(separation, fit);
      if (until >= Step::kScattering) report_scattering(scattering, fit);
    }
    if (until >= Step::kAlbedo) {
      const Albedo albedo =
          timed(course, "albedo", [&] { return fit_albedo(*burst, geometry, normals); });
      report_albedo(albedo, fit);
      const FittedLayers fitted{geometry, normals, specular, separation, albedo};
      report_rerender(timed(course, "rerender", [&] { return rerender(*burst, fitted); }), fit);
    }
  }
  report_geometry(*burst, geometry, fit);
}

}  // namespace

Step step_from_name(const std::string& name) {
  std::string known;
  for (const auto& [step_name, step] : kSteps) {
    if (name == step_name) return step;
    known += (known.empty() ? "" : ", ") + std::string(step_name);
  }
  throw_bad_input("--until", "no step \"" + name + "\"", "one of " + known);
}

LayeredFit fit_layers(const Session& session, Step until, LayerUse use, const Quality& quality,
                      const TriangleMesh* mesh) {
  LayeredFit fit;
  Course course{&fit.layers, Progress("fitting, step", steps_until(until))};
  Burst burst = timed(&course, "linearise", [&] { return linearise(session, mesh); });
  burst.quality = quality;
  fit.check = burst.check;
  if (quality.bin_px == 1) {
    run_steps(until, use, &burst, &course, &fit);
  } else {
    Labels regions = burst.regions;
    const Session binned = binned_session(session, quality.bin_px);
    burst =
        note_time(&fit.layers, "bin", [&] { return binned_burst(burst, binned, quality.bin_px); });
    run_steps(until, use, &burst, &course, &fit);
    note_time(&fit.layers, "unbin", [&] {
      if (!burst.has_given_regions) {
        regions = labels_of_pixels(burst.regions, quality.bin_px, regions > 0);
      }
      unbin_maps(regions, session.left, quality.bin_px, &fit.maps);
      return 0;
    });
  }
  settle_confidence(&fit.maps);
  return fit;
}

}  // namespace lamella::fit
