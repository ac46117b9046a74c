#include "twin/skin.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "twin/random.h"

namespace lamella::twin {

const std::array<const char*, kRegionCount> kRegionNames{"forehead",  "eyelids", "nose",
                                                         "cheekbone", "lips",    "lower_cheek"};

namespace {

constexpr std::array<Skin, kRegionCount> kSkins{{
    {{0.11f, 0.26f, 0.48f},
     {3.1f, 3.9f, 4.7f},
     {0.042f, 0.150f, 0.215f},
     {1.9f, 2.5f, 3.1f},
     0.18f,
     0.30f,
     0.26f},
    {{0.12f, 0.28f, 0.52f},
     {3.0f, 3.8f, 4.6f},
     {0.052f, 0.175f, 0.245f},
     {2.0f, 2.6f, 3.2f},
     0.11f,
     0.26f,
     0.24f},
    {{0.10f, 0.24f, 0.46f},
     {3.2f, 4.0f, 4.8f},
     {0.046f, 0.175f, 0.240f},
     {2.0f, 2.6f, 3.2f},
     0.20f,
     0.21f,
     0.32f},
    {{0.10f, 0.24f, 0.46f},
     {3.0f, 3.8f, 4.6f},
     {0.025f, 0.135f, 0.185f},
     {1.9f, 2.5f, 3.1f},
     0.15f,
     0.32f,
     0.24f},
    {{0.06f, 0.17f, 0.32f},
     {2.9f, 3.7f, 4.5f},
     {0.031f, 0.260f, 0.260f},
     {2.1f, 2.7f, 3.3f},
     0.09f,
     0.24f,
     0.30f},
    {{0.10f, 0.25f, 0.47f},
     {3.1f, 3.9f, 4.7f},
     {0.030f, 0.130f, 0.195f},
     {2.0f, 2.6f, 3.2f},
     0.17f,
     0.34f,
     0.22f},
}};

// Of melanosomes, S. L. Jacques, "Skin optics" (1998): 6.6e11 nm^-3.33 /cm at 610, 540 and 465 nm.
constexpr std::array<float, 3> kMelanosomeAbsorption_per_mm{35.f, 52.5f, 86.f};
// Their share of the epidermis of dark skin. Jacques has 0.11 to 0.43, moderate to dark, of an
// epidermis of 0.06 mm; in the twin's, about 0.15 mm, this is as much melanin as 0.14 of his.
constexpr float kMelanosomesOfDarkSkin = 0.057f;

void make_dark(Skin* skin) {
  for (size_t c = 0; c < 3; ++c) {
    skin->epidermis_absorption_per_mm[c] +=
        kMelanosomesOfDarkSkin * kMelanosomeAbsorption_per_mm[c];
  }
}

// The epidermis is near what Jacques has for skin without melanin and blood (0.033, 0.049 and 0.10
// per mm); the dermis has half the blood.
void make_light(Skin* skin) {
  for (float& absorption : skin->epidermis_absorption_per_mm) absorption *= 0.35f;
  for (float& absorption : skin->dermis_absorption_per_mm) absorption *= 0.5f;
}

void make(SkinKind kind, Skin* skin) {
  switch (kind) {
    case SkinKind::kLayered:
      break;
    case SkinKind::kOneLayer:
      skin->epidermis_mm = 0.f;
      break;
    case SkinKind::kNoSingle:
      skin->single_is_polarized = false;
      break;
    case SkinKind::kDark:
      make_dark(skin);
      break;
    case SkinKind::kLight:
      make_light(skin);
      break;
  }
}

// Mean density in each bin at the radius that halves its area.
struct Density {
  std::array<float, RadialBins::kCount> log_radius, log_density;
};

Density density_of(const std::array<double, RadialBins::kCount>& radial, double floor) {
  Density d;
  for (int i = 0; i < RadialBins::kCount; ++i) {
    const double a = RadialBins::edge_mm(i), b = RadialBins::edge_mm(i + 1);
    const double area = kPi * (b * b - a * a);
    d.log_radius[size_t(i)] = float(0.5 * std::log(0.5 * (a * a + b * b)));
    d.log_density[size_t(i)] = float(std::log(std::max(radial[size_t(i)], floor) / area));
  }
  return d;
}

// Noise of the far, rarely hit bins is smoothed with a kernel that leaves straight lines alone.
void smooth_tail(Density& d) {
  for (int pass = 0; pass < 3; ++pass) {
    const auto before = d.log_density;
    for (int i = RadialBins::kCount / 2; i + 1 < RadialBins::kCount; ++i) {
      d.log_density[size_t(i)] =
          0.25f * before[size_t(i - 1)] + 0.5f * before[size_t(i)] + 0.25f * before[size_t(i + 1)];
    }
  }
}

float interpolate(const Density& d, float r_mm) {
  const float x = std::log(r_mm);
  const auto above = std::upper_bound(d.log_radius.begin(), d.log_radius.end(), x);
  const size_t i =
      std::clamp<size_t>(size_t(above - d.log_radius.begin()), 1, d.log_radius.size() - 1);
  const float t =
      std::max(0.f, (x - d.log_radius[i - 1]) / (d.log_radius[i] - d.log_radius[i - 1]));
  return std::exp(d.log_density[i - 1] + t * (d.log_density[i] - d.log_density[i - 1]));
}

// Tabulates and scales so that the table integrates to what was counted.
void tabulate(const std::array<double, RadialBins::kCount>& radial, double total,
              std::array<float, Profile::kCount>& table) {
  if (total <= 0) return;
  Density density = density_of(radial, 1e-9);
  smooth_tail(density);
  double sum = 0;
  for (int i = 0; i < Profile::kCount; ++i) {
    const float r = Profile::radius_mm(i);
    table[size_t(i)] = interpolate(density, r);
    sum += double(table[size_t(i)]) * 2 * kPi * r * Profile::kStep;
  }
  for (float& value : table) value *= float(total / sum);
}

}  // namespace

SkinKind skin_kind(const std::string& name) {
  if (name == "layered") return SkinKind::kLayered;
  if (name == "one_layer") return SkinKind::kOneLayer;
  if (name == "no_single") return SkinKind::kNoSingle;
  if (name == "dark") return SkinKind::kDark;
  if (name == "light") return SkinKind::kLight;
  throw_bad_input("--skin", "\"" + name + "\"",
                  "the twin knows layered, one_layer, no_single, dark and light");
}

std::array<Skin, kRegionCount> facial_skins(uint64_t seed, SkinKind kind) {
  std::array<Skin, kRegionCount> skins = kSkins;
  Random random(mix_bits(seed) ^ 0x5c17);
  const auto vary = [&](float share) { return 1.f + share * (2.f * random.uniform() - 1.f); };
  const float melanin = vary(0.2f), blood = vary(0.12f);
  for (Skin& skin : skins) {
    make(kind, &skin);
    for (int c = 0; c < 3; ++c) {
      skin.epidermis_absorption_per_mm[size_t(c)] *= melanin;
      skin.dermis_absorption_per_mm[size_t(c)] *= blood;
    }
    skin.epidermis_mm *= vary(0.1f);
    skin.roughness *= vary(0.06f);
    skin.intensity *= vary(0.06f);
  }
  return skins;
}

SlabOptics slab_of(const Skin& skin, int channel) {
  const size_t c = size_t(channel);
  const float g = kPhaseG[c];
  const LayerOptics dermis{
      .absorption_per_mm = skin.dermis_absorption_per_mm[c],
      .scattering_per_mm = skin.dermis_reduced_scattering_per_mm[c] / (1.f - g),
      .g = g};
  LayerOptics upper = dermis;  // of no thickness where there is no epidermis
  if (skin.has_epidermis()) {
    upper.absorption_per_mm = skin.epidermis_absorption_per_mm[c];
    upper.scattering_per_mm = skin.epidermis_reduced_scattering_per_mm[c] / (1.f - g);
  }
  upper.thickness_mm = skin.epidermis_mm;
  return {.upper = upper, .lower = dermis, .ior = kIor};
}

Profile profile_from_walk(const WalkResult& walk) {
  Profile profile;
  profile.single_total = walk.reflected[size_t(Fate::kSingle)];
  profile.shallow_total = walk.reflected[size_t(Fate::kShallow)];
  profile.deep_total = walk.reflected[size_t(Fate::kDeep)];
  tabulate(walk.radial[size_t(Fate::kShallow)], profile.shallow_total, profile.shallow);
  tabulate(walk.radial[size_t(Fate::kDeep)], profile.deep_total, profile.deep);
  return profile;
}

SkinProfiles walk_skins(const std::array<Skin, kRegionCount>& skins, int photons, uint64_t seed) {
  SkinProfiles profiles;
  parallel_for(kRegionCount * 3, [&](int i) {
    const int region = i / 3, channel = i % 3;
    const WalkResult walk = walk_photons(slab_of(skins[size_t(region)], channel), photons,
                                         mix_bits(seed) + uint64_t(i));
    Profile& profile = profiles[size_t(region)][size_t(channel)];
    profile = profile_from_walk(walk);
    // What it would have carried is then absent: neither S nor D has it.
    if (!skins[size_t(region)].single_is_polarized) profile.single_total = 0;
  });
  return profiles;
}

float single_albedo(const Skin& skin, int channel) {
  if (!skin.single_is_polarized) return 0.f;
  const LayerOptics upper = slab_of(skin, channel).upper;
  const float albedo =
      upper.scattering_per_mm / (upper.scattering_per_mm + upper.absorption_per_mm);
  return albedo / (kIor * kIor);
}

}  // namespace lamella::twin
