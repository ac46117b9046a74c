// Photographs with more of their cameras' own noise than they were taken with.
#pragma once

#include "io/session.h"

namespace lamella::apps {

// Those photographs of `session` that a fit reads, written to `folder` with normal deviates added
// so that the noise that the cameras' figures state (photons, reading) is `times` what it was, at
// least 1; and the session of them, whose cameras say so. What was clipped stays it. The same seed
// gives the same noise. Both cameras must state a noise.
Session noisier_session(const Session& session, double times, uint64_t seed,
                        const fs::path& folder);

// Throws Error where a camera of `session` states no noise.
void require_noise(const Session& session);

// How many times the noise of `reference` the left camera of `session` has, in a photograph half
// as bright as the sensor takes; 0 where it has none.
double noise_against(const Session& session, const Session& reference);

}  // namespace lamella::apps
