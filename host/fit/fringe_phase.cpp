#include "fit/fringe_phase.h"

#include <algorithm>
#include <array>

#include "base/filled.h"
#include "base/parallel.h"
#include "fit/turns.h"

namespace lamella::fit {

namespace {

constexpr int kTilePx = 16;
constexpr int kSampleStepPx = 3;
constexpr int kContrastRounds = 3;
constexpr float kFullContrast = 0.5f;
constexpr float kLeastContrast = 0.02f;
constexpr float kLeastModulation = 0.4f;  // of what the contrast of the neighbourhood promises
constexpr float kMostPhaseSigma = 0.5f;   // rad; noisier than this is not an answer
constexpr std::array<float, 3> kCosShift{-0.5f, 1.f, -0.5f};
constexpr std::array<float, 3> kSinShift{-0.8660254f, 0.f, 0.8660254f};

// cos and sin of the phase, not normalised: 1 long where the contrast is as expected.
struct Phasor {
  float cosine = 0, sine = 0;
  float variance = 0;  // of the phase, rad^2
};

// Weighted least squares of y_c = a_c (cos_c cosine - sin_c sine).
Phasor solve_phasor(const Vec3& y, const Vec3& contrast, const Vec3& weight) {
  float m00 = 0, m01 = 0, m11 = 0, r0 = 0, r1 = 0;
  for (int c = 0; c < 3; ++c) {
    const float b0 = contrast[c] * kCosShift[c], b1 = -contrast[c] * kSinShift[c];
    m00 += weight[c] * b0 * b0;
    m01 += weight[c] * b0 * b1;
    m11 += weight[c] * b1 * b1;
    r0 += weight[c] * b0 * y[c];
    r1 += weight[c] * b1 * y[c];
  }
  const float det = m00 * m11 - m01 * m01;
  if (!(det > 0)) return {0, 0, std::numeric_limits<float>::infinity()};
  Phasor p{(m11 * r0 - m01 * r1) / det, (m00 * r1 - m01 * r0) / det, 0};
  const float square = std::max(1e-6f, p.cosine * p.cosine + p.sine * p.sine);
  p.variance = (m11 * p.sine * p.sine + 2 * m01 * p.sine * p.cosine + m00 * p.cosine * p.cosine) /
               (det * square * square);
  return p;
}

// Contrast per channel on a grid of tiles, read between the tiles' centres.
class ContrastField {
 public:
  explicit ContrastField(cv::Size image)
      : grid_((image.height + kTilePx - 1) / kTilePx, (image.width + kTilePx - 1) / kTilePx,
              Vec3(kFullContrast, kFullContrast, kFullContrast)) {}

  Image3& grid() { return grid_; }

  Vec3 at(int y, int x) const {
    const float gy = std::clamp((y + 0.5f) / kTilePx - 0.5f, 0.f, float(grid_.rows - 1));
    const float gx = std::clamp((x + 0.5f) / kTilePx - 0.5f, 0.f, float(grid_.cols - 1));
    const int i = std::min(int(gy), std::max(0, grid_.rows - 2));
    const int j = std::min(int(gx), std::max(0, grid_.cols - 2));
    const int i1 = std::min(i + 1, grid_.rows - 1), j1 = std::min(j + 1, grid_.cols - 1);
    const float fy = gy - i, fx = gx - j;
    return (grid_(i, j) * (1 - fx) + grid_(i, j1) * fx) * (1 - fy) +
           (grid_(i1, j) * (1 - fx) + grid_(i1, j1) * fx) * fy;
  }

 private:
  Image3 grid_;
};

class Level {
 public:
  Level(const Image3& fringe, const Image3& white, const Mask& wanted, const NoiseModel& noise)
      : fringe_(fringe),
        white_(white),
        wanted_(wanted),
        read_variance_(1.25f * float(noise.read_variance)),
        photon_variance_(0.75f * float(noise.photon_variance_per_unit)),
        contrast_(fringe.size()) {}

  // Phase from the present contrasts, contrasts from that phase; a few rounds settle.
  void measure_contrast() {
    for (int round = 0; round < kContrastRounds; ++round) {
      Image3 num(contrast_.grid().size()), den(contrast_.grid().size());
      parallel_for(num.rows, [&](int i) {
        for (int j = 0; j < num.cols; ++j) accumulate_tile(i, j, &num(i, j), &den(i, j));
      });
      divide(num, den);
    }
  }

  Phasor at(int y, int x) const {
    const Vec3& w = white_(y, x);
    Vec3 modulation, weight;
    for (int c = 0; c < 3; ++c) {
      const float white = std::max(w[c], 1e-6f);
      modulation[c] = fringe_(y, x)[c] / white - kFullContrast;
      // Of the fringe (about half white) over the white, both noisy.
      const float variance = read_variance_ + photon_variance_ * white;
      weight[c] = w[c] > 0 ? white * white / std::max(variance, 1e-12f) : 0.f;
    }
    return solve_phasor(modulation, contrast_.at(y, x), weight);
  }

