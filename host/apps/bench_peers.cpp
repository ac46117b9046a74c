#include "apps/bench_peers.h"

#include <numeric>

#include "apps/bench_figures.h"
#include "apps/compare_folders.h"
#include "apps/process_child.h"
#include "apps/report.h"
#include "base/error.h"
#include "base/progress.h"
#include "calib/photographs.h"
#include "fit/dot_measure.h"
#include "fit/exponential_mixture.h"
#include "fit/layer_profile.h"
#include "fit/layered_kernel.h"
#include "io/json.h"
#include "io/layer_maps.h"
#include "io/whole_file.h"

namespace lamella::apps {

namespace {

// Of an installed program beside it, else of the source tree that it was built from.
fs::path peers_folder() {
  const fs::path installed = own_binary().parent_path().parent_path() / "share/lamella/peers";
  return fs::exists(installed) ? installed : fs::path(LAMELLA_PEERS_DIR);
}

constexpr int kModuleMissing = 3, kNoInterpreter = 127;

// The one that is found first, and Debian's, which has Debian's modules.
std::vector<std::vector<std::string>> interpreters() {
  return {{"/usr/bin/env", "python3"}, {"/usr/bin/python3"}};
}

// Runs a script of `peers_folder()`, which writes a fit into `out`. Returns why it could not,
// or nothing.
std::string run_script(const std::string& script, const fs::path& input, const fs::path& out) {
  const fs::path file = peers_folder() / script;
  if (!fs::exists(file)) return "peer scripts are not installed";
  std::string why;
  for (std::vector<std::string> arguments : interpreters()) {
    if (!fs::exists(arguments[0])) continue;
    fs::remove_all(out);
    fs::create_directory(out);
    arguments.insert(arguments.end(), {file.string(), input.string(), "--out", out.string()});
    ChildProcess child(script, arguments, out.parent_path());
    const int exit_code = child.wait();
    if (exit_code == 0) return "";
    why = child.last_words();
    if (why.empty()) why = "python3 ended with " + std::to_string(exit_code);
    if (exit_code != kModuleMissing && exit_code != kNoInterpreter) return why;
  }
  return why.empty() ? "no python3" : why;
}

double seconds_in(const v1::Layers& layers, const std::string& step) {
  const auto at = layers.timings_s().find(step);
  return at == layers.timings_s().end() ? 0 : at->second;
}

double all_seconds(const v1::Layers& layers) {
  double sum = 0;
  for (const auto& [step, seconds] : layers.timings_s()) sum += seconds;
  return sum;
}

// Of reading by itself what a fit reads, with nothing else to do meanwhile.
double seconds_of_reading(const Session& session) {
  const Stopwatch watch;
  read_photographs(session, frames_to_fit(session));
  return watch.seconds();
}

v1::Layers layers_of_lengths(const std::vector<std::string>& regions,
                             const std::vector<double>& ld_mm) {
  v1::Layers layers;
  layers.set_format("lamella.layers.v1");
  for (size_t i = 0; i < ld_mm.size(); ++i) {
    if (i % 3 == 0) layers.add_regions()->set_name(regions[i]);
    layers.mutable_regions(layers.regions_size() - 1)->mutable_deep()->add_ld_mm(ld_mm[i]);
  }
  return layers;
}

}  // namespace

// A program for every region with dots, red, green and blue.
struct PeerBench::Profiles {
  std::vector<std::string> regions;
  std::vector<fit::MixtureProgram> programs;
  std::vector<double> ld_mm;  // by our own solvers

  explicit Profiles(const Session& session) {
    const fit::Burst burst = fit::linearise(session);
    fit::Geometry geometry = fit::reconstruct_geometry(burst);
    const fit::Normals normals = fit::estimate_normals(burst, &geometry);
    const std::vector<fit::Dot> dots = fit::measure_dots(burst, geometry, normals);
    const cv::Mat1d exponentials =
        fit::blurred_exponentials(fit::footprint_mm(session.left, session.projector));
    for (size_t label = 1; label < burst.region_names.size(); ++label) {
      const fit::RegionEquations own = fit::equations_of_region(dots, int(label));
      if (own[0].empty() || own[1].empty() || own[2].empty()) continue;
      for (const auto& of_channel : own) {
        regions.push_back(burst.region_names[label]);
        programs.push_back(fit::mixture_program(fit::sum_of(of_channel), fit::kOffsetSigma,
                                                exponentials, fit::kTailSmoothness));
      }
    }
  }

