// lamella fit SESSION: from the photographs to the layers.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include "apps/bench_choice.h"
#include "apps/commands.h"
#include "apps/doubt_lines.h"
#include "apps/process_interrupt.h"
#include "apps/process_killed.h"
#include "apps/report.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "export/export.h"
#include "fit/layers.h"
#include "io/given_regions.h"
#include "io/json.h"
#include "io/mesh_file.h"
#include "io/whole_file.h"
#include "session.pb.h"

namespace lamella::apps {

namespace {

struct FitArguments {
  fs::path session, out, bench, mesh, regions;
  std::string until = "albedo", layers = "auto", quality = "standard";
  double budget_s = 0;
  std::string max_error;
  bool json = false;
  bool has_quality = false, has_budget = false, has_limit = false;
};

// By name, or out of what a bench measured on this machine.
fit::Quality quality_of(const FitArguments& args, const Session& session) {
  if (!args.has_budget && !args.has_limit) {
    if (!args.bench.empty()) {
      throw_bad_input("--bench", "nothing to choose by", "give --budget-s or --max-error too");
    }
    return fit::quality_from_name(args.quality);
  }
  if (args.has_quality) {
    throw_bad_input("--quality", "is chosen by --budget-s and --max-error", "leave it out");
  }
  if (args.bench.empty()) {
    throw_bad_input("--bench", "is needed by --budget-s and --max-error",
                    "give the bench.json of `lamella bench`");
  }
  std::optional<FigureLimit> limit;
  if (args.has_limit) limit = error_limit_from(args.max_error);
  v1::Bench table;
  read_json(args.bench, &table);
  const auto pixels = uint32_t(session.left.width * session.left.height);
  const BenchChoice choice =
      choose_setting(table, args.bench.string(), pixels,
                     args.has_budget ? std::optional(args.budget_s) : std::nullopt, limit);
  fmt::print(stderr, "lamella: fitting with {}, about {:.2g} s by {}\n",
             one_line(choice.quality.name), choice.seconds, args.bench.string());
  return choice.quality;
}

// Of layers that were dropped, or are in doubt: not of those that were kept.
void print_reasons(const v1::Layers& layers) {
  std::string lines;
  for (const v1::Region& r : layers.regions()) {
    const std::map<std::string, std::string> by_layer(r.layers().why().begin(),
                                                      r.layers().why().end());
    for (const auto& [layer, why] : by_layer) {
      if (why.starts_with("kept: ")) continue;
      lines += one_line(fmt::format("{}: {}: {}", r.name(), layer, why)) + "\n";
    }
  }
  if (!lines.empty()) fmt::print("\n{}", lines);
}

std::string end_of_motion(const v1::Motion& motion) {
  if (!motion.mended()) return "left as it is, as " + motion.why();
  return motion.why().empty() ? "mended" : "mended in part, as " + motion.why();
}

// At rest, a line; else where it was at each photograph.
void print_motion(const v1::Motion& motion) {
  if (motion.frames_size() == 0) {
    fmt::print("\nsubject's motion during the burst: not known, as {}\n", motion.why());
    return;
  }
  fmt::print(
      "\nsubject's motion during the burst, across the left camera's axis: "
      "{:.3f} +- {:.3f} mm ({:.2f} px): {}\n",
      motion.moved_mm(), motion.moved_mm_stddev(), motion.moved_px(), end_of_motion(motion));
  if (!motion.mended()) return;
  fmt::print("{:<24} {:>8} {:>23} {:>15}\n", "photograph", "time (s)", "moved x y z (mm)",
             "x y (px)");
  for (const v1::FrameMotion& f : motion.frames()) {
    fmt::print("{:<24} {:>8.3f}   {:>6} {:>6} {:>6}   {:>6} {:>6}\n", f.frame(),
               f.trigger_us() * 1e-6, decimals(f.moved_mm(0), 3), decimals(f.moved_mm(1), 3),
               decimals(f.moved_mm(2), 3), decimals(f.moved_px(0), 2), decimals(f.moved_px(1), 2));
  }
}

std::string signed_decimals(double value, int digits) {
  const std::string text = decimals(value, digits);
  return text.front() == '-' ? text : "+" + text;
}

void print_led_gains(const v1::LedGains& gains) {
  fmt::print("LEDs against their calibration:");
  if (gains.gradient_size() != 3) {
    fmt::print(" not known, as {}\n", gains.why());
    return;
  }
  for (int a = 0; a < 3; ++a) {
    fmt::print(" {} {} +- {:.2f} %,", "XYZ"[a], signed_decimals(100 * gains.gradient(a), 2),
               100 * gains.gradient_stddev(a));
  }
  int largest = 0;
  for (int i = 1; i < gains.low_order_size(); ++i) {
    if (std::abs(gains.low_order(i)) > std::abs(gains.low_order(largest))) largest = i;
  }
  fmt::print(
      " gradients over full: {}; largest low order over the sphere {} +- {:.1f} %; "
      "errors of single LEDs are not observable\n",
      gains.mended() ? "what is beyond three sigmas is mended" : "left as they are",
      signed_decimals(100 * gains.low_order(largest), 1), 100 * gains.low_order_stddev(largest));
}

// Of three channels; a dash where they are not known.
std::string three(const google::protobuf::RepeatedField<double>& values, int digits) {
  if (values.size() != 3) return "-";
  return decimals(values[0], digits) + " " + decimals(values[1], digits) + " " +
         decimals(values[2], digits);
}

std::string single_words(const v1::Region& region) {
  if (!region.has_single()) return "-";
  return region.layers().single() ? three(region.single().amplitude(), 4) : "not fitted";
}

void print_summary(const v1::Layers& layers, const fs::path& out, double total_s) {
  size_t width = 12;
  for (const v1::Region& r : layers.regions()) width = std::max(width, one_line(r.name()).size());
  fmt::print("{:<{}} {:>7} {:>17} {:>23} {:>23}\n", "region", width, "m (rad)", "l_d r g b (mm)",
             "alpha_dot r g b", "single r g b");
  for (const v1::Region& r : layers.regions()) {
    const bool has_lobe = r.has_specular() && r.specular().has_gaussian_m();
    fmt::print("{:<{}} {:>7} {:>17} {:>23} {:>23}\n", one_line(r.name()), width,
               has_lobe ? decimals(r.specular().gaussian_m(), 3) : "-", three(r.deep().ld_mm(), 2),
               three(r.deep().alpha_dot(), 4), single_words(r));
  }
  print_reasons(layers);
  print_motion(layers.motion());
  if (layers.has_led_gains()) print_led_gains(layers.led_gains());
  if (layers.has_one_layer()) fmt::print("layers of the skin: {}\n", layers.one_layer().why());
  fmt::print("\nwrote {} in {:.2f} s\n", out.string(), total_s);
}

// A figure at its bound is a figure still, and its deviation says what it is worth; a layer that
// could not be judged is one that was asked for and is not there.
void put_warnings(const Session& session, fit::LayeredFit* fit) {
  const auto put = [&](const std::string& text, bool is_below) {
    v1::Warning* warning = fit->layers.add_warnings();
    warning->set_text(one_line(text));
    warning->set_below_quality_asked(is_below);
  };
  for (const std::string& warning : session.warnings) put(warning, false);
  for (const std::string& note : fit->notes) put(note, false);
  for (const CheckLine& line : fit->check.lines) {
    if (line.grade == Grade::kPoor) put(line.name + ": " + line.text, true);
  }
  for (const DoubtLine& line : doubt_lines(fit->doubted)) {
    put(line.text, line.doubt == fit::Doubt::kNotJudged);
  }
}

// Those of the manifest were told before the fit. Returns whether any is below the quality asked.
bool tell_warnings(const v1::Layers& layers, size_t told) {
  bool any = false;
  for (int i = int(told); i < layers.warnings_size(); ++i) {
    const v1::Warning& warning = layers.warnings(i);
    fmt::print(stderr, "lamella: warning: {}{}\n",
               warning.below_quality_asked() ? "below the quality asked: " : "", warning.text());
    any = any || warning.below_quality_asked();
  }
  return any;
}

// As session.json has them, and `fit --regions` takes them back.
v1::Regions names_of_regions(const v1::Layers& layers) {
  v1::Regions regions;
  regions.set_file("regions.png");
  regions.add_names("background");
  for (const v1::Region& region : layers.regions()) regions.add_names(region.name());
  return regions;
}

void write_fit(WholeFolder* folder, const Session& session, const Stopwatch& watch,
               fit::LayeredFit* fit) {
  const Stopwatch write_watch;
  const bool whole = !fit->maps.total_albedo.empty();
  parallel_both([&] { write_layer_maps(folder->path(), fit->maps); },
                [&] {
                  if (!whole) return;
                  exporting::export_face(fit->maps, fit->layers, session.subject,
                                         folder->path() / "model.glb");
                });
  auto& timings = *fit->layers.mutable_timings_s();
  timings["write"] = write_watch.seconds();
  timings["total"] = watch.seconds();
  write_json(folder->path() / "regions.json", names_of_regions(fit->layers));
  write_json(folder->path() / "layers.json", fit->layers);
  folder->commit();
}

// What the fit replaces is gone before it is read.
void require_outside(const fs::path& file, const fs::path& out, const std::string& what) {
  if (lies_in(file, out)) {
    throw_bad_input(file.string(), "is in the folder that the fit replaces",
                    "give another --out, or copy the " + what);
  }
}

// The subject's shape, where it is given.
std::optional<TriangleMesh> mesh_of(const FitArguments& args, const fs::path& out) {
  if (args.mesh.empty()) return std::nullopt;
  require_outside(args.mesh, out, "mesh");
  return read_mesh(args.mesh);
}

void take_regions(const FitArguments& args, const fs::path& out, Session* session) {
  if (args.regions.empty()) return;
  require_outside(args.regions, out, "image, and the .json beside it");
  give_regions(args.regions, session);
}

int run_fit(const FitArguments& args) {
  const Stopwatch watch;
  abandon_outputs_on_interrupt();
  Session session = read_session(args.session);
  for (const std::string& warning : session.warnings) {
    fmt::print(stderr, "lamella: warning: {}\n", one_line(warning));
  }
  const fs::path out = args.out.empty() ? session.path / "fit" : args.out;
  if (fs::exists(out / "kernels.npz")) {
    throw_bad_input(out.string(), "is the truth about a subject, not a fit",
                    "choose another place");
  }
  const fit::Quality quality = quality_of(args, session);
  const std::optional<TriangleMesh> mesh = mesh_of(args, out);
  take_regions(args, out, &session);
  clear_half_written_beside(out);
  WholeFolder folder(out, "layers.json");
  fit::LayeredFit fit =
      fit::fit_layers(session, fit::step_from_name(args.until),
                      fit::layer_use_from_name(args.layers), quality, mesh ? &*mesh : nullptr);
  if (mesh && fit.layers.has_geometry()) {
    fit.layers.mutable_geometry()->set_mesh(printable(args.mesh.string()));
  }
  put_warnings(session, &fit);
  folder.blame_place([&] { write_fit(&folder, session, watch, &fit); });
  if (args.json) {
    fmt::print("{}\n", to_json(fit.layers));
  } else {
    print_summary(fit.layers, out, watch.seconds());
  }
  std::fflush(stdout);
  return tell_warnings(fit.layers, session.warnings.size()) ? 1 : 0;
}

}  // namespace

void add_fit(const Command& app, int* exit_code) {
  auto args = std::make_shared<FitArguments>();
  const Command command = app.add_command("fit", "Fit the layers of a session");
  command.add_option("session", args->session, "Session folder").required();
  command.add_option("--out", args->out, "Folder to write [SESSION/fit]");
  command.add_option("--mesh", args->mesh,
                     "The subject's shape, instead of the fringes': .ply or .obj in mm, .glb in "
                     "metres, in the rig's frame");
  command.add_option("--regions", args->regions,
                     "Label image instead of the session's: 8-bit grey .png, 0 background, named "
                     "by the .json beside it: those of a fit, edited");
  command
      .add_option("--until", args->until,
                  "Last step to run: linearise, geometry, normals, regions, specular, separate, "
                  "scattering, albedo")
      .shows_default();
  command
      .add_option("--layers", args->layers,
                  "Diffuse layers: auto, those whose light is above the noise; single, one dipole "
                  "for all of it")
      .shows_default();
  command
      .add_option("--quality", args->quality,
                  "What to spend: draft, on blocks of 2 x 2 pixels where these resolve the stripes "
                  "and dots; standard; reference")
      .shows_default();
  command
      .add_option("--budget-s", args->budget_s,
                  "Seconds that the fit may take: the settings of least error within them")
      .within(0.001, 1e6);
  command.add_option("--max-error", args->max_error,
                     "FIGURE<=VALUE, FIGURE a column of bench.csv: the quickest settings");
  command.add_option("--bench", args->bench,
                     "What --budget-s and --max-error choose by: bench.json");
  command.add_flag("--json", args->json, "Report as JSON: layers.json");
  command.runs([args, exit_code, command] {
    args->has_quality = command.given("--quality");
    args->has_budget = command.given("--budget-s");
    args->has_limit = command.given("--max-error");
    *exit_code = run_fit(*args);
  });
}

}  // namespace lamella::apps
