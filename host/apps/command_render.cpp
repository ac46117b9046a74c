#include <cstdio>
#include <memory>

#include "apps/commands.h"
#include "base/progress.h"
#include "render/render.h"

namespace lamella::apps {

namespace {

struct RenderArguments {
  std::string session, view, out, fit;
};

void run_render(const RenderArguments& arguments) {
  const fs::path fit =
      arguments.fit.empty() ? fs::path(arguments.session) / "fit" : fs::path(arguments.fit);
  const Stopwatch watch;
  const render::Subject subject = render::load_subject(arguments.session, fit);
  const View view = read_view(arguments.view, subject.stage.leds().size());
  const Image3 image = render::render_view(subject, view);
  write_exr_rgb(arguments.out, image, PixelType::kHalf);
  std::fprintf(stderr, "%s: %dx%d in %.1f s\n", arguments.out.c_str(), image.cols, image.rows,
               watch.seconds());
}

}  // namespace

void add_render(CLI::App& app, int*) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command =
      app.add_subcommand("render", "Draw a fitted face at a new view and light (S + D).");
  command->add_option("session", arguments->session, "Session folder")->required();
  command->add_option("--view", arguments->view, "View file: a camera and its lights")->required();
  command->add_option("--out", arguments->out, "Image to write (EXR)")->required();
  command->add_option("--fit", arguments->fit, "Folder of maps [SESSION/fit]");
  command->callback([arguments] { run_render(*arguments); });
}

}  // namespace lamella::apps
