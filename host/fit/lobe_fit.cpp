#include "fit/lobe_fit.h"

#include <fmt/core.h>

#include <algorithm>

#include "fit/non_negative.h"
#include "model/lobe.h"

namespace lamella::fit {

namespace {

constexpr int kUnknowns = int(kWidths) + 3;  // mixture, then an amplitude a channel
constexpr float kLobeModelError = 0.1f;      // of the lobe itself: keeps the peak from ruling
constexpr float kConeCosine = 0.70710678f;   // 45 degrees, as in the paper
constexpr int kEnoughInCone = 200;           // samples that make a lobe of their own
constexpr double kBorrowedSpread = 0.2;      // relative: how regions differ from the whole face
constexpr double kBorrowed = 0.5;            // samples' worth of the whole face in every region
constexpr double kSharedError = 1.6;         // of a lobe, over what the jackknife sees
constexpr double kTileSingleError = 0.02;    // relative, that no tile shows
constexpr double kTileLobeError = 0.01;      // the same of a lobe
constexpr double kLobeTailError = 0.0005;    // of its peak: what errors of the normals spread of it
constexpr double kScaleSigma = 0.02;         // of the lobe's integral, 1 by definition
constexpr float kPeakCosine = 0.98480775f;   // 10 degrees
constexpr int kEnoughAtPeak = 5;             // samples within them
constexpr double kTypicalWidth = 0.3;        // of a forehead
constexpr double kTypicalSingle = 0.06;      // amplitude of skin, about the same in all channels
constexpr double kTooMuchSingle = 3;         // times the typical: more than any skin has
// Mean of squares of sigmas, three of them. Not their sum: what is wrong with the surface's white
// light is the same in every channel.
constexpr double kSeen = 9;
constexpr double kSurelySeen = 25;      // five: three of them are still seen with 98 %
constexpr double kLobeInSingle = 0.05;  // of the typical: a lobe that is a little wrong leaves this

struct Equations {
  cv::Matx<double, kUnknowns, kUnknowns> m;
  cv::Vec<double, kUnknowns> b;
  int samples = 0, in_cone = 0, at_peak = 0;

