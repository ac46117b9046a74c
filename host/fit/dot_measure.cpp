#include "fit/dot_measure.h"

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>

#include "base/parallel.h"
#include "fit/dot_pattern.h"

namespace lamella::fit {

namespace {

constexpr double kLeastLit = 0.25;           // of a dot's pixels, in a channel
constexpr float kDarkestDot = 0.003f;        // FRONT - BLACK below this says little
constexpr float kSmallestDotCosine = 0.35f;  // beyond, a dot is not on a plane any more
constexpr float kDotModelError = 0.01f;      // of FRONT - BLACK
constexpr float kLeastShare = 0.6f;          // of a dot's pixels in one region
constexpr double kLeastOfDot = 0.15;         // of the pixels that a whole dot's square has
constexpr double kFewestPixels = 20;
constexpr int kNeighbours_px = 5;

// One dot and the light between it and its neighbours.
struct DotPixels {
  std::vector<cv::Point> pixel;
  int label = 0;
};

// What a pixel and its neighbours say of one channel. Weights come from neighbours: one from the
// pixel's own value would prefer what noise has darkened, and in the middle of a dot on dark skin
// nothing but noise is left.
struct Light {
  float ratio = 0;           // DOTS/(FRONT - BLACK)
  float ratio_variance = 0;  // of noise alone
};

class DotLight {
 public:
  explicit DotLight(const Burst& burst) : burst_(burst) {
    const cv::Size window(kNeighbours_px, kNeighbours_px);
    cv::blur(burst.dots, dots_, window);
    cv::blur(burst.front_lit, lit_, window);
    cv::blur(burst.front_lit.mul(burst.front_lit), lit_squared_, window);
  }

  // False where it is too dark.
  bool at(const cv::Point& p, int c, Light* light) const {
    const float around = lit_(p)[c], noise = burst_.projector_noise.variance(around);
    if (around < kDarkestDot) return false;
    // Wiener: the pixel's own FRONT as far as its neighbours differ by more than noise.
    const float spread = std::max(0.f, lit_squared_(p)[c] - around * around);
    const float own = spread > 0 ? std::max(0.f, 1 - noise / spread) : 0.f;
    const float lit = std::max(around + own * (burst_.front_lit(p)[c] - around), 0.25f * around);
    const float lit_variance = own * own * noise / (around * around);
    const float expected = std::max(0.f, dots_(p)[c]) / around;
    // A quotient by something noisy is too large on average, by the noise's square.
    light->ratio = burst_.dots(p)[c] / lit * (1 - std::min(lit_variance, 0.5f));
    light->ratio_variance = burst_.projector_noise.variance(dots_(p)[c]) / (around * around) +
                            expected * expected * lit_variance;
    return true;
  }

