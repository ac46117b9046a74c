// The procedural head: a closed-eyed adult, eyes at y = +10, crown at +122, chin at -108 mm.
#include <algorithm>

#include "twin/random.h"
#include "twin/skin_texture.h"
#include "twin/solid_noise.h"
#include "twin/solid_shape.h"
#include "twin/subject.h"

namespace lamella::twin {

namespace {

// Proportions that differ from one head to another.
struct Build {
  float nose_mm, jaw_mm, brow_mm, lips_mm, cheek_mm;
};

Build make_build(uint64_t seed) {
  Random random(mix_bits(seed) ^ 0x4ead);
  const auto spread = [&](float mm) { return mm * (2.f * random.uniform() - 1.f); };
  return {spread(2.f), spread(3.f), spread(1.5f), spread(0.8f), spread(2.f)};
}

// All parts take p with x already folded to the right half.

float skull(const Vec3& p, const Build& b) {
  float d = ellipsoid(p, {0, 30, -12}, {73, 89, 97});
  d = join(d, ellipsoid(p, {0, 40, 22}, {57, 46, 63}), 22);                 // forehead
  d = join(d, ellipsoid(p, {0, -32, 12}, {57 + b.jaw_mm, 70, 71}), 30);     // face block
  d = join(d, ellipsoid(p, {46, -14, 16}, {22, 44, 40}), 26);               // temple to jaw
  d = join(d, rod(p, {45 + b.jaw_mm, -58, 8}, {12, -91, 62}, 14, 15), 26);  // jaw line
  return join(d, ellipsoid(p, {0, -90, 69}, {16, 16, 18}), 18);             // chin
}

float neck(const Vec3& p) { return rod(p, {0, -80, -22}, {0, -260, -40}, 48, 54); }

float cheeks_and_brow(float d, const Vec3& p, const Build& b) {
  d = join(d, ellipsoid(p, {43, -9, 55}, {19, 14, 16 + b.cheek_mm}), 24);  // cheekbone
  d = join(d, ellipsoid(p, {30, -42, 61}, {21, 24, 19}), 20);              // cheek
  d = join(d, rod(p, {9, 27, 82}, {40, 29, 67}, 7 + b.brow_mm, 5), 14);    // brow
  return join(d, ellipsoid(p, {0, -49, 69}, {30, 25, 21}), 16);            // mouth rise
}

float eyes(float d, const Vec3& p) {
  d = cut(d, ellipsoid(p, {32, 8, 92}, {17, 11, 13.5f}), 13);              // socket
  d = cut(d, ellipsoid(p, {16, 9, 92}, {7, 9, 8}), 9);                     // inner corner
  d = join(d, ellipsoid(p, {31.5f, 6.5f, 67}, {15, 12.5f, 13.5f}), 3.5f);  // lids over the ball
  const float lash = std::min(rod(p, {18, 4.2f, 76}, {26, 0.6f, 79.7f}, 0.9f, 0.9f),
                              std::min(rod(p, {26, 0.6f, 79.7f}, {37, 0.4f, 79.4f}, 0.9f, 0.9f),
                                       rod(p, {37, 0.4f, 79.4f}, {46, 3.8f, 73}, 0.9f, 0.7f)));
  d = cut(d, lash, 1.6f);
  const float fold = std::min(rod(p, {20, 12, 76}, {31, 16.5f, 78}, 1.1f, 1.3f),
                              rod(p, {31, 16.5f, 78}, {44, 12, 72}, 1.3f, 0.9f));
  return cut(d, fold, 3.f);
}

float nose(float d, const Vec3& p, const Build& b) {
  const float tip_z = 103 + b.nose_mm;
  float n = rod(p, {0, 14, 82}, {0, -17, tip_z - 3}, 5.5f, 7.5f);   // bridge
  n = join(n, ellipsoid(p, {0, -20, tip_z}, {9, 8, 8.5f}), 9);      // tip
  n = join(n, ellipsoid(p, {10.5f, -24, 91}, {7, 7, 10}), 9);       // wing
  n = join(n, rod(p, {0, -26, tip_z - 2}, {0, -33, 90}, 4, 4), 5);  // column
  d = join(d, n, 10);
  d = cut(d, ellipsoid(p, {5.8f, -31.5f, 97}, {3.2f, 2.8f, 5}), 2.5f);  // nostril
  d = cut(d, rod(p, {18, -19, 89}, {19.5f, -29, 89}, 1.f, 1.2f), 5);    // groove of the wing
  return cut(d, rod(p, {21, -30, 89}, {31, -52, 85}, 1.5f, 2.2f), 8);   // fold to the mouth
}

float mouth(float d, const Vec3& p, const Build& b) {
  d = cut(d, rod(p, {0, -37, 97}, {0, -44, 98}, 2.2f, 2.8f), 5);  // philtrum
  const float full = b.lips_mm;
  float upper = rod(p, {4.5f, -49, 91}, {23, -54, 79}, 4.2f + full, 2.f);
  upper = join(upper, rod(p, {0, -50, 91.5f}, {5, -49, 91}, 3.8f + full, 4.2f + full), 3);
  const float lower = rod(p, {0, -60, 88.5f}, {18, -57, 82}, 5.8f + full, 2.6f);
  d = join(d, upper, 3.5f);
  d = join(d, lower, 4.f);
  const float line = std::min(rod(p, {0, -54.6f, 96}, {9, -54, 94.5f}, 1.1f, 1.1f),
                              rod(p, {9, -54, 94.5f}, {26, -55.5f, 83}, 1.1f, 0.9f));
  d = cut(d, line, 2.6f);
  return cut(d, rod(p, {0, -71, 96}, {12, -70, 92}, 5.f, 4.f), 10);  // below the lip
}

float ear(const Vec3& p) {
  const Vec3 centre(74, 0, -14);
  Vec3 q = p - centre;
  q = {0.94f * q[0] - 0.34f * q[2], q[1], 0.34f * q[0] + 0.94f * q[2]};  // stands out a little
  const Vec3 o(0, 0, 0);
  float d = ellipsoid(q, o, {5.5f, 30, 17});
  d = cut(d, ellipsoid(q, {5.5f, 2, 2}, {5.5f, 21, 11}), 3);
  return join(d, ellipsoid(q, {2, -26, 6}, {4, 8, 7}), 4);  // lobe
}

float head_distance(Vec3 p, const Build& b, uint32_t seed) {
  // No face is a mirror image of itself.
  const Vec3 q = p * (1.f / 75.f);
  p += Vec3(solid_noise(q, seed).value, solid_noise(q, seed + 1).value,
            solid_noise(q, seed + 2).value) *
       1.2f;
  p[0] = std::abs(p[0]);
  float d = skull(p, b);
  d = cheeks_and_brow(d, p, b);
  d = eyes(d, p);
  d = nose(d, p, b);
  d = mouth(d, p, b);
  d = join(d, neck(p), 18);
  return join(d, ear(p), 5);
}

// 1 inside the ellipse in the front view, 0 outside, over about 2 `soft` mm.
float oval(const Vec3& p, float x, float y, float rx, float ry, float soft) {
  const float dx = (p[0] - x) / rx, dy = (p[1] - y) / ry;
  const float inside = (1.f - std::sqrt(dx * dx + dy * dy)) * std::min(rx, ry);
  return smooth_step(-soft, soft, inside);
}

float lip_cover(const Vec3& p) {
  const float bow = 46.2f + 0.9f * smooth_step(3.f, 0.f, p[0]) + 0.36f * std::max(0.f, p[0] - 6.f);
  const float under = 66.5f - 0.42f * std::max(0.f, p[0] - 7.f);
  const float within = std::min(-bow - p[1], p[1] + under);
  return smooth_step(-1.2f, 1.2f, std::min(within, 26.5f - p[0]));
}

RegionWeights head_regions(Vec3 p) {
  p[0] = std::abs(p[0]);
  RegionWeights w{};
  const auto paint = [&](int region, float cover) {
    for (float& x : w) x *= 1.f - cover;
    w[size_t(region)] += cover;
  };
  w[5] = 1.f;
  paint(0, smooth_step(19.f, 25.f, p[1] + 0.12f * p[0]));
  paint(3, oval(p, 46, -9, 25, 20, 3.5f));
  paint(1, oval(p, 31.5f, 8, 19, 13, 2.f));
  const float nose_width = 9.f + 10.f * smooth_step(0.f, -24.f, p[1]);
  const float along = smooth_step(-37.f, -33.f, p[1]) * smooth_step(22.f, 16.f, p[1]);
  paint(2, along * smooth_step(nose_width + 2.f, nose_width - 2.f, p[0]));
  paint(4, lip_cover(p));
  return w;
}

bool head_labelled(const Vec3& p) {
  const float y = p[1] > 0 ? p[1] / 96.f : p[1] / 104.f;
  const float x = p[0] / 66.f;
  return p[2] > 5.f && x * x + y * y < 1.f;
}

// Brows: strands of hair that shadow the skin.
float brow_cover(Vec3 p, uint32_t seed) {
  if (p[2] < 0.f) return 0.f;
  p[0] = std::abs(p[0]);
  const float arch =
      26.5f + 5.5f * smooth_step(8.f, 34.f, p[0]) - 6.f * smooth_step(34.f, 56.f, p[0]);
  const float half = 4.8f * smooth_step(56.f, 26.f, p[0]) + 0.6f;
  const float across = std::abs(p[1] - arch) / half;
  const float along = smooth_step(9.f, 15.f, p[0]) * smooth_step(54.f, 42.f, p[0]);
  const Vec3 strand(p[0] * 1.1f - p[1] * 0.5f, p[1] * 0.25f + p[0] * 0.05f, p[2] * 0.1f);
  const float hair = 0.72f + 0.5f * fractal_noise(strand, 2, seed);
  return std::clamp(along * smooth_step(1.15f, 0.55f, across) * hair, 0.f, 1.f);
}

Vec3 head_albedo(const Vec3& p, const SkinTexture& texture, uint32_t seed) {
  Vec3 factor = texture.albedo(p);
  const float brow = 0.62f * brow_cover(p, seed);
  factor = factor.mul(Vec3(1.f - brow, 1.f - 1.02f * brow, 1.f - 1.02f * brow));
  const Vec3 m(std::abs(p[0]), p[1], p[2]);
  const float lash = oval(m, 32, 1.6f, 14, 1.1f, 0.7f);
  return factor * (1.f - 0.45f * lash);
}

}  // namespace

Subject make_head(uint64_t seed) {
  const SkinTexture texture(seed);
  const Build build = make_build(seed);
  const uint32_t grain = uint32_t(mix_bits(seed ^ 0xb0b));
  Subject s;
  s.name = "head";
  s.centre_mm = {0, 30, -5};
  s.axis_length_mm = 150;
  s.distance_mm = [build, grain](const Vec3& p) { return head_distance(p, build, grain); };
  s.regions = head_regions;
  s.labelled = head_labelled;
  s.albedo_modulation = [texture, grain](const Vec3& p) { return head_albedo(p, texture, grain); };
  s.intensity_modulation = [texture](const Vec3& p) { return texture.intensity(p); };
  s.shading_normal = [texture](const Vec3& p, const Vec3& n) { return texture.bumped(p, n, 1.f); };
  return s;
}

}  // namespace lamella::twin
