#include "fit/fit_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "calib/pattern_scale.h"
#include "fit/surface_check.h"

namespace lamella::fit {

namespace {

// Where a fit found the regions itself, their rims are skin that hardly any light reaches.
constexpr double kLeastPosition = 0.97, kLeastPositionOfFound = 0.85;
constexpr double kNoSurface = 0.1;  // specks: nothing that a map or an export could show
constexpr double kLeastSize_mm = 10, kMostSize_mm = 300;  // faces have 43 to 60
constexpr double kLeastAgreed = 0.5;
constexpr double kMostApart_px = 0.25;  // what a calibration is good to; good sessions have 0.01
constexpr double kMostFullOff = 0.01;   // 7 % of c; good sessions have 0.1 %
constexpr double kMostOffSurface_deg = 6;
// l_d 4 to 7 %; good sessions have 0.0002, dark skin 0.0007.
constexpr double kMostBlackOff = 0.002;
constexpr double kMostStripeMisfit = 0.1;
constexpr double kLeastCoherence = 0.9;
constexpr double kLeastDarkDots = 0.9;
constexpr double kMostDotWrong = 0.06, kMostDotOff = 0.08;  // of the diameter
constexpr double kLeastWidth = 0.4;                         // of it: with less, nothing was located
constexpr double kLeastBetween = 0.8, kMostBetween = 1.06;
// A frame that is turned makes an albedo 13 % wrong. Faces are taken from the side too.
constexpr double kMostAway_deg = 60;
constexpr float kCapped = 0.9999f;
constexpr double kMostCapped = 0.01;  // good sessions have none, of light skin either
constexpr double kMostFrontOff = 0.1, kMostLightOff = 0.05, kMostReflectedOff = 0.03;

void put_figure(const std::string& name, double value, LayeredFit* fit) {
  if (std::isfinite(value)) (*fit->layers.mutable_checks())[name] = value;
}

// One figure a channel. Returns the furthest from 0.
double put_light_off(const std::string& name, const std::array<double, 3>& off, LayeredFit* fit) {
  double most = 0;
  for (size_t c = 0; c < 3; ++c) {
    put_figure(name + "_" + kChannelNames[c], off[c], fit);
    most = std::max(most, std::abs(off[c]));
  }
  return most;
}

void poor(CheckLine line, LayeredFit* fit) {
  line.grade = Grade::kPoor;
  fit->check.lines.push_back(std::move(line));
}

// A share, and the limit that it is beyond.
void poor_share(const std::string& name, const std::string& text, double share, double limit,
                LayeredFit* fit) {
  poor({.name = name, .text = text, .figure = 100 * share, .unit = "%", .limit = 100 * limit}, fit);
}

double answered_share(const Labels& regions, const Image3& map) {
  double known = 0, asked = 0;
  for (int y = 0; y < regions.rows; ++y) {
    for (int x = 0; x < regions.cols; ++x) {
      if (!regions(y, x)) continue;
      asked += 1;
      known += is_finite(map(y, x)) ? 1 : 0;
    }
  }
  return asked > 0 ? known / asked : std::nan("");
}

// In projector pixels, what they measure against what is stated.
void judge_dot_shape(const Patterns& stated, const DotsSeen& seen, LayeredFit* fit) {
  put_figure("dots_diameter_px", seen.diameter_px, fit);
  const double wrong = std::abs(seen.diameter_px / stated.dot_diameter_px - 1);
  if (seen.diameter_px < kLeastWidth * stated.dot_diameter_px) {
    poor_share(
        "size and place of the dots",
        "they miss hardly any light: l_d is not to be believed; state the exposure of DOTS, and "
        "their pattern, as they were",
        wrong, kMostDotWrong, fit);
    return;
  }
  put_figure("dots_off_px", seen.off_px, fit);
  const double most_off_px = kMostDotOff * stated.dot_diameter_px;
  if (!(wrong > kMostDotWrong) && !(seen.off_px > most_off_px)) return;
  poor_share("size and place of the dots",
             fmt::format("they miss the light of dots {:.1f} projector pixels wide, stated {:g}, "
                         "at most {:g} % off, and lie {:.1f} pixels from where they are stated, "
                         "median, at most {:.1f}: l_d is not to be believed",
                         seen.diameter_px, stated.dot_diameter_px, 100 * kMostDotWrong, seen.off_px,
                         most_off_px),
             wrong, kMostDotWrong, fit);
}

// Over FRONT's light, per channel.
void judge_between_dots(const Vec3& between, LayeredFit* fit) {
  int worst = -1;
  for (int c = 0; c < 3; ++c) {
    put_figure(std::string("between_dots_") + kChannelNames[size_t(c)], double(between[c]), fit);
    const bool is_off = double(between[c]) < kLeastBetween || double(between[c]) > kMostBetween;
    if (is_off && (worst < 0 || std::abs(between[c] - 1) > std::abs(between[worst] - 1))) worst = c;
  }
  if (worst < 0) return;
  poor({.name = "light between the dots",
        .text = fmt::format("{:.2f} {:.2f} {:.2f} of FRONT's in red, green and blue, {:g} to {:g}: "
                            "l_d is not to be believed",
                            between[0], between[1], between[2], kLeastBetween, kMostBetween),
        .figure = double(between[worst]),
        .unit = "",
        .limit = between[worst] > 1 ? kMostBetween : kLeastBetween},
       fit);
}

}  // namespace

void require_surface(const Burst& burst, const Geometry& geometry) {
  if (burst.mesh) return;
  const Mask labelled = burst.regions > 0;
  const double share =
      double(cv::countNonZero(geometry.measured & labelled)) / double(cv::countNonZero(labelled));
  if (share >= kNoSurface) return;
  throw Error(Fault::kBadInput, "not usable",
              fmt::format("positions: measured for {:.1f} % of labelled pixels: are the FRINGE "
                          "photographs in order, and is the calibration theirs?",
                          100 * share));
}

void judge_positions(const Burst& burst, LayeredFit* fit) {
  if (burst.mesh) return;
  const double share = answered_share(fit->maps.regions, fit->maps.position_mm);
  const double least = burst.has_given_regions ? kLeastPosition : kLeastPositionOfFound;
  put_figure("position_answered", share, fit);
  if (!(share < least)) return;
  poor_share("positions",
             fmt::format("known for {:.1f} % of labelled pixels, at least {:g} %: the fringes do "
                         "not agree with the calibration, or are not seen",
                         100 * share, 100 * least),
             share, least, fit);
}

void judge_size(const Burst& burst, const Geometry& geometry, LayeredFit* fit) {
  Vec3d sum(0, 0, 0);
  double squares = 0, count = 0;
  for (int y = 0; y < burst.regions.rows; ++y) {
    for (int x = 0; x < burst.regions.cols; ++x) {
      if (!burst.regions(y, x) || !is_finite(geometry.position_mm(y, x))) continue;
      const Vec3d p(geometry.position_mm(y, x));
      sum += p;
      squares += p.dot(p);
      ++count;
    }
  }
  const Vec3d middle = sum * (1 / std::max(1.0, count));
  const double size_mm = std::sqrt(squares / std::max(1.0, count) - middle.dot(middle));
  put_figure("size_mm", size_mm, fit);
  if (!(size_mm < kLeastSize_mm) && !(size_mm > kMostSize_mm)) return;
  poor({.name = "size of the subject",
        .text = fmt::format("{:.1f} mm from its middle, RMS, {:g} to {:g}: lengths are not to be "
                            "believed; state translation_mm in mm",
                            size_mm, kLeastSize_mm, kMostSize_mm),
        .figure = size_mm,
        .unit = "mm",
        .limit = size_mm < kLeastSize_mm ? kLeastSize_mm : kMostSize_mm},
       fit);
}

void judge_right(const Geometry& geometry, LayeredFit* fit) {
  const Agreement& right = geometry.right;
  put_figure("right_camera_agrees", right.share, fit);
  put_figure("right_camera_apart_px", right.apart_px, fit);
  if (right.share < kLeastAgreed) {
    poor_share("right camera",
               fmt::format("agrees with {:.1f} % of what the left one and the projector measured, "
                           "at least {:g} %: one of them is not where the calibration says",
                           100 * right.share, 100 * kLeastAgreed),
               right.share, kLeastAgreed, fit);
  } else if (std::abs(right.apart_px) > kMostApart_px) {
    poor({.name = "right camera",
          .text = fmt::format("sees what the left one and the projector measured {:+.2f} pixels "
                              "aside, median, at most {:g}: one of them is not where the "
                              "calibration says",
                              right.apart_px, kMostApart_px),
          .figure = right.apart_px,
          .unit = "pixels",
          .limit = kMostApart_px},
         fit);
  }
}

void judge_full(const LedGains& gains, LayeredFit* fit) {
  if (!gains.is_known) return;
  const double off = (gains.gradient[0] + gains.gradient[1] + gains.gradient[2]) / 3;
  put_figure("gradients_over_full", off, fit);
  if (!(std::abs(off) > kMostFullOff)) return;
  poor_share("GRADIENT_FULL against the gradients",
             fmt::format("crossed, they are {:.1f} % {} than it and the positions ask for, mean of "
                         "X, Y and Z, at most {:g} %: c is not to be believed; state the exposure "
                         "of each as it was",
                         100 * std::abs(off), off > 0 ? "brighter" : "darker", 100 * kMostFullOff),
             off, kMostFullOff, fit);
}

void judge_facing(const Burst& burst, const Normals& normals, LayeredFit* fit) {
  Vec3d sum(0, 0, 0);
  for (int y = 0; y < burst.regions.rows; ++y) {
    for (int x = 0; x < burst.regions.cols; ++x) {
      const Vec3& n = normals.specular(y, x);
      if (burst.regions(y, x) && is_finite(n)) sum += Vec3d(n);
    }
  }
  const double away_deg = std::acos(sum[2] / cv::norm(sum)) * 180 / M_PI;
  put_figure("faces_away_deg", away_deg, fit);
  if (!(away_deg > kMostAway_deg)) return;
  poor(
      {.name = "where the subject faces",
       .text = fmt::format("{:.0f} degrees from +Z, mean of its normals, at most {:g}: the unit of "
                           "radiance is a white surface that faces +Z, so albedos are not to be "
                           "believed; state the rig in a frame whose +Z the subject faces",
                           away_deg, kMostAway_deg),
       .figure = away_deg,
       .unit = "degrees",
       .limit = kMostAway_deg},
      fit);
}

void judge_black(const BlackLevels& black, LayeredFit* fit) {
  const double off = black.by_stripes - black.by_black;
  put_figure("black_level_by_stripes", black.by_stripes, fit);
  if (!(std::abs(off) > kMostBlackOff)) return;
  poor_share("BLACK against STRIPES",
             fmt::format("{:.2f} % of white, and {:.2f} % by what STRIPES have beyond FRONT, at "
                         "most {:g} % apart: l_d is not to be believed; keep what the projector "
                         "emits when it is black, and state exposures as they were",
                         100 * black.by_black, 100 * black.by_stripes, 100 * kMostBlackOff),
             off, kMostBlackOff, fit);
}

void judge_surface(const Burst& burst, const Geometry& geometry, const Normals& normals,
                   LayeredFit* fit) {
  const double off_deg = normals_off_surface_deg(burst, geometry, normals);
  put_figure("normals_off_surface_deg", off_deg, fit);
  if (!(off_deg > kMostOffSurface_deg)) return;
  poor({.name = "normals against positions",
        .text = fmt::format("{:.1f} degrees off, median, at most {:g}: the gradients do not agree "
                            "with the fringes, or their photographs with the calibration",
                            off_deg, kMostOffSurface_deg),
        .figure = off_deg,
        .unit = "degrees",
        .limit = kMostOffSurface_deg},
       fit);
}

void judge_stripes(const Session& session, const Separation& separation, LayeredFit* fit) {
  if (!resolves_stripes(pattern_scale(session))) return;
  const double misfit = separation.stripe_misfit, coherence = separation.stripe_coherence;
  put_figure("stripe_misfit", misfit, fit);
  put_figure("stripe_coherence", coherence, fit);
  if (misfit > kMostStripeMisfit) {
    poor_share("stripes against their pattern",
               fmt::format("{:.1f} % of their contrast, squared, is not explained, median, at most "
                           "{:g} %: shallow and deep are not to be believed; state period and "
                           "shift as they were",
                           100 * misfit, 100 * kMostStripeMisfit),
               misfit, kMostStripeMisfit, fit);
  }
  if (coherence < kLeastCoherence) {
    poor({.name = "stripes against the surface",
          .text = fmt::format("their phases agree by {:.2f}, at least {:g} of 1: shallow and deep "
                              "are not to be believed; are STRIPES in order, and of the same "
                              "moment as FRINGE?",
                              coherence, kLeastCoherence),
          .figure = coherence,
          .unit = "",
          .limit = kLeastCoherence},
         fit);
  }
}

void judge_dots(const Session& session, const DotsSeen& seen, LayeredFit* fit) {
  if (seen.dots == 0 || !resolves_dots(pattern_scale(session))) return;
  const double dark = double(seen.dark) / seen.dots;
  put_figure("dots_dark", dark, fit);
  if (dark < kLeastDarkDots) {
    poor_share("dots against their pattern",
               fmt::format("{} of {} are dark where the pattern has them, at least {:g} %: l_d is "
                           "not to be believed",
                           seen.dark, seen.dots, 100 * kLeastDarkDots),
               dark, kLeastDarkDots, fit);
  }
  judge_dot_shape(session.patterns, seen, fit);
  judge_between_dots(seen.between, fit);
}

void judge_parallel(const RerenderResiduals& residuals, LayeredFit* fit) {
  const std::array<double, 3>& light = residuals.front_parallel_off;
  const double most = put_light_off("rerender_front_parallel", light, fit);
  if (!(most > kMostReflectedOff)) return;
  poor_share("FRONT parallel, drawn from the layers",
             fmt::format("{:+.1f} {:+.1f} {:+.1f} % off in red, green and blue, at most {:g} %: "
                         "the LEDs tell of more or less reflection than the projector; state the "
                         "exposures of parallel photographs as they were",
                         100 * light[0], 100 * light[1], 100 * light[2], 100 * kMostReflectedOff),
             most, kMostReflectedOff, fit);
}

void judge_rerender(const RerenderResiduals& residuals, LayeredFit* fit) {
  const std::array<double, 3>& light = residuals.front_cross_off;
  const double most = put_light_off("rerender_front_cross", light, fit);
  if (!(residuals.front_cross > kMostFrontOff) && !(most > kMostLightOff)) return;
  poor_share("FRONT crossed, drawn from the layers",
             fmt::format("{:.1f} % off, RMS, at most {:g} %, and by {:+.1f} {:+.1f} {:+.1f} % in "
                         "red, green and blue, at most {:g} %: the LEDs tell of another albedo "
                         "than the projector; state exposures and colours as they were",
                         100 * residuals.front_cross, 100 * kMostFrontOff, 100 * light[0],
                         100 * light[1], 100 * light[2], 100 * kMostLightOff),
             residuals.front_cross, kMostFrontOff, fit);
}

void judge_albedo(LayeredFit* fit) {
  const Image3& total = fit->maps.total_albedo;
  double known = 0, capped = 0;
  for (const Vec3& albedo : total) {
    if (!is_finite(albedo)) continue;
    ++known;
    capped += std::max({albedo[0], albedo[1], albedo[2]}) > kCapped ? 1 : 0;
  }
  const double share = capped / std::max(1.0, known);
  put_figure("albedo_capped", share, fit);
  if (!(share > kMostCapped)) return;
  poor_share("total albedo",
             fmt::format("{:.1f} % of labelled pixels reflect more light than they get, at most "
                         "{:g} %, and have 1 instead; state radiance_scale so that a white "
                         "surface that faces +Z has radiance 1",
                         100 * share, 100 * kMostCapped),
             share, kMostCapped, fit);
}

}  // namespace lamella::fit