 private:
  void accumulate_tile(int i, int j, Vec3* num, Vec3* den) const {
    *num = *den = Vec3(0, 0, 0);
    const int y1 = std::min((i + 1) * kTilePx, fringe_.rows);
    const int x1 = std::min((j + 1) * kTilePx, fringe_.cols);
    for (int y = i * kTilePx; y < y1; y += kSampleStepPx) {
      for (int x = j * kTilePx + y / kSampleStepPx % 2; x < x1; x += kSampleStepPx) {
        if (!wanted_(y, x)) continue;
        const Phasor p = at(y, x);
        const float length = std::sqrt(p.cosine * p.cosine + p.sine * p.sine);
        if (!(p.variance < kMostPhaseSigma * kMostPhaseSigma) || length < kLeastModulation)
          continue;
        for (int c = 0; c < 3; ++c) {
          const float expected = (kCosShift[c] * p.cosine - kSinShift[c] * p.sine) / length;
          const float white = white_(y, x)[c];
          // Weighted by white squared: dark pixels are mostly noise.
          (*num)[c] += expected * (fringe_(y, x)[c] - kFullContrast * white) * white;
          (*den)[c] += expected * expected * white * white;
        }
      }
    }
  }

  // Each tile with its neighbours; a tile without light keeps the contrast it had.
  void divide(const Image3& num, const Image3& den) {
    Image3& grid = contrast_.grid();
    for (int i = 0; i < grid.rows; ++i) {
      for (int j = 0; j < grid.cols; ++j) {
        Vec3 n(0, 0, 0), d(0, 0, 0);
        for (int k = std::max(0, i - 1); k <= std::min(grid.rows - 1, i + 1); ++k) {
          for (int l = std::max(0, j - 1); l <= std::min(grid.cols - 1, j + 1); ++l) {
            n += num(k, l);
            d += den(k, l);
          }
        }
        for (int c = 0; c < 3; ++c) {
          if (d[c] > 0) grid(i, j)[c] = std::clamp(n[c] / d[c], kLeastContrast, kFullContrast);
        }
      }
    }
  }

  const Image3& fringe_;
  const Image3& white_;
  const Mask& wanted_;
  float read_variance_;
  float photon_variance_;
  ContrastField contrast_;
};

float nearest_turn(float u_px, float turns, float px_per_turn) {
  return (turns + std::round(u_px / px_per_turn - turns)) * px_per_turn;
}

// A level that only counts turns for the next: full contrast in every channel is near enough.
void count_turns(const Image3& fringe, const Image3& white, float px_per_turn,
                 ProjectorColumns* columns) {
  parallel_for(columns->u_px.rows, [&](int y) {
    for (int x = 0; x < columns->u_px.cols; ++x) {
      float& u = columns->u_px(y, x);
      if (std::isnan(u)) continue;
      Vec3 v;
      for (int c = 0; c < 3; ++c) v[c] = fringe(y, x)[c] / std::max(white(y, x)[c], 1e-6f);
      const float turns = turns_of(2 * kSinShift[2] * (v[0] - v[2]), 2 * v[1] - v[0] - v[2]);
      u = nearest_turn(u, turns, px_per_turn);
    }
  });
}

// The finest level, which is the answer.
void measure_columns(const Level& level, float px_per_turn, ProjectorColumns* columns) {
  parallel_for(columns->u_px.rows, [&](int y) {
    for (int x = 0; x < columns->u_px.cols; ++x) {
      float& u = columns->u_px(y, x);
      if (std::isnan(u)) continue;
      const Phasor p = level.at(y, x);
      if (!(p.variance < kMostPhaseSigma * kMostPhaseSigma) ||
          p.cosine * p.cosine + p.sine * p.sine < kLeastModulation * kLeastModulation) {
        u = kNaN;
        continue;
      }
      u = nearest_turn(u, turns_of(p.sine, p.cosine), px_per_turn);
      columns->sigma_px(y, x) = std::sqrt(p.variance) / (2 * kPi) * px_per_turn;
    }
  });
}

}  // namespace

ProjectorColumns decode_columns(const std::vector<Image3>& fringe, const Image3& white,
                                const Mask& wanted, const FringeCode& code) {
  // The first level has no phase before it to lean on: it is unwrapped around the middle column.
  ProjectorColumns columns{Image1(white.size()), filled<Image1>(white.size(), kNaN)};
  parallel_for(white.rows, [&](int y) {
    for (int x = 0; x < white.cols; ++x) {
      columns.u_px(y, x) = wanted(y, x) ? float(code.projector_width_px / 2) : kNaN;
    }
  });
  for (size_t k = 0; k + 1 < fringe.size(); ++k) {
    count_turns(fringe[k], white, float(code.projector_width_px / code.periods[k]), &columns);
  }
  Level finest(fringe.back(), white, wanted, code.noise);
  finest.measure_contrast();
  measure_columns(finest, float(code.projector_width_px / code.periods.back()), &columns);
  return columns;
}

}  // namespace lamella::fit
