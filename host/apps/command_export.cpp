// lamella export: the fitted face as one .glb.
#include <fmt/format.h>

#include <memory>

#include "apps/commands.h"
#include "apps/report.h"
#include "export/export.h"
#include "io/fit_folder.h"

namespace lamella::apps {

namespace {

struct Arguments {
  fs::path session, fit, out;
  exporting::ExportOptions options;
  bool json = false;
};

void run(const Arguments& a) {
  const fs::path folder = a.fit.empty() ? a.session / "fit" : a.fit;
  const FitFolder fit = read_fit_folder(folder);
  const std::string subject = fs::absolute(a.session).lexically_normal().filename().string();
  const exporting::ExportReport report =
      exporting::export_face(fit.maps, fit.layers, subject, a.out, a.options);
  if (a.json) {
    print_json({{"file", a.out.string()},
                {"triangles", report.triangles},
                {"vertices", report.vertices},
                {"bytes", report.bytes},
                {"seconds", report.seconds}});
  } else {
    fmt::print("wrote {}: {} triangles, {} vertices, {:.2f} MB in {:.2f} s\n", a.out.string(),
               report.triangles, report.vertices, double(report.bytes) / 1e6, report.seconds);
  }
}

}  // namespace

void add_export(CLI::App& app, int*) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("export", "Write a fitted face as one .glb");
  command->add_option("session", a->session, "Session folder")->required();
  command->add_option("--out", a->out, "The .glb to write")->required();
  command->add_option("--fit", a->fit, "Folder of the fit [SESSION/fit]");
  command->add_option("--triangles", a->options.triangles, "At most, about")
      ->check(CLI::Range(100, 2000000));
  command
      ->add_option("--texture-px", a->options.texture_side_px, "Longest side of a texture, pixels")
      ->check(CLI::Range(16, 8192));
  command->add_flag("--json", a->json, "Report as JSON");
  command->callback([a] { run(*a); });
}

}  // namespace lamella::apps
