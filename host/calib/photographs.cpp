#include "calib/photographs.h"

#include "base/parallel.h"

namespace lamella {

bool has_right_geometry(const Session& session) {
  if (!session.right) return false;
  for (size_t i = 0; i < session.patterns.fringe_periods.size(); ++i) {
    if (!session.find("right", Role::kFringe, int(i), Analyser::kCross)) return false;
  }
  return session.find("right", Role::kFront, 0, Analyser::kCross) &&
         session.find("right", Role::kBlack, 0, Analyser::kCross);
}

std::vector<const Frame*> frames_to_fit(const Session& session, ShapeFrom shape) {
  std::vector<const Frame*> frames;
  const auto add = [&](const char* camera, Role role, int index, Analyser analyser) {
    const Frame* frame = session.find(camera, role, index, analyser);
    if (frame) frames.push_back(frame);
  };
  const bool has_mesh = shape == ShapeFrom::kMesh;
  const int fringes = has_mesh ? 0 : int(session.patterns.fringe_periods.size());
  for (Role role : {Role::kGradientFull, Role::kGradientX, Role::kGradientY, Role::kGradientZ,
                    Role::kFront, Role::kAmbient}) {
    add("left", role, 0, Analyser::kParallel);
    add("left", role, 0, Analyser::kCross);
  }
  for (int i = 0; i < fringes; ++i) add("left", Role::kFringe, i, Analyser::kCross);
  for (int i = 0; i < 4; ++i) add("left", Role::kStripes, i, Analyser::kCross);
  add("left", Role::kBlack, 0, Analyser::kCross);
  add("left", Role::kDots, 0, Analyser::kCross);
  if (has_mesh || !has_right_geometry(session)) return frames;
  for (int i = 0; i < fringes; ++i) add("right", Role::kFringe, i, Analyser::kCross);
  add("right", Role::kFront, 0, Analyser::kCross);
  add("right", Role::kBlack, 0, Analyser::kCross);
  return frames;
}

Photographs read_photographs(const Session& session, const std::vector<const Frame*>& frames) {
  std::vector<Photograph> read(frames.size());
  const size_t half = (frames.size() + 1) / 2;  // a loop's halves go to two processors
  parallel_for(int(frames.size()), [&](int i) {
    const size_t k = size_t(i) < half ? 2 * size_t(i) : 2 * (size_t(i) - half) + 1;
    read[k] = read_photograph(session, *frames[k]);
  });
  Photographs photographs;
  for (size_t i = 0; i < frames.size(); ++i) photographs[frames[i]] = std::move(read[i]);
  return photographs;
}

}  // namespace lamella
