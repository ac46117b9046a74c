// lamella export: the fitted face as one .glb.
#include <fmt/format.h>

#include <memory>
#include <optional>

#include "apps/commands.h"
#include "apps/output_place.h"
#include "apps/process_interrupt.h"
#include "apps/report.h"
#include "export/export.h"
#include "export/for_view.h"
#include "io/fit_folder.h"
#include "io/session.h"

namespace lamella::apps {

namespace {

struct ExportArguments {
  fs::path session, fit, out, scene;
  exporting::ExportOptions options;
  bool has_triangles = false, has_texture_px = false;
  bool json = false;
};

// What was asked for by name wins.
exporting::ExportOptions options_for(const ExportArguments& a,
                                     const exporting::ViewChoice& choice) {
  exporting::ExportOptions options = exporting::options_for_view(choice, a.options);
  if (a.has_triangles) options.triangles = a.options.triangles;
  if (a.has_texture_px) options.texture_side_px = a.options.texture_side_px;
  return options;
}

nlohmann::json choice_as_json(const exporting::ViewChoice& choice,
                              const exporting::ExportOptions& options) {
  nlohmann::json layers = nlohmann::json::array();
  for (const exporting::LayerChoice& c : choice.layers) {
    layers.push_back({{"layer", c.layer},
                      {"kept", c.is_kept},
                      {"radius_mm", c.radius_mm},
                      {"radius_px", c.radius_px},
                      {"why", c.why}});
  }
  return {{"face_px", {choice.face_px.width, choice.face_px.height}},
          {"px_per_mm", choice.px_per_mm},
          {"triangles", options.triangles},
          {"texture_px", options.texture_side_px},
          {"layers", layers}};
}

void print_choice(const ExportArguments& a, const exporting::ViewChoice& choice,
                  const exporting::ExportOptions& options) {
  fmt::print(
      "for {}: the face is {:.0f} x {:.0f} px, {:.2f} px/mm; {} triangles{}, textures of {} "
      "px{}\n",
      a.scene.string(), choice.face_px.width, choice.face_px.height, choice.px_per_mm,
      options.triangles, a.has_triangles ? " as asked" : "", options.texture_side_px,
      a.has_texture_px ? " as asked" : "");
  for (const exporting::LayerChoice& c : choice.layers) {
    fmt::print("  {} {}: light travels up to {:.2f} mm = {:.2f} px; {}\n",
               c.is_kept ? "kept    " : "left out", c.layer, c.radius_mm, c.radius_px, c.why);
  }
}

void run(const ExportArguments& a) {
  const fs::path folder = a.fit.empty() ? a.session / "fit" : a.fit;
  abandon_outputs_on_interrupt();
  prepare_output(a.out, ".glb", {a.session, folder, a.scene});
  const FitFolder fit = read_fit_folder(folder);
  const std::string subject =
      printable(fs::absolute(a.session).lexically_normal().filename().string());
  exporting::ExportOptions options = a.options;
  v1::Layers layers = fit.layers;
  std::optional<exporting::ViewChoice> choice;
  if (!a.scene.empty()) {
    const View view = read_view(a.scene, read_session(a.session).stage.leds().size());
    choice = exporting::choose_for_view(fit.maps, fit.layers, view, a.scene.string());
    options = options_for(a, *choice);
    layers = exporting::kept_layers(fit.layers, *choice);
  }
  const exporting::ExportReport report =
      exporting::export_face(fit.maps, layers, subject, a.out, options);
  if (a.json) {
    nlohmann::ordered_json json = {{"file", a.out.string()},
                                   {"triangles", report.triangles},
                                   {"vertices", report.vertices},
                                   {"bytes", report.bytes},
                                   {"seconds", report.seconds}};
    if (choice) json["for"] = choice_as_json(*choice, options);
    print_json(json);
    return;
  }
  if (choice) print_choice(a, *choice, options);
  fmt::print("wrote {}: {} triangles, {} vertices, {:.2f} MB in {:.2f} s\n", a.out.string(),
             report.triangles, report.vertices, double(report.bytes) / 1e6, report.seconds);
}

}  // namespace

void add_export(const Command& app, int*) {
  auto a = std::make_shared<ExportArguments>();
  const Command command = app.add_command("export", "Write a fitted face as one .glb");
  command.add_option("session", a->session, "Session folder").required();
  command.add_option("--out", a->out, "The .glb to write").required();
  command.add_option("--fit", a->fit, "Folder of the fit [SESSION/fit]");
  command.add_option("--for", a->scene,
                     "View file: only what this camera can show, and a report of it");
  command.add_option("--triangles", a->options.triangles, "At most, about")
      .within(100, 2000000)
      .shows_default();
  command
      .add_option("--texture-px", a->options.texture_side_px, "Longest side of a texture, pixels")
      .within(16, 8192)
      .shows_default();
  command.add_flag("--json", a->json, "Report as JSON");
  command.runs([a, command] {
    a->has_triangles = command.given("--triangles");
    a->has_texture_px = command.given("--texture-px");
    run(*a);
  });
}

}  // namespace lamella::apps
