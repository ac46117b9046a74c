// A session folder: the manifest checked and turned into the project's own terms, its frames on
// demand. The format is `proto/session.proto` as proto3 JSON.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/camera.h"
#include "base/light_stage.h"
#include "base/pixel_window.h"
#include "io/exr.h"

namespace lamella {

enum class Role {
  kGradientFull,
  kGradientX,
  kGradientY,
  kGradientZ,
  kFringe,
  kBlack,
  kDots,
  kFront,
  kStripes,
  kAmbient,
  kValidation,
};

enum class Analyser { kParallel, kCross };

const char* role_name(Role role);  // as in the manifest: "GRADIENT_FULL"
const char* analyser_name(Analyser analyser);

struct Frame {
  int step = 0;
  Role role = Role::kBlack;
  int index = 0;
  Analyser analyser = Analyser::kCross;
  std::string camera;  // "left", "right"
  std::string file;    // relative to the session
  double exposure_us = 0;
  double trigger_us = 0;
  std::optional<double> light_on_us, light_off_us;
  Vec3 radiance_scale{1, 1, 1};
  std::string view;                          // VALIDATION only
  Mat33d illuminant_to_led = Mat33d::eye();  // VALIDATION only
};

struct Patterns {
  std::vector<double> fringe_periods{1, 4, 16, 64};
  double stripe_period_px = 8, stripe_shift_px = 2;
  double dot_pitch_px = 53.33, dot_diameter_px = 20;
  cv::Vec2d dot_offset_px{640, 400};
};

struct Session {
  fs::path path;
  std::string subject;
  LightStage stage;
  Camera left;
  std::optional<Camera> right;
  Camera projector;
  Mat33d projector_to_led = Mat33d::eye();
  Patterns patterns;
  std::vector<Frame> frames;
  std::vector<Frame> retaken;             // replaced by frames of the same burst: to look at
  std::string regions_file;               // empty: none
  std::vector<std::string> region_names;  // names[label], names[0] is the background
  Labels given_labels;                    // instead of that file's (given_regions.h); mostly empty
  std::vector<std::string> warnings;      // unknown fields and the like, one line each

  // What is read of a camera's photographs, where it is not all of them: `left` and `right` are
  // then cameras of those pixels alone.
  std::map<std::string, PixelWindow> windows;

  const Camera& camera(const std::string& id) const;  // throws where there is none
  PixelWindow window(const std::string& camera_id) const;

  // The frame with this role, or nullptr.
  const Frame* find(const std::string& camera, Role role, int index, Analyser analyser) const;
};

// Reads and checks `path`/session.json; frames are not opened. Throws Error (kBadInput) that names
// the file and the field.
Session read_session(const fs::path& path);

// Where a fit has the shape of the subject from: the burst's own fringes, or a mesh that is given.
enum class ShapeFrom { kFringes, kMesh };

// What `fit` needs of a left camera: every role of the burst, FRINGE only where the shape comes
// from it. Throws where one is missing.
void require_burst(const Session& session, ShapeFrom shape = ShapeFrom::kFringes);

// One photograph as radiance: stored * radiance_scale, in the colours of its own illuminant.
struct Photograph {
  Image3 radiance;
  // 255 where any channel's stored value is at or above the camera's saturation; empty where none
  // is.
  Mask clipped;
};

// Of its camera's window. Throws where the file is missing, damaged, of another size than its
// camera, or has NaN or infinity, be it outside of the window (with the first such pixel).
Photograph read_photograph(const Session& session, const Frame& frame);

// The label image, in left-camera pixels, of that camera's window. Throws where a label has no
// name, the size disagrees or a named region is empty.
Labels read_regions(const Session& session);

// Throws where there are too many names of regions, one is empty or there twice; the message begins
// with `at`, their list's name.
void require_region_names(const std::vector<std::string>& names, const std::string& at);

}  // namespace lamella
