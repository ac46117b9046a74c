// Step 1, linearise: the photographs of one burst as radiance in the colours of the LEDs, black
// level, ambient light, extinction and projector tint removed (session-format: Radiometry). What
// leaks into stripes and dots goes where the geometry is known (pattern_extinction.h).
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "calib/check.h"
#include "fit/motion.h"
#include "fit/pattern_place.h"
#include "fit/quality.h"
#include "io/mesh_file.h"
#include "io/session.h"

namespace lamella::fit {

// Light that keeps its polarization passes `parallel` only; half the rest passes either.
struct AnalyserPair {
  Image3 parallel;
  Image3 cross;
};

// S = parallel - cross: surface reflection and single scattering. Noisy, may be negative.
Image3 polarized(const AnalyserPair& pair);

// Variance of one sample, from the camera's noise model and the photographs' radiance_scale.
struct NoiseModel {
  double read_variance = 0;             // radiance^2, quantisation included
  double photon_variance_per_unit = 0;  // radiance: variance = read + this * radiance
  float variance(float radiance) const {
    return float(read_variance + photon_variance_per_unit * double(std::max(0.f, radiance)));
  }
};

struct Burst {
  const Session* session = nullptr;
  const TriangleMesh* mesh = nullptr;     // the subject's shape, where it was given
  Quality quality;                        // what the steps may spend
  SessionCheck check;                     // of the photographs as they came; never unusable
  Labels regions;                         // 0 background
  bool has_given_regions = false;         // else one, "face", until they are found
  std::vector<std::string> region_names;  // names[label]
  NoiseModel led_noise, projector_noise;  // left camera, cross photographs
  // The parallel ones are set to the brighter light that they see.
  NoiseModel led_parallel_noise, front_parallel_noise;
  NoiseModel right_noise;  // right camera, lit by the projector

  // LED lit.
  AnalyserPair full;                     // GRADIENT_FULL
  std::array<AnalyserPair, 3> gradient;  // GRADIENT_X, _Y, _Z
  Mask clipped_led;                      // clipped in any LED frame
  cv::Mat3b clipped_led_cross;           // each channel, in any LED frame through CROSS

  // Projector lit, left camera. `front` still holds the projector's black level (white is
  // b + (1 - b) = 1); every other pattern has it removed, so that its light is (1 - b) x pattern.
  AnalyserPair front;
  Image3 black;                   // BLACK frame, cross
  Image3 front_lit;               // front.cross - black
  std::vector<Image3> fringe;     // cross - black, by index; empty where there is a mesh
  Image3 dots;                    // cross - black
  std::array<Image3, 4> stripes;  // cross - black

  // Photographs are mended for the subject's motion, but their patterns stayed where they were.
  Motion motion;
  Vec3d fringe_moved_mm{0, 0, 0};  // of the subject, at the finest fringes
  PatternPlace dots_place;
  std::array<PatternPlace, 4> stripes_place;

  Mask clipped_projector;                              // in FRONT or BLACK
  Mask clipped_dots, clipped_stripes, clipped_fringe;  // in these; of FRINGE the finest
  float black_level = 0;  // b, estimated: BLACK over FRONT cross, both summed over the subject

  // Right camera; empty where there is none, or a mesh.
  std::vector<Image3> right_fringe;  // cross - black
  Image3 right_front_lit;
  Mask clipped_right;  // in the finest FRINGE, FRONT or BLACK
};

// Masks of clipped pixels are empty where none is.
inline bool is_clipped(const Mask& mask, int y, int x) { return !mask.empty() && mask(y, x); }
inline bool is_clipped(const Mask& mask, const cv::Point& p) { return is_clipped(mask, p.y, p.x); }
inline bool is_clipped(const cv::Mat3b& mask, int y, int x) {
  return !mask.empty() && mask(y, x) != cv::Vec3b(0, 0, 0);
}

// Reads all frames (in parallel) that are not `read` yet. Throws Error that names file and field,
// or with the reason of `check` where it calls the photographs unusable. `mesh`: none where the
// fringes tell the shape.
Burst linearise(const Session& session, const TriangleMesh* mesh = nullptr, Photographs read = {});

// What no later step looks at. A photograph's memory is free once no copy of the burst has it.
void forget_fringes(Burst* burst);    // and what the right camera's are held against
void forget_gradients(Burst* burst);  // but GRADIENT_FULL
void forget_stripes(Burst* burst);    // and BLACK

}  // namespace lamella::fit
