// lamella export: the fitted face as one .glb.
#include <cstdio>
#include <memory>

#include "apps/commands.h"
#include "export/export.h"
#include "io/fit_folder.h"

namespace lamella::apps {

namespace {

struct Arguments {
  fs::path session, fit, out;
  exporting::ExportOptions options;
};

void run(const Arguments& a) {
  const fs::path folder = a.fit.empty() ? a.session / "fit" : a.fit;
  const FitFolder fit = read_fit_folder(folder);
  const std::string subject = fs::absolute(a.session).lexically_normal().filename().string();
  const exporting::ExportReport report =
      exporting::export_face(fit.maps, fit.layers, subject, a.out, a.options);
  std::printf("%s: %zu triangles, %zu vertices, %.2f MB, %.2f s\n", a.out.c_str(), report.triangles,
              report.vertices, double(report.bytes) / 1e6, report.seconds);
}

}  // namespace

void add_export(CLI::App& app, int*) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("export", "write the fitted face as one .glb");
  command->add_option("session", a->session, "session folder")->required();
  command->add_option("--out", a->out, "the .glb to write")->required();
  command->add_option("--fit", a->fit, "folder of the fit; SESSION/fit where absent");
  command->add_option("--triangles", a->options.triangles, "at most, about")
      ->check(CLI::Range(100, 2000000));
  command->add_option("--texture-px", a->options.texture_side_px, "longest side of a texture")
      ->check(CLI::Range(16, 8192));
  command->callback([a] { run(*a); });
}

}  // namespace lamella::apps
