// lamella render: a fitted face at a view and a light that no photograph had.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "apps/commands.h"
#include "apps/output_place.h"
#include "apps/process_interrupt.h"
#include "apps/report.h"
#include "base/progress.h"
#include "render/render.h"

namespace lamella::apps {

namespace {

struct RenderArguments {
  fs::path session, view, out, fit;
  bool json = false;
};

// A face in the dark and one out of sight look alike.
bool is_black(const Image3& image) { return cv::norm(image, cv::NORM_INF) == 0; }

int run_render(const RenderArguments& arguments) {
  const fs::path fit = arguments.fit.empty() ? arguments.session / "fit" : arguments.fit;
  const Stopwatch watch;
  abandon_outputs_on_interrupt();
  prepare_output(arguments.out, ".exr", {arguments.session, fit, arguments.view});
  const render::Subject subject = render::load_subject(arguments.session, fit);
  const View view = read_view(arguments.view, subject.stage.leds().size());
  const Image3 image = render::render_view(subject, view);
  write_exr_rgb(arguments.out, image, PixelType::kHalf);
  if (arguments.json) {
    print_json({{"file", arguments.out.string()},
                {"width", image.cols},
                {"height", image.rows},
                {"seconds", watch.seconds()}});
  } else {
    fmt::print("wrote {}: {} pixels in {:.2f} s\n", arguments.out.string(),
               size_words(image.size()), watch.seconds());
  }
  if (!is_black(image)) return 0;
  std::fflush(stdout);
  fmt::print(stderr,
             "lamella: warning: below the quality asked: {}: the picture is black: its camera sees "
             "nothing of the face, or its lights reach nothing of what it sees\n",
             one_line(arguments.view.string()));
  return 1;
}

}  // namespace

void add_render(const Command& app, int* exit_code) {
  auto arguments = std::make_shared<RenderArguments>();
  const Command command =
      app.add_command("render", "Draw a fitted face from a new camera in a new light");
  command.add_option("session", arguments->session, "Session folder").required();
  command.add_option("--view", arguments->view, "View file (JSON): a camera and its lights")
      .required();
  command.add_option("--out", arguments->out, "Image to write (EXR)").required();
  command.add_option("--fit", arguments->fit, "Folder of the fit [SESSION/fit]");
  command.add_flag("--json", arguments->json, "Report as JSON");
  command.runs([arguments, exit_code] { *exit_code = run_render(*arguments); });
}

}  // namespace lamella::apps
