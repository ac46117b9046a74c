#include "fit/layers.h"

#include <fmt/format.h>

#include <array>
#include <mutex>

#include "base/error.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "calib/pattern_scale.h"
#include "fit/binned.h"
#include "fit/find_regions.h"
#include "fit/fit_check.h"
#include "fit/pattern_extinction.h"
#include "fit/report.h"
#include "fit/subject_window.h"

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

// The steps of one fit as they pass, some of them side by side.
struct Course {
  v1::Layers* layers;
  Progress progress;
  int done = 0;
  std::mutex mutex{};
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
  const Stopwatch watch;
  auto result = work();
  const std::lock_guard lock(course->mutex);
  (*course->layers->mutable_timings_s())[name] = watch.seconds();
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

// Each gives away what only it looks at: what comes later is written where that was, which is
// quicker than to memory that is new.
Geometry take_geometry(Burst* burst) {
  Burst whole = *burst;
  forget_fringes(burst);
  return reconstruct_geometry(std::move(whole));
}

// Regions are found by the gradients too.
Normals take_normals(Burst* burst, Geometry* geometry) {
  Burst whole = *burst;
  if (burst->has_given_regions) forget_gradients(burst);
  Normals normals = estimate_normals(std::move(whole), geometry);
  geometry->scene_mm.release();
  return normals;
}

// Nothing is known of what has no label, and what is constant takes as long to compress as what is
// not: the maps end where the labels do. `camera`: what they are in now.
void leave_out_unlabelled(const PixelWindow& camera, LayerMaps* maps) {
  const cv::Rect area = bounds_of(maps->regions > 0);
  *maps = part_of(*maps, area);
  maps->window = PixelWindow{camera.whole, area + camera.area.tl()};
}

// What the skin's layers are fitted from.
struct Surface {
  Burst* burst;
  const Geometry& geometry;
  const Normals& normals;
};

struct Skin {
  SpecularFit specular;
  Separation separation;
  BlackLevels black;
  Scattering scattering;
};

// Specular reflection and what scatters below it, side by side: each has stretches for one
// processor only.
Skin fit_skin(Step until, LayerUse use, const Surface& surface, Course* course) {
  const Burst& burst = *surface.burst;
  const Geometry& geometry = surface.geometry;
  const Normals& normals = surface.normals;
  Skin skin;
  const auto reflect = [&] {
    if (until < Step::kSpecular) return;
    skin.specular =
        timed(course, "specular", [&] { return fit_specular(burst, geometry, normals); });
  };
  const auto scatter = [&] {
    if (until < Step::kSeparate) return;
    skin.separation =
        timed(course, "separate", [&] { return separate_layers(burst, geometry, normals); });
    skin.black = compare_black(burst);
    forget_stripes(surface.burst);
    if (until < Step::kScattering) return;
    skin.scattering = timed(course, "scattering", [&] {
      return fit_scattering(burst, geometry, normals, use, &skin.separation);
    });
  };
  parallel_both(reflect, scatter);
  return skin;
}

void report_skin(Step until, const Skin& skin, LayeredFit* fit) {
  if (until >= Step::kSpecular) report_specular(skin.specular, fit);
  if (until >= Step::kSeparate) report_separation(skin.separation, fit);
  if (until >= Step::kScattering) report_scattering(skin.scattering, fit);
}

void run_steps(Step until, LayerUse use, Burst* burst, Course* course, LayeredFit* fit) {
  start_report(*burst, fit);
  if (until == Step::kLinearise) return;

  Geometry geometry = timed(course, "geometry", [&] { return take_geometry(burst); });
  require_surface(*burst, geometry);
  judge_size(*burst, geometry, fit);
  judge_right(geometry, fit);
  remove_pattern_extinction(geometry, burst);
  if (until == Step::kGeometry) {
    report_geometry(*burst, geometry, fit);
  } else {
    const Normals normals =
        timed(course, "normals", [&] { return take_normals(burst, &geometry); });
    report_normals(normals, fit);
    judge_full(normals.led_gains, fit);
    judge_surface(*burst, geometry, normals, fit);
    judge_facing(*burst, normals, fit);
    if (until >= Step::kRegions) {
      timed(course, "regions", [&] { return settle_regions(geometry, normals, burst); });
      report_regions(*burst, fit);
    }
    forget_gradients(burst);
    Skin skin;
    parallel_both(
        [&] {
          skin = fit_skin(until, use, {burst, geometry, normals}, course);
        },
        [&] { report_geometry(*burst, geometry, fit); });
    DotsSeen dots;
    if (until >= Step::kScattering) dots = look_for_dots(*burst, geometry);
    burst->dots.release();
    report_skin(until, skin, fit);
    if (until >= Step::kSeparate) judge_black(skin.black, fit);
    if (until >= Step::kSeparate) judge_stripes(*burst->session, skin.separation, fit);
    if (until >= Step::kScattering) judge_dots(*burst->session, dots, fit);
    if (until >= Step::kAlbedo) {
      const Albedo albedo =
          timed(course, "albedo", [&] { return fit_albedo(*burst, geometry, normals); });
      report_albedo(albedo, fit);
      judge_albedo(fit);
      const FittedLayers fitted{geometry, normals, skin.specular, skin.separation, albedo};
      const auto residuals = timed(course, "rerender", [&] { return rerender(*burst, fitted); });
      report_rerender(residuals, fit);
      judge_rerender(residuals, fit);
      judge_parallel(residuals, fit);
    }
  }
  judge_positions(*burst, fit);
}

// As asked, in blocks that still resolve the patterns.
Quality resolving_quality(const Session& session, const Quality& asked, LayeredFit* fit) {
  Quality quality = asked;
  quality.bin_px = resolving_bin_px(session, asked.bin_px);
  if (quality.bin_px == asked.bin_px) return quality;
  const PatternScale scale = pattern_scale(session);
  fit->notes.push_back(
      fmt::format("blocks of {0} x {0} pixels would not resolve the patterns (a period of the "
                  "stripes is {1:.2g} "
                  "pixels, a dot {2:.2g}): fitted {3}",
                  asked.bin_px, scale.stripe_px, scale.dot_px,
                  quality.bin_px == 1 ? "pixel by pixel"
                                      : fmt::format("in blocks of {0} x {0}", quality.bin_px)));
  return quality;
}

// Maps of patterns that no pixel resolves are not to be believed.
void distrust_unresolved(const Session& session, LayerMaps* maps) {
  const PatternScale scale = pattern_scale(session);
  const auto distrust = [&](const char* map) {
    const auto confidence = maps->confidence.find(map);
    if (confidence != maps->confidence.end()) confidence->second.setTo(0);
  };
  if (!resolves_stripes(scale)) {
    for (const char* map : {"shallow_albedo", "deep_albedo", "deep_alpha"}) distrust(map);
  }
  if (!resolves_dots(scale)) distrust("deep_ld");
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

LayeredFit fit_layers(const Session& session, Step until, LayerUse use, const Quality& asked,
                      const TriangleMesh* mesh) {
  LayeredFit fit;
  const Quality quality = resolving_quality(session, asked, &fit);
  Course course{.layers = &fit.layers, .progress = Progress("fitting, step", steps_until(until))};
  SubjectBurst subject;
  Burst burst = timed(&course, "linearise", [&] {
    subject = find_subject(session);
    return linearise(subject.session, mesh, std::move(subject.fronts));
  });
  burst.quality = quality;
  fit.check = burst.check;
  if (quality.bin_px == 1) {
    run_steps(until, use, &burst, &course, &fit);
  } else {
    Labels regions = burst.regions;
    const Session binned = binned_session(subject.session, quality.bin_px);
    burst =
        note_time(&fit.layers, "bin", [&] { return binned_burst(burst, binned, quality.bin_px); });
    run_steps(until, use, &burst, &course, &fit);
    note_time(&fit.layers, "unbin", [&] {
      if (!burst.has_given_regions) {
        regions = labels_of_pixels(burst.regions, quality.bin_px, regions > 0);
      }
      unbin_maps(regions, subject.session.left, quality.bin_px, &fit.maps);
      return 0;
    });
  }
  settle_confidence(&fit.maps);
  distrust_unresolved(session, &fit.maps);
  leave_out_unlabelled(subject.session.window("left"), &fit.maps);
  return fit;
}

}  // namespace lamella::fit
