#include "apps/bench_noise.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "calib/photographs.h"
#include "twin/random.h"

namespace lamella::apps {

namespace {

bool counts_photons(const Camera& camera) {
  return camera.saturation < 1e29 && camera.full_well_electrons > 0;
}

// Of one stored value, quantisation apart.
double noise_variance(const Camera& camera, float stored) {
  const double per_unit =
      counts_photons(camera) ? camera.saturation / camera.full_well_electrons : 0;
  return camera.read_noise * camera.read_noise + per_unit * double(std::max(0.f, stored));
}

void add_noise(const Camera& camera, double times, uint64_t seed, Image3* stored) {
  twin::Random random(seed);
  const double more = times * times - 1;
  const float saturation = float(camera.saturation);
  for (Vec3& pixel : *stored) {
    for (int c = 0; c < 3; ++c) {
      if (pixel[c] >= saturation) continue;
      const float sigma = float(std::sqrt(more * noise_variance(camera, pixel[c])));
      pixel[c] = std::min(saturation, pixel[c] + sigma * random.normal());
    }
  }
}

void require_noise_of(const Camera& camera, const Session& session) {
  if (noise_variance(camera, 1) > 0) return;
  throw_bad_input((session.path / "session.json").string(),
                  "camera " + camera.id + " states no noise, so there is none to multiply",
                  "give read_noise and full_well_electrons");
}

void make_noisier(double times, Camera* camera) {
  camera->read_noise *= times;
  camera->full_well_electrons /= times * times;
}

}  // namespace

Session noisier_session(const Session& session, double times, uint64_t seed,
                        const fs::path& folder) {
  Session noisier = session;
  noisier.path = folder;
  make_noisier(times, &noisier.left);
  if (noisier.right) make_noisier(times, &*noisier.right);
  if (!session.regions_file.empty()) {
    noisier.regions_file = fs::absolute(session.path / session.regions_file).string();
  }
  noisier.frames.clear();
  for (const Frame* frame : frames_to_fit(session)) noisier.frames.push_back(*frame);
  parallel_for(int(noisier.frames.size()), [&](int i) {
    Frame& frame = noisier.frames[size_t(i)];
    Image3 stored = read_exr_rgb(session.path / frame.file);
    add_noise(session.camera(frame.camera), times, twin::mix_bits(seed) + uint64_t(i), &stored);
    frame.file = fmt::format("{:02}.exr", i);
    write_exr_rgb(folder / frame.file, stored);
  });
  return noisier;
}

void require_noise(const Session& session) {
  require_noise_of(session.left, session);
  if (session.right) require_noise_of(*session.right, session);
}

double noise_against(const Session& session, const Session& reference) {
  const auto variance = [](const Camera& camera) {
    return noise_variance(camera, counts_photons(camera) ? 0.5f * float(camera.saturation) : 0);
  };
  return std::sqrt(variance(session.left) / variance(reference.left));
}

}  // namespace lamella::apps
