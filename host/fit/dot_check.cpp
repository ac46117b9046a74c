#include "fit/dot_check.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/pattern_scale.h"
#include "fit/dot_pattern.h"
#include "fit/order_statistics.h"

namespace lamella::fit {

namespace {

constexpr float kShadowOfDots = 1e-3f;  // FRONT - BLACK below this says nothing
constexpr double kSamplesAcross = 5;    // of a dot: more pixels are not looked at
constexpr float kFarthest = 0.7071f;  // from a dot's centre, in periods, in its square of the grid
constexpr int kFewestInside = 2, kFewestBetween = 4;
constexpr double kWhole = 0.8;  // of the pixels that most squares have
// In the channel that scatters least. On light skin a dot's middle shows 0.4 of what is between.
constexpr float kDark = 0.7f;

// Of the pixels in the middle of a dot, or far from it.
struct LightSum {
  Vec3 dots{0, 0, 0}, lit{0, 0, 0};
  int count = 0;

  Vec3 ratio() const {
    Vec3 r;
    for (int c = 0; c < 3; ++c) r[c] = lit[c] > 0 ? dots[c] / lit[c] : kNaN;
    return r;
  }
};

// Light that is missing in a dot's square of the grid.
struct Darkness {
  double sum = 0, u = 0, v = 0;
  int count = 0;

  void add(double dark, const DotPattern::Place& at) {
    sum += dark;
    u += dark * double(at.u);
    v += dark * double(at.v);
    ++count;
  }
  double off_periods() const { return std::hypot(u, v) / std::max(sum, 1e-6); }
};

struct DotLook {
  LightSum inside, between;
  Darkness darkness;

  bool tells() const { return inside.count >= kFewestInside && between.count >= kFewestBetween; }
  bool is_dark() const {
    const Vec3 in = inside.ratio(), out = between.ratio();
    for (int c = 0; c < 3; ++c) {
      if (in[c] < kDark * out[c]) return true;
    }
    return false;
  }
};

using Looks = std::map<std::pair<int, int>, DotLook>;

Looks look_at_dots(const Burst& burst, const Geometry& geometry) {
  const Patterns& patterns = burst.session->patterns;
  const DotPattern pattern(patterns);
  const float radius = float(0.5 * patterns.dot_diameter_px / patterns.dot_pitch_px);
  const Image2 projector_px = moved_projector_px(geometry.projector_px, burst.dots_place);
  const int step = std::max(1, int(pattern_scale(*burst.session).dot_px / kSamplesAcross));
  Looks looks;
  for (int y = 0; y < burst.regions.rows; y += step) {
    for (int x = 0; x < burst.regions.cols; x += step) {
      if (!burst.regions(y, x) || !is_finite(projector_px(y, x)[0])) continue;
      if (is_clipped(burst.clipped_projector, y, x) || is_clipped(burst.clipped_dots, y, x)) {
        continue;
      }
      const Vec3& lit = burst.front_lit(y, x);
      if (!(mean(lit) > kShadowOfDots)) continue;
      const DotPattern::Place at = pattern.place(projector_px(y, x));
      DotLook& look = looks[{at.row, at.column}];
      look.darkness.add(1 - double(mean(burst.dots(y, x)) / mean(lit)), at);
      const float from_centre = std::hypot(at.u, at.v);
      const bool is_inside = from_centre < radius / 2;
      if (!is_inside && from_centre < (radius + kFarthest) / 2) continue;
      LightSum& sum = is_inside ? look.inside : look.between;
      sum.dots += burst.dots(y, x);
      sum.lit += lit;
      ++sum.count;
    }
  }
  return looks;
}

// Of squares that are seen as a whole: those that the labels' or the light's edge cuts are not.
void measure_darkness(const Looks& looks, const Patterns& patterns, DotsSeen* seen) {
  std::vector<float> pixels, off;
  for (const auto& [place, look] : looks) pixels.push_back(float(look.darkness.count));
  const double whole = kWhole * double(median_of(&pixels));
  double dark = 0, count = 0;
  for (const auto& [place, look] : looks) {
    if (!look.tells() || look.darkness.count < whole) continue;
    off.push_back(float(look.darkness.off_periods()));
    dark += look.darkness.sum;
    count += look.darkness.count;
  }
  if (off.empty()) return;
  seen->off_px = patterns.dot_pitch_px * double(median_of(&off));
  seen->diameter_px = patterns.dot_pitch_px * std::sqrt(std::max(0.0, dark / count) * 4 / M_PI);
}

}  // namespace

DotsSeen look_for_dots(const Burst& burst, const Geometry& geometry) {
  DotsSeen seen;
  std::array<std::vector<float>, 3> between;
  const Looks looks = look_at_dots(burst, geometry);
  for (const auto& [place, look] : looks) {
    if (!look.tells()) continue;
    ++seen.dots;
    seen.dark += look.is_dark() ? 1 : 0;
    const Vec3 ratio = look.between.ratio();
    for (size_t c = 0; c < 3; ++c) between[c].push_back(ratio[int(c)]);
  }
  if (seen.dots == 0) return seen;
  measure_darkness(looks, burst.session->patterns, &seen);
  for (size_t c = 0; c < 3; ++c) seen.between[int(c)] = median_of(&between[c]);
  return seen;
}

}  // namespace lamella::fit