  // Returns its seconds.
  double solve() {
    const Stopwatch watch;
    ld_mm.clear();
    for (const fit::MixtureProgram& program : programs) {
      ld_mm.push_back(fit::fit_deep_profile(fit::solve_program(program), {}).ld_mm);
    }
    return watch.seconds();
  }

  void write(const fs::path& file) const {
    constexpr int kSize = fit::ExponentialMixture::kSize;
    Json document{{"length_mm", Json::array()}, {"programs", Json::array()}};
    for (int k = 0; k < kSize; ++k) {
      document["length_mm"].push_back(fit::ExponentialMixture::length_mm(k));
    }
    for (size_t i = 0; i < programs.size(); ++i) {
      const auto& [a, b] = programs[i];
      Json rows = Json::array();
      for (int k = 0; k < kSize; ++k) rows.push_back(std::vector<double>(a[k], a[k] + kSize));
      document["programs"].push_back({{"region", printable(regions[i])},
                                      {"a", rows},
                                      {"b", std::vector<double>(b.begin(), b.end())}});
    }
    write_whole_text(file, document.dump());
  }
};

PeerBench::PeerBench(const Session& session, const fs::path& scratch)
    : session_(session),
      scratch_(scratch),
      peers_{{"NumPy", "the paper, step after step, against the whole fit", "", {}, {}, {}, {}},
             {"SciPy",
              "nnls and least_squares on the profiles of the dots, against ours on the same",
              "",
              {},
              {},
              {},
              {}}} {
  fs::create_directory(scratch);
}

PeerBench::~PeerBench() { fs::remove_all(scratch_); }

void PeerBench::run_round(const OurFit& ours) {
  if (peers_[0].missing.empty()) run_numpy(ours, &peers_[0]);
  if (peers_[1].missing.empty()) run_scipy(&peers_[1]);
}

void PeerBench::run_numpy(const OurFit& ours, Peer* peer) {
  const fs::path out = scratch_ / "numpy";
  peer->missing = run_script("numpy_fit.py", session_.path, out);
  if (!peer->missing.empty()) return;
  const v1::Layers layers = read_layers(out / "layers.json");
  const double all = all_seconds(layers);
  peer->its.all.push_back(all);
  peer->its.without_files.push_back(all - seconds_in(layers, "read") - seconds_in(layers, "write"));
  peer->ours.all.push_back(ours.seconds);
  peer->ours.without_files.push_back(ours.seconds - ours.writing_s - seconds_of_reading(session_));
  peer->figures = figures_of(compare_folders(out, session_.path / "truth"));
  peer->our_figures = ours.figures;
  fs::remove_all(out);
}

void PeerBench::run_scipy(Peer* peer) {
  if (!profiles_) profiles_ = std::make_unique<Profiles>(session_);
  if (profiles_->programs.empty()) {
    peer->missing = "no region has dots";
    return;
  }
  const fs::path out = scratch_ / "scipy", programs = scratch_ / "programs.json";
  profiles_->write(programs);
  peer->missing = run_script("scipy_profiles.py", programs, out);
  if (!peer->missing.empty()) return;
  peer->its.without_files.push_back(all_seconds(read_layers(out / "layers.json")));
  peer->ours.without_files.push_back(profiles_->solve());
  const fs::path truth = session_.path / "truth";
  peer->figures = figures_of(compare_folders(out, truth));
  write_json(out / "layers.json", layers_of_lengths(profiles_->regions, profiles_->ld_mm));
  peer->our_figures = figures_of(compare_folders(out, truth));
  fs::remove_all(out);
}

}  // namespace lamella::apps