  void add(const Equations& other, double weight) {
    m += other.m * weight;
    b += other.b * weight;
    samples += int(other.samples * weight);
    in_cone += int(other.in_cone * weight);
    at_peak += int(other.at_peak * weight);
  }
};

using Blocks = std::array<Equations, kBlocks>;

Equations total(const Blocks& blocks) {
  Equations sum;
  for (const Equations& block : blocks) sum.add(block, 1);
  return sum;
}

// c of one sample and its variance, from GRADIENT_FULL. Not clamped: noise has both signs.
struct Intensity {
  double c = 0, variance = 0;
};

Intensity intensity_of(const LobeSample& s, const RegionFit& fit) {
  double gain = 0, single = 0;
  for (size_t j = 0; j < kWidths; ++j) gain += fit.mixture[j] * double(s.led_lobe[j]);
  for (double amplitude : fit.single.amplitude) single += amplitude * double(s.led_single) / 3;
  if (gain <= 0) return {0, 1e6};
  return {(double(s.full) - single) / gain, double(s.full_variance) / (gain * gain)};
}

double mixture_at(const RegionFit& fit, const MixtureTable::Values& members) {
  double p = 0;
  for (size_t j = 0; j < kWidths; ++j) p += fit.mixture[j] * double(members[j]);
  return p;
}

void add_sample(const LobeSample& s, const RegionFit& fit, const MixtureTable& table,
                Equations* to) {
  const MixtureTable::Values members = table(s.cos_h);
  const Intensity intensity = intensity_of(s, fit);
  const double lobe = mixture_at(fit, members) * double(s.front_lobe);
  // Expected, not measured: a weight from the sample's own value would prefer one sign of noise.
  const double expected = fit.intensity * lobe;
  const double shared = lobe * lobe * intensity.variance +
                        double(kLobeModelError * kLobeModelError) * expected * expected;
  std::array<double, kUnknowns> row{};
  for (size_t j = 0; j < kWidths; ++j) {
    row[j] = intensity.c * double(s.front_lobe) * double(members[j]);
  }
  for (int channel = 0; channel < 3; ++channel) {
    const double weight = 1 / (double(s.front_variance[channel]) + shared);
    const int own = int(kWidths) + channel;
    row[size_t(own)] = double(s.front_single);
    const auto accumulate = [&](int i) {
      const double wi = weight * row[size_t(i)];
      to->b(i) += wi * double(s.front[channel]);
      for (int j = 0; j < int(kWidths); ++j) to->m(i, j) += wi * row[size_t(j)];
      to->m(i, own) += wi * row[size_t(own)];
    };
    for (int i = 0; i < int(kWidths); ++i) accumulate(i);
    accumulate(own);
    row[size_t(own)] = 0;
  }
  ++to->samples;
  if (s.cos_h > kConeCosine) ++to->in_cone;
  if (s.cos_h > kPeakCosine) ++to->at_peak;
}

// False where there is no lobe in the data.
bool apply(const cv::Mat1d& solution, RegionFit* fit) {
  double sum = 0;
  for (size_t j = 0; j < kWidths; ++j) sum += solution(int(j));
  for (size_t c = 0; c < 3; ++c) fit->single.amplitude[c] = solution(int(kWidths + c));
  if (sum <= 0) return false;
  for (size_t j = 0; j < kWidths; ++j) fit->mixture[j] = solution(int(j)) / sum;
  return true;
}

std::vector<Blocks> equations_of(const std::vector<LobeSample>& samples,
                                 const std::vector<RegionFit>& fits) {
  std::vector<Blocks> equations(fits.size());
  const MixtureTable table;
  for (const LobeSample& s : samples) {
    add_sample(s, fits[s.region], table, &equations[s.region][s.block]);
  }
  return equations;
}

Equations whole_face(const std::vector<Blocks>& regions) {
  Equations sum;
  for (const Blocks& blocks : regions) sum.add(total(blocks), 1);
  return sum;
}

cv::Mat1d solve(Equations own, const Equations& face) {
  const int at_peak = own.at_peak;
  if (face.samples > 0) own.add(face, kBorrowed / face.samples);
  // c is measured for a lobe of integral 1, so FRONT must find that integral again: where no pixel
  // shows the peak, this tells it from the flank. Where pixels do, errors of W are better left to
  // the integral than given to single scattering.
  const double weight = 1 / (kScaleSigma * kScaleSigma * (1 + at_peak));
  for (int i = 0; i < int(kWidths); ++i) {
    for (int j = 0; j < int(kWidths); ++j) own.m(i, j) += weight;
    own.b(i) += weight;
  }
  return solve_non_negative(cv::Mat1d(own.m), cv::Mat1d(own.b), int(kWidths));
}

void set_table(RegionFit* fit) {
  fit->lobe.theta_rad = lobe_angles();
  fit->lobe.p = lobe_values(fit->mixture, fit->lobe.theta_rad);
  fit->lobe.gaussian_m = model::gaussian_width(fit->lobe.theta_rad, fit->lobe.p);
}

// Delete-a-block jackknife: tiles are left out one group at a time, so that errors which neighbours
// share (normals, texture) count as the noise does. What all tiles share no tile shows: how much
// that is twins tell.
void set_deviations(const Blocks& blocks, const Equations& face, RegionFit* fit) {
  const Equations all = total(blocks);
  std::vector<double> variance(fit->lobe.p.size(), 0.0);
  double m_variance = 0;
  std::array<double, 3> amplitude_variance{};
  for (const Equations& left_out : blocks) {
    Equations rest = all;
    rest.add(left_out, -1);
    RegionFit without = *fit;
    apply(solve(rest, face), &without);  // where that shows no lobe, it keeps the region's
    set_table(&without);
    const auto square = [](double d) { return d * d * (kBlocks - 1) / kBlocks; };
    for (size_t i = 0; i < variance.size(); ++i) {
      variance[i] += square(without.lobe.p[i] - fit->lobe.p[i]);
    }
    m_variance += square(without.lobe.gaussian_m - fit->lobe.gaussian_m);
    for (size_t c = 0; c < 3; ++c) {
      amplitude_variance[c] += square(without.single.amplitude[c] - fit->single.amplitude[c]);
    }
  }
  fit->lobe.p_stddev.clear();
  for (size_t i = 0; i < variance.size(); ++i) {
    fit->lobe.p_stddev.push_back(std::hypot(kSharedError * std::sqrt(variance[i]),
                                            kTileLobeError * fit->lobe.p[i],
                                            kLobeTailError * fit->lobe.p[0]));
  }
  fit->lobe.gaussian_m_stddev = kSharedError * std::sqrt(m_variance);
  for (size_t c = 0; c < 3; ++c) {
    fit->single.amplitude_stddev[c] =
        std::hypot(std::sqrt(amplitude_variance[c]), kTileSingleError * fit->single.amplitude[c]);
  }
}

void widen(double value, double* stddev) {
  *stddev = std::max(*stddev, kBorrowedSpread * std::abs(value));
}

// What a region has from the others may not be its own.
void widen_lobe(RegionFit* fit) {
  for (size_t i = 0; i < fit->lobe.p.size(); ++i) widen(fit->lobe.p[i], &fit->lobe.p_stddev[i]);
  widen(fit->lobe.gaussian_m, &fit->lobe.gaussian_m_stddev);
}

void widen_single(RegionFit* fit) {
  for (size_t c = 0; c < 3; ++c) widen(fit->single.amplitude[c], &fit->single.amplitude_stddev[c]);
}

// Where a typical amplitude would surely have shown itself, one that does not is not there; where
// it would not, nobody can tell.
void judge_single(int samples, RegionSingle* single) {
  double squares = 0, typical_squares = 0;
  std::array<double, 3>&a = single->amplitude, &stddev = single->amplitude_stddev, sigma;
  for (size_t c = 0; c < 3; ++c) {
    sigma[c] = std::hypot(stddev[c], kLobeInSingle * kTypicalSingle);
    const double seen = std::max(0.0, a[c] / sigma[c]);
    squares += seen * seen / 3;
    typical_squares += kTypicalSingle * kTypicalSingle / (3 * sigma[c] * sigma[c]);
  }
  single->fitted = squares > kSeen;
  if (single->fitted) return;
  const std::string measured = fmt::format(
      "an amplitude of {:.3f} {:.3f} {:.3f} is within {:.0f} sigmas of none ({:.3f} {:.3f} {:.3f})",
      a[0], a[1], a[2], std::sqrt(kSeen), sigma[0], sigma[1], sigma[2]);
  if (typical_squares > kSurelySeen) {
    single->why = fmt::format("dropped: {}, where skin's {:g} would show itself by {:.0f} sigmas",
                              measured, kTypicalSingle, std::sqrt(typical_squares));
  } else {
    single->doubt = Doubt::kNotJudged;
    single->why = fmt::format(
        "cannot be judged from {} usable pixels: {}, and skin's {:g} would show itself by {:.1f} "
        "sigmas alone; taken as none",
        samples, measured, kTypicalSingle, std::sqrt(typical_squares));
    for (size_t c = 0; c < 3; ++c) stddev[c] = std::hypot(stddev[c], a[c]);
  }
  a = {0, 0, 0};
}

// All that FRONT has is then put down to single scattering, that of the surface too; c follows, at
// 0.
bool takes_lobe_for_single(const RegionFit& fit) {
  const std::array<double, 3>& a = fit.single.amplitude;
  return std::max({a[0], a[1], a[2]}) > kTooMuchSingle * kTypicalSingle;
}

void refuse_single(RegionFit* fit) {
  const std::array<double, 3>& a = fit->single.amplitude;
  fit->lobe.doubt = fit->single.doubt = Doubt::kNotJudged;
  fit->single.fitted = false;
  fit->single.why = fmt::format(
      "cannot be told from surface reflection: FRONT shows no lobe, and {:.3f} {:.3f} {:.3f} is "
      "more "
      "than skin's {:g}; taken as none",
      a[0], a[1], a[2], kTypicalSingle);
  fit->single.amplitude = {0, 0, 0};
}

void set_reasons(const Equations& own, bool found, RegionFit* fit) {
  fit->lobe.why = fit->single.why = "";  // of fewer samples
  fit->lobe.doubt = fit->single.doubt = Doubt::kNone;
  if (!found || own.in_cone < kEnoughInCone || own.at_peak < kEnoughAtPeak) widen_lobe(fit);
  if (own.in_cone < kEnoughInCone) widen_single(fit);
  fit->lobe.fitted = found;
  if (own.in_cone < kEnoughInCone) fit->lobe.doubt = Doubt::kNotJudged;
  if (!found) {
    fit->lobe.why = "no surface reflection in FRONT: a typical lobe stands in";
  } else if (own.in_cone < kEnoughInCone) {
    fit->lobe.why = fmt::format(
        "only {} usable pixels within 45 degrees: mostly the lobe of the whole face", own.in_cone);
  } else if (own.at_peak < kEnoughAtPeak) {
    fit->lobe.why = fmt::format(
        "only {} usable pixels within 10 degrees: the peak follows from the flank", own.at_peak);
  }
  fit->samples = own.samples;
  fit->measured_single = fit->single.amplitude;
  judge_single(own.samples, &fit->single);
  if (!found && takes_lobe_for_single(*fit)) refuse_single(fit);
}

// Median of c, mean diffuse reflectance.
void set_summaries(const std::vector<LobeSample>& samples, std::vector<RegionFit>* fits) {
  std::vector<std::vector<double>> c(fits->size());
  std::vector<Vec3d> diffuse(fits->size(), Vec3d(0, 0, 0));
  for (const LobeSample& s : samples) {
    c[s.region].push_back(intensity_of(s, (*fits)[s.region]).c);
    diffuse[s.region] += Vec3d(s.diffuse_reflectance);
  }
  for (size_t r = 0; r < fits->size(); ++r) {
    if (c[r].empty()) continue;
    const auto middle = c[r].begin() + ptrdiff_t(c[r].size() / 2);
    std::nth_element(c[r].begin(), middle, c[r].end());
    (*fits)[r].intensity = std::max(0.0, *middle);
    for (int k = 0; k < 3; ++k) {
      (*fits)[r].diffuse_reflectance[size_t(k)] = diffuse[r][k] / double(c[r].size());
    }
  }
}

}  // namespace

std::vector<double> lobe_angles() {
  constexpr int kSteps = 90;
  std::vector<double> theta;
  for (int i = 0; i <= kSteps; ++i) theta.push_back(double(kPi) / 4 * i / kSteps);
  return theta;
}

std::vector<double> lobe_values(const Mixture& mixture, const std::vector<double>& theta_rad) {
  const std::array<double, kWidths> widths = mixture_widths();
  std::vector<double> p;
  for (double theta : theta_rad) {
    double sum = 0;
    for (size_t j = 0; j < kWidths; ++j) {
      sum += mixture[j] * model::beckmann(std::cos(theta), widths[j]);
    }
    p.push_back(sum);
  }
  return p;
}

RegionFit prior_region_fit() {
  RegionFit fit;
  const std::array<double, kWidths> widths = mixture_widths();
  size_t nearest = 0;
  for (size_t j = 1; j < kWidths; ++j) {
    if (std::abs(widths[j] - kTypicalWidth) < std::abs(widths[nearest] - kTypicalWidth))
      nearest = j;
  }
  fit.mixture[nearest] = 1;
  set_table(&fit);
  fit.lobe.p_stddev.assign(fit.lobe.p.size(), 0.0);
  return fit;
}

std::vector<RegionFit> fit_lobes(const std::vector<LobeSample>& samples,
                                 const std::vector<RegionFit>& previous, int rounds) {
  std::vector<RegionFit> fits = previous;
  std::vector<bool> found(fits.size(), false);
  for (int round = 0; round < rounds; ++round) {
    set_summaries(samples, &fits);
    const std::vector<Blocks> equations = equations_of(samples, fits);
    const Equations face = whole_face(equations);
    for (size_t r = 0; r < fits.size(); ++r) {
      found[r] = face.samples > 0 && apply(solve(total(equations[r]), face), &fits[r]);
      set_table(&fits[r]);
      if (round + 1 < rounds) continue;
      set_deviations(equations[r], face, &fits[r]);
      set_reasons(total(equations[r]), found[r], &fits[r]);
    }
  }
  set_summaries(samples, &fits);
  return fits;
}

void share_single(std::vector<RegionFit>* fits) {
  RegionSingle shared;
  int samples = 0;
  for (const RegionFit& fit : *fits) samples += fit.lobe.fitted ? fit.samples : 0;
  if (samples == 0) return;
  for (size_t c = 0; c < 3; ++c) {
    double sum = 0, squares = 0, weight = 0;
    for (const RegionFit& fit : *fits) {
      if (!fit.lobe.fitted) continue;
      const double a = fit.measured_single[c];
      const double w = 1 / std::pow(std::max(1e-9, fit.single.amplitude_stddev[c]), 2);
      sum += w * a;
      squares += w * a * a;
      weight += w;
    }
    const double mean = sum / weight;
    const double spread = std::sqrt(std::max(0.0, squares / weight - mean * mean));
    shared.amplitude[c] = mean;
    shared.amplitude_stddev[c] = std::hypot(spread, 1 / std::sqrt(weight));
  }
  judge_single(samples, &shared);
  shared.why = (shared.fitted ? "kept: one" : shared.why + "; one") +
               std::string(
                   " amplitude for all regions, as those that were found by colour and gloss do "
                   "not tell it apart");
  for (RegionFit& fit : *fits) {
    if (fit.lobe.fitted) fit.single = shared;
  }
}

}  // namespace lamella::fit
