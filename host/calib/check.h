// Is a session fit to be fitted, and why not: what a photographer would look at first.
#pragma once

#include <string>
#include <vector>

#include "calib/photographs.h"
#include "io/session.h"

namespace lamella {

enum class Grade {
  kGood,
  kNote,  // nothing wrong, but worth knowing
  kPoor,  // usable, below the quality asked
  kUnusable,
};

const char* grade_name(Grade grade);  // "good", "note", "poor", "unusable"

struct CheckLine {
  Grade grade = Grade::kGood;
  std::string name;   // "clipped, LEDs"
  std::string text;   // the finding in words and units
  double figure = 0;  // the same as a number, in `unit`
  std::string unit;   // "%", "us", "" for a ratio
  double limit = 0;   // beyond it the line is poor; 0 where there is none
};

struct SessionCheck {
  std::vector<CheckLine> lines;

  Grade worst() const;

  // The first line that makes the session unusable, for whoever wants one sentence.
  const CheckLine* reason() const;
};

// Every photograph is read. Throws Error only where there is no readable manifest; everything else
// is a line.
SessionCheck check_session(const fs::path& path);

// The same of a burst that is in memory: the rig, the figures of the photographs that a fit needs
// (`frames_to_fit` with the same `shape`, all of them) and the timing. `labels` may be empty.
SessionCheck check_burst(const Session& session, const Photographs& photographs,
                         const Labels& labels, ShapeFrom shape = ShapeFrom::kFringes);

// Throws Error with the reason where the session is unusable.
void require_usable(const SessionCheck& check);

}  // namespace lamella