 private:
  const Burst& burst_;
  Image3 dots_, lit_, lit_squared_;
};

bool usable(const Burst& burst, const Geometry& geometry, const Normals& normals, int y, int x) {
  if (!burst.regions(y, x)) return false;
  if (is_clipped(burst.clipped_projector, y, x) || is_clipped(burst.clipped_dots, y, x)) {
    return false;
  }
  const Vec3& n = normals.diffuse[1](y, x);
  if (!is_finite(n) || !is_finite(geometry.position_mm(y, x))) return false;
  return dot(n, geometry.to_projector(y, x)) > kSmallestDotCosine;
}

// Sampled pixels of a square of the grid that faces the camera at the origin.
double whole_dot_pixels(const Session& session) {
  const double side_mm = session.patterns.dot_pitch_px * session.projector.pixel_mm();
  const double side_px = side_mm / session.left.pixel_mm();
  return side_px * side_px / 2;
}

// The label that most of the pixels have, where it is nearly all of them; 0 otherwise.
int dominant_label(const Burst& burst, const std::vector<cv::Point>& pixels) {
  std::array<size_t, 256> count{};
  for (const cv::Point& p : pixels) ++count[burst.regions(p)];
  const auto most = std::max_element(count.begin(), count.end());
  const double enough = std::max(kFewestPixels, kLeastOfDot * whole_dot_pixels(*burst.session));
  if (float(*most) < kLeastShare * float(pixels.size()) || double(*most) < enough) return 0;
  return int(most - count.begin());
}

std::vector<DotPixels> find_dots(const Burst& burst, const Geometry& geometry,
                                 const Normals& normals, const DotPattern& pattern,
                                 const Image2& projector_px) {
  std::map<std::pair<int, int>, DotPixels> dots;
  for (int y = 0; y < burst.regions.rows; ++y) {
    for (int x = y & 1; x < burst.regions.cols; x += 2) {
      if (!usable(burst, geometry, normals, y, x)) continue;
      const DotPattern::Place at = pattern.place(projector_px(y, x));
      dots[{at.row, at.column}].pixel.push_back({x, y});
    }
  }
  std::vector<DotPixels> found;
  for (auto& [key, dot] : dots) {
    dot.label = dominant_label(burst, dot.pixel);
    if (dot.label) found.push_back(std::move(dot));
  }
  return found;
}

PatternMetric mean_metric(const Burst& burst, const Geometry& geometry, const Normals& normals,
                          const DotPixels& dot) {
  PatternMetric sum(0, 0, 0);
  for (const cv::Point& p : dot.pixel) {
    sum += metric_of(
        pattern_gradient(burst.session->projector, geometry.position_mm(p), normals.diffuse[1](p)));
  }
  return sum / double(dot.pixel.size());
}

// DOTS/(FRONT - BLACK) is the share of the kernel's light that comes from lit skin: what the pixel
// itself reflects, and how it is turned, cancel.
void add_equations(const DotLight& light, const cv::Point& p, const KernelEquations::Vector& row,
                   Dot* dot) {
  for (int c = 0; c < 3; ++c) {
    Light l;
    if (!light.at(p, c, &l)) continue;
    const float variance = l.ratio_variance + kDotModelError * kDotModelError;
    dot->equations[size_t(c)].add(row, double(l.ratio), double(1 / variance));
  }
}

}  // namespace

std::vector<Dot> measure_dots(const Burst& burst, const Geometry& geometry,
                              const Normals& normals) {
  const DotPattern pattern(burst.session->patterns);
  const DotLight light(burst);
  const Image2 projector_px = moved_projector_px(geometry.projector_px, burst.dots_place);
  const std::vector<DotPixels> found = find_dots(burst, geometry, normals, pattern, projector_px);
  std::vector<Dot> dots(found.size());
  parallel_for(int(found.size()), [&](int i) {
    const DotPixels& pixels = found[size_t(i)];
    Dot& dot = dots[size_t(i)];
    dot.label = pixels.label;
    const BlurredDots table = pattern.blurred(mean_metric(burst, geometry, normals, pixels));
    BlurredDots::Sample sample;
    KernelEquations::Vector row;
    for (const cv::Point& p : pixels.pixel) {
      if (burst.regions(p) != dot.label) continue;
      dot.pixels += 1;
      const DotPattern::Place at = pattern.place(projector_px(p));
      table.look_up(at.u, at.v, &sample);
      for (int j = 0; j < GaussianBasis::kSize; ++j) row(j) = double(sample[size_t(j)]);
      row(GaussianBasis::kSize) = 1;
      add_equations(light, p, row, &dot);
    }
  });
  return dots;
}

RegionEquations equations_of_region(const std::vector<Dot>& dots, int label) {
  RegionEquations equations;
  for (const Dot& dot : dots) {
    if (dot.label != label) continue;
    for (size_t c = 0; c < 3; ++c) {
      if (dot.equations[c].count > kLeastLit * dot.pixels) {
        equations[c].push_back(&dot.equations[c]);
      }
    }
  }
  return equations;
}

}  // namespace lamella::fit
