// The floor of an error: what the same estimator leaves of it where all else is known.
#pragma once

#include <string>
#include <vector>

#include "apps/bench_figures.h"
#include "io/session.h"
#include "layers.pb.h"

namespace lamella::apps {

// How large the error is where the noise is `noise` times the session's.
struct FloorLevel {
  double noise;
  std::vector<double> errors;  // one a draw of the added noise

  double error() const;  // the median
};

// Errors of noise and of the model are independent: at `noise` times the session's noise the
// square of the error is model^2 + (noise x due_to_noise)^2.
struct NoiseLaw {
  double model = 0, due_to_noise = 0;

  double noise_share() const;  // of the square of the error, at the session's noise
};

// By least squares over the levels, relative to each. NaN where one is not known.
NoiseLaw noise_law(const std::vector<FloorLevel>& levels);

struct Floor {
  size_t figure;                   // index into bench_figures()
  std::string given;               // what was taken from truth
  double error;                    // of the whole fit
  std::vector<FloorLevel> levels;  // rising, one of them at the session's own noise

  double floor() const;  // at the session's own noise
  double ratio() const { return error / floor(); }
  v1::BenchFloor::Verdict verdict() const;
};

// Within so many times its floor a figure counts as reached.
inline constexpr double kReachedRatio = 1.2;
// A floor of which the noise makes less than this (of the square) does not fall with it: it is the
// model's error, and no floor.
inline constexpr double kLeastNoiseShare = 0.5;

// Indices into bench_figures() for each of `names`: a figure's name, its label, its label up to the
// comma (which two may share), or "all". Throws Error that lists the names.
std::vector<size_t> figures_named(const std::vector<std::string>& names);

struct FloorPlan {
  std::vector<size_t> figures;
  std::vector<Session> quieter;  // the same subject with less noise, each with its truth
  int draws = 1;                 // of the noise that is added, at each level
};

// Before anything is fitted: throws Error where the truth of `session` is not whole, its cameras
// state no noise, or one of `plan.quieter` is of another subject or not quieter.
void require_floors(const FloorPlan& plan, const Session& session);

// Floors of `session` at its own noise, with noise added to twice and four times its variance, and
// in the photographs of the quieter ones. `fit_figures`: of the whole fit, as bench_figures().
// Files lie in `scratch`, which is removed. Throws Error where a session has no truth, or another
// subject's.
std::vector<Floor> run_floors(const Session& session, const FloorPlan& plan,
                              const std::vector<double>& fit_figures, const fs::path& scratch);

// For programs and for people; every floor has the same levels.
std::string floor_csv(const std::vector<Floor>& floors);
v1::BenchFloor message_from_floor(const Floor& floor);
std::string floor_table(const std::vector<Floor>& floors);

}  // namespace lamella::apps
