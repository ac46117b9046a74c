#include "twin/sensor.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "twin/random.h"

namespace lamella::twin {

double gain_per_dn(const Camera& camera) {
  return camera.saturation / (kWhiteLevelDn - kBlackLevelDn);
}

RawImage expose(const Image3& stored, const Camera& camera, uint64_t seed) {
  RawImage raw(stored.size());
  const double electrons = camera.full_well_electrons;
  const float photon = electrons > 0 ? float(camera.saturation / electrons) : 0.f;
  const float read = float(camera.read_noise);
  const float dn_per_stored = float(1.0 / gain_per_dn(camera));
  parallel_for(
      stored.rows,
      [&](int y) {
        Random random(mix_bits(seed) + uint64_t(y) * 0x51ed2701u);
        for (int x = 0; x < stored.cols; ++x) {
          for (int c = 0; c < 3; ++c) {
            const float value = stored(y, x)[c];
            const float variance = std::max(value, 0.f) * photon + read * read;
            const float noisy = value + std::sqrt(variance) * random.normal();
            const float dn = std::round(noisy * dn_per_stored) + float(kBlackLevelDn);
            raw(y, x)[c] = uint16_t(std::clamp(dn, 0.f, float(kWhiteLevelDn)));
          }
        }
      },
      16);
  return raw;
}

Image3 develop(const RawImage& raw, const Camera& camera) {
  Image3 stored(raw.size());
  const float gain = float(gain_per_dn(camera));
  for (int y = 0; y < raw.rows; ++y) {
    for (int x = 0; x < raw.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        stored(y, x)[c] = float(int(raw(y, x)[c]) - kBlackLevelDn) * gain;
      }
    }
  }
  return stored;
}

}  // namespace lamella::twin
