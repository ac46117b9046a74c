// A small session made up from closed forms: a sphere under a handful of LEDs, photographed in all
// twenty steps by two cameras. Enough to be read, checked and spoilt; too coarse to be fitted well.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "io/exr.h"
#include "session.pb.h"

namespace lamella::testing {

inline const cv::Size kFakeSize(24, 32);

// Rig, patterns and subject, without frames.
v1::Session fake_calibration(cv::Size size);

// The frames of one burst, both cameras, without files, in the order of their steps.
std::vector<v1::Frame> fake_frames();

// session.json, frames/ and regions.png ("background", "skin", "lips").
void write_fake_session(const fs::path& folder, cv::Size size = kFakeSize);

// Takes the frames that `is_left_out` names out of session.json.
void leave_out(const fs::path& session, const std::function<bool(const v1::Frame&)>& is_left_out);

// A folder of its own for one test, removed with it.
class ScratchFolder {
 public:
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const fs::path& path() const { return path_; }

  // Names of everything in it, at any depth, relative to it.
  std::set<std::string> contents() const;

 private:
  fs::path path_;
};

}  // namespace lamella::testing
