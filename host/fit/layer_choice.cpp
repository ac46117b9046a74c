#include "fit/layer_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "fit/jackknife.h"

namespace lamella::fit {

namespace {

constexpr int kParts = 4;
constexpr double kLeastCost = 1e-9;
constexpr double kUnknownSpread = 0.2;  // relative, of figures from dots too few to tell it

struct GainSpread {
  double mean = 0, stddev = 0;  // of the mean
};

GainSpread spread_of(const std::vector<double>& values) {
  GainSpread spread;
  const double count = double(values.size());
  for (double v : values) spread.mean += v / count;
  double square = 0;
  for (double v : values) square += (v - spread.mean) * (v - spread.mean);
  if (values.size() > 1) spread.stddev = std::sqrt(square / (count * (count - 1)));
  return spread;
}

// Of figures that leave out one part each: the parts' share of the whole spread.
double jackknife(const std::vector<double>& values, double whole) {
  if (values.size() < 2) return kUnknownSpread * whole;
  return jackknife_stddev(values);
}

// Root mean square difference, weighted by the light of a ring.
double rms_between(const SingleKernel& one, const LayeredKernel& both) {
  constexpr int kRings = 32;
  constexpr double kNear_mm = 0.1, kFar_mm = 8;
  double square = 0, light = 0;
  for (int i = 0; i < kRings; ++i) {
    const double r = kNear_mm * std::pow(kFar_mm / kNear_mm, i / (kRings - 1.0));
    const double off = r * r * (one(r) - both(r));
    square += off * off / kRings;
    light += r * r * both(r) / kRings;
  }
  return std::sqrt(square) / light;
}

// Of each channel and part.
std::vector<double> gains_of(const std::array<LayerContest, 3>& channels) {
  std::vector<double> gain;
  for (const LayerContest& channel : channels) {
    gain.insert(gain.end(), channel.gain.begin(), channel.gain.end());
  }
  return gain;
}

}  // namespace

LayerUse layer_use_from_name(const std::string& name) {
  if (name == "auto") return LayerUse::kAuto;
  if (name == "single") return LayerUse::kSingle;
  throw_bad_input("--layers", "no choice \"" + name + "\"", "one of auto, single");
}

LayerContest contest_layers(const std::vector<const KernelEquations*>& dots,
                            const LayeredKernel& both, double offset_sigma, double footprint_mm) {
  const KernelEquations all = sum_of(dots);
  const double ld_mm = both.deep_ld_mm;
  const SingleKernel one =
      fit_single_kernel(WeightEquations(all, offset_sigma), ld_mm, footprint_mm);
  LayerContest contest;
  std::vector<double> lengths, alphas;
  const size_t parts = std::min<size_t>(kParts, dots.size());
  for (size_t part = 0; parts > 1 && part < parts; ++part) {
    KernelEquations left_out;
    for (size_t i = part; i < dots.size(); i += parts) left_out += *dots[i];
    KernelEquations rest = all;
    rest += left_out.scaled(-1);
    const WeightEquations known(rest, offset_sigma), unseen(left_out, offset_sigma);
    const SingleKernel one_here = refine_single_kernel(known, one, footprint_mm);
    const LayeredKernel both_here = refine_layered_kernel(known, both, footprint_mm);
    const double by_one = prediction_cost(unseen, one_here, ld_mm, footprint_mm);
    const double by_both = prediction_cost(unseen, both_here, ld_mm, footprint_mm);
    contest.gain.push_back((by_one - by_both) / std::max({by_one, by_both, kLeastCost}));
    lengths.push_back(one_here.ld_mm);
    alphas.push_back(model::alpha_from_s(one_here.s));
  }
  contest.single = {one.ld_mm, jackknife(lengths, one.ld_mm), model::alpha_from_s(one.s),
                    jackknife(alphas, 1 - model::alpha_from_s(one.s)), rms_between(one, both)};
  return contest;
}

std::string describe_contest(const std::array<LayerContest, 3>& channels) {
  const std::vector<double> gain = gains_of(channels);
  if (gain.empty()) return "one dot is too few to compare both layers with one dipole";
  const GainSpread spread = spread_of(gain);
  return fmt::format(
      "both layers foresee dots that were left out with {:.0f} +- {:.0f} % {} error (squared) than "
      "one dipole",
      100 * std::abs(spread.mean), 100 * spread.stddev, spread.mean < 0 ? "more" : "less");
}

std::string reason_to_keep(const std::array<LayerContest, 3>& channels, double shallow_share) {
  const GainSpread spread = spread_of(gains_of(channels));
  const bool is_borne_out = spread.mean > spread.stddev;
  return fmt::format("kept: the stripes show {:.0f} % of its diffuse light as shallow, and {}{}",
                     100 * shallow_share,
                     is_borne_out ? "" : "the dots do not decide: ", describe_contest(channels));
}

}  // namespace lamella::fit
