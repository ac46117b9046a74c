// lamella compare A B: two images, or a fit against the truth.
#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <memory>
#include <sstream>

#include "apps/commands.h"
#include "apps/compare_folders.h"
#include "apps/compare_images.h"
#include "apps/report.h"
#include "base/error.h"

namespace lamella::apps {

namespace {

struct CompareArguments {
  std::string found, truth, mask;
  std::vector<std::string> requirements;
  bool json = false;
};

struct Requirement {
  FigureLimit limit;
  double value = 0;  // once it is looked up
};

// The part of that name; list elements by number, from 0. nullptr where there is none.
const Json* part_of(const Json& whole, const std::string& name) {
  if (whole.is_object()) return whole.contains(name) ? &whole[name] : nullptr;
  size_t index = 0;
  const char* end = name.data() + name.size();
  const auto [at, failed] = std::from_chars(name.data(), end, index);
  const bool is_number = failed == std::errc() && at == end;
  return whole.is_array() && is_number && index < whole.size() ? &whole[index] : nullptr;
}

// The figure at a dotted path; NaN where the report has it as not known.
double figure_at(const Json& figures, const std::string& name) {
  const Json* figure = &figures;
  std::istringstream parts(name);
  for (std::string part; figure && std::getline(parts, part, '.');) {
    figure = part_of(*figure, part);
  }
  if (!figure || !(figure->is_number() || figure->is_null())) {
    throw_bad_input("--require", "no figure \"" + name + "\"", "see the names in --json");
  }
  return figure->is_number() ? figure->get<double>() : double(kNaN);
}

// The pixels of `mask`, or all, at which the truth is a number; says how many others there are.
Mask comparable_pixels(const CompareArguments& arguments, const Image3& truth, const Mask& mask) {
  Mask counts = mask.empty() ? Mask(truth.size(), 255) : mask.clone();
  const int wanted = cv::countNonZero(counts);
  for (int y = 0; y < truth.rows; ++y) {
    for (int x = 0; x < truth.cols; ++x) {
      if (!is_finite(truth(y, x))) counts(y, x) = 0;
    }
  }
  const int compared = cv::countNonZero(counts);
  if (wanted == 0) throw_bad_input(arguments.mask, "leaves no pixel to compare", "0 is left out");
  if (compared == 0)
    throw_bad_input(arguments.truth, "has no number where it is compared",
                    "give a map of the truth, or another --mask");
  if (compared < wanted) {
    fmt::print(stderr, "lamella: warning: {}: {:.1f} % of the pixels are no numbers and left out\n",
               one_line(arguments.truth), 100 * (1 - double(compared) / wanted));
  }
  return counts;
}

Json compare_pictures(const CompareArguments& arguments) {
  const Image3 found = read_exr_rgb(arguments.found), truth = read_exr_rgb(arguments.truth);
  if (found.size() != truth.size()) {
    throw_bad_input(arguments.found, fmt::format("is {}x{}, {} is {}x{}", found.cols, found.rows,
                                                 arguments.truth, truth.cols, truth.rows));
  }
  Mask mask;
  if (!arguments.mask.empty()) mask = read_mask(arguments.mask, truth.size());
  return image_figures(found, truth, comparable_pixels(arguments, truth, mask));
}

std::string picture_table(const Json& f) {
  return fmt::format(
      "relative RMSE {:>9.2f} %\n  at best scale {:>7.2f} %  (times {:.4f})\n"
      "PSNR {:>18.2f} dB\n",
      100 * f["rel_rmse"].get<double>(), 100 * f["rel_rmse_best_scale"].get<double>(),
      f["best_scale"].get<double>(), f["psnr_srgb_db"].get<double>());
}

// How many requirements are not met; each is told on stderr.
int broken(const std::vector<Requirement>& requirements) {
  int count = 0;
  for (const Requirement& r : requirements) {
    if (r.value <= r.limit.value) continue;
    fmt::print(stderr, "lamella: {} is {:.6g}, asked for {:.6g} at most\n", r.limit.figure, r.value,
               r.limit.value);
    ++count;
  }
  return count;
}

// What keeps a fit from being compared whole; each is told on stderr.
bool has_problems(const Json& figures) {
  if (!figures.contains("problems")) return false;
  for (const Json& problem : figures["problems"]) {
    fmt::print(stderr, "lamella: {}\n", one_line(problem.get<std::string>()));
  }
  return !figures["problems"].empty();
}

int run_compare(const CompareArguments& arguments) {
  std::vector<Requirement> requirements;
  for (const std::string& text : arguments.requirements) {
    requirements.push_back(
        {figure_limit_from(text, "--require", "views.point_side.rel_rmse<=0.15")});
  }
  for (const std::string& path : {arguments.found, arguments.truth}) {
    if (!fs::exists(path))
      throw_bad_input(path, "no such file or folder", "give two images, or a fit and its truth");
  }
  const bool folders = fs::is_directory(arguments.found);
  if (folders != fs::is_directory(arguments.truth)) {
    throw_bad_input(arguments.truth, "a folder and a file cannot be compared",
                    "give two folders or two images");
  }
  if (folders && !arguments.mask.empty()) {
    throw_bad_input("--mask", "is for two images", "folders have their regions.png");
  }
  const Json figures =
      folders ? compare_folders(arguments.found, arguments.truth) : compare_pictures(arguments);
  // Before the report: whoever misspelt one is not to take it for the answer.
  for (Requirement& r : requirements) r.value = figure_at(figures, r.limit.figure);
  if (arguments.json) {
    print_json(figures);
  } else {
    fmt::print("{}", folders ? shown(comparison_table(figures)) : picture_table(figures));
  }
  std::fflush(stdout);
  const bool below = broken(requirements) > 0;
  return has_problems(figures) || below ? 1 : 0;
}

}  // namespace

void add_compare(const Command& app, int* exit_code) {
  auto arguments = std::make_shared<CompareArguments>();
  const Command command =
      app.add_command("compare", "Recovered against true: two EXR images, or fit/ against truth/");
  command.add_option("recovered", arguments->found, "Image or folder of maps").required();
  command.add_option("true", arguments->truth, "What it should be").required();
  command.add_option("--mask", arguments->mask, "PNG: compare images where it is not 0");
  command.add_option(
      "--require", arguments->requirements,
      "FIGURE<=VALUE, as rel_rmse<=0.1, with a name of --json: exit 1 where it does not "
      "hold. Repeatable");
  command.add_flag("--json", arguments->json, "Report as JSON: every figure");
  command.runs([arguments, exit_code] { *exit_code = run_compare(*arguments); });
}

}  // namespace lamella::apps
