#include "twin/diffusion.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace lamella::twin {

namespace {

constexpr float kFinestSide = 0.4f;  // mm
constexpr float kReach = 16.f;       // mm, where the profiles end
constexpr int kTogether = 4;         // lights convolved in one pass
constexpr float kOpening = 4.5f;     // a patch nearer than this many of its radii is opened

PatchTree::Patch merge(const std::vector<PatchTree::Patch>& parts) {
  PatchTree::Patch whole{{0, 0, 0}, 0, 0};
  Vec3 weighted(0, 0, 0);
  for (const auto& p : parts) {
    weighted += p.centre_mm * p.area_mm2;
    whole.area_mm2 += p.area_mm2;
  }
  whole.centre_mm = weighted * (1.f / std::max(whole.area_mm2, 1e-12f));
  for (const auto& p : parts) {
    whole.radius_mm =
        std::max(whole.radius_mm, length(p.centre_mm - whole.centre_mm) + p.radius_mm);
  }
  return whole;
}

// Mean of the profile over a disc of `radius_mm` whose centre is `r_mm` away: rings that follow
// the integrable peak at the origin where it lies inside.
Rgb4 disc_mean(const std::array<Profile, 3>& profiles, float r_mm, float radius_mm) {
  const bool near = r_mm < 2.5f * radius_mm;
  const int rings = near ? 20 : 4, spokes = near ? 32 : 12;
  Rgb4 sum{};
  for (int i = 0; i < rings; ++i) {
    const float a = radius_mm * std::sqrt((float(i) + 0.5f) / float(rings));
    for (int j = 0; j < spokes; ++j) {
      const float phi = 2.f * kPi * (float(j) + 0.25f + 0.5f * float(i & 1)) / float(spokes);
      const float d = std::sqrt(r_mm * r_mm + a * a + 2.f * r_mm * a * std::cos(phi));
      const int k = int(d / Profile::kStep);
      if (k >= Profile::kCount) continue;
      sum += Rgb4{profiles[0].at(k), profiles[1].at(k), profiles[2].at(k), 0.f};
    }
  }
  return sum * (1.f / float(rings * spokes));
}

}  // namespace

PatchTree::PatchTree(const Surface& surface) {
  Level& finest = levels_[0];
  finest = {surface.rows, surface.columns, {}, 0};
  finest.patches.resize(surface.size());
  for (size_t i = 0; i < surface.size(); ++i) {
    finest.patches[i] = {surface.position_mm[i], 0.f, surface.area_mm2[i]};
  }
  size_ = int(surface.size());
  for (int k = 1; k < kLevels; ++k) {
    const Level& fine = levels_[size_t(k - 1)];
    Level& coarse = levels_[size_t(k)];
    coarse = {(fine.rows + 1) / 2, (fine.columns + 1) / 2, {}, size_};
    coarse.patches.resize(size_t(coarse.rows) * size_t(coarse.columns));
    parallel_for(
        coarse.rows,
        [&](int row) {
          std::vector<Patch> parts;
          for (int column = 0; column < coarse.columns; ++column) {
            parts.clear();
            for (int i = 2 * row; i < std::min(2 * row + 2, fine.rows); ++i) {
              for (int j = 2 * column; j < std::min(2 * column + 2, fine.columns); ++j) {
                parts.push_back(fine.patches[size_t(i * fine.columns + j)]);
              }
            }
            coarse.patches[size_t(row * coarse.columns + column)] = merge(parts);
          }
        },
        8);
    size_ += int(coarse.patches.size());
  }
}

PatchLight gather_light(const PatchTree& tree, const std::vector<Vec3>& irradiance) {
  PatchLight light(size_t(tree.size()), Rgb4{});
  const auto& finest = tree.level(0).patches;
  for (size_t i = 0; i < finest.size(); ++i) {
    const Vec3 power = irradiance[i] * finest[i].area_mm2;
    light[i] = Rgb4{power[0], power[1], power[2], 0.f};
  }
  for (int k = 1; k < PatchTree::kLevels; ++k) {
    const PatchTree::Level &fine = tree.level(k - 1), &coarse = tree.level(k);
    for (int row = 0; row < fine.rows; ++row) {
      const int to = coarse.offset + (row / 2) * coarse.columns;
      const int from = fine.offset + row * fine.columns;
      for (int column = 0; column < fine.columns; ++column) {
        light[size_t(to + column / 2)] += light[size_t(from + column)];
      }
    }
  }
  return light;
}

// A patch as one block of targets sees it.
struct Diffusion::Source {
  Vec3 centre_mm;
  float area_mm2;
  int index;  // over all levels
  int size;   // of the tables
};

Diffusion::Diffusion(const Surface& surface, const SkinProfiles& profiles)
    : tree_(surface), tables_(size_t(kRegionCount * kSizes)) {
  for (int region = 0; region < kRegionCount; ++region) {
    const auto& p = profiles[size_t(region)];
    totals_[size_t(region)] =
        Rgb4{float(p[0].total()), float(p[1].total()), float(p[2].total()), 0.f};
  }
  parallel_for(kRegionCount * kSizes, [&](int i) {
    const float side = kFinestSide * float(1 << (i % kSizes));
    Table& table = tables_[size_t(i)];
    for (int k = 0; k < Profile::kCount; ++k) {
      table[size_t(k)] =
          disc_mean(profiles[size_t(i / kSizes)], Profile::radius_mm(k), side / std::sqrt(kPi));
    }
  });
}

void Diffusion::collect_sources(const Vec3& centre_mm, float radius_mm,
                                std::vector<Source>* sources) const {
  struct Visit {
    int level, row, column;
  };
  std::vector<Visit> open;
  const PatchTree::Level& top = tree_.level(PatchTree::kLevels - 1);
  for (int row = 0; row < top.rows; ++row) {
    for (int column = 0; column < top.columns; ++column) {
      open.push_back({PatchTree::kLevels - 1, row, column});
    }
  }
  while (!open.empty()) {
    const Visit visit = open.back();
    open.pop_back();
    const PatchTree::Level& level = tree_.level(visit.level);
    const int i = visit.row * level.columns + visit.column;
    const PatchTree::Patch& patch = level.patches[size_t(i)];
    const float gap = length(patch.centre_mm - centre_mm) - radius_mm;
    if (gap - patch.radius_mm > kReach) continue;
    if (visit.level == 0 || gap > kOpening * patch.radius_mm) {
      const float side = std::sqrt(patch.area_mm2) / kFinestSide;
      const int size = std::clamp(int(std::lround(std::log2(std::max(side, 0.5f)))), 0, kSizes - 1);
      sources->push_back({patch.centre_mm, patch.area_mm2, level.offset + i, size});
      continue;
    }
    const PatchTree::Level& finer = tree_.level(visit.level - 1);
    for (int row = 2 * visit.row; row < std::min(2 * visit.row + 2, finer.rows); ++row) {
      for (int c = 2 * visit.column; c < std::min(2 * visit.column + 2, finer.columns); ++c) {
        open.push_back({visit.level - 1, row, c});
      }
    }
  }
}

template <int kLights>
void Diffusion::scatter_block(const ScatterTargets& targets, const std::vector<int>& block,
                              const std::vector<const PatchLight*>& lights,
                              std::vector<std::vector<Vec3>>* radiance) const {
  Vec3 low = targets.position_mm[size_t(block[0])], high = low;
  for (int t : block) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], targets.position_mm[size_t(t)][a]);
      high[a] = std::max(high[a], targets.position_mm[size_t(t)][a]);
    }
  }
  const Vec3 centre = (low + high) * 0.5f;
  std::vector<Source> sources;
  collect_sources(centre, length(high - centre), &sources);
  std::vector<Rgb4> power(sources.size() * kLights);
  for (size_t i = 0; i < sources.size(); ++i) {
    for (int s = 0; s < kLights; ++s) {
      power[i * kLights + size_t(s)] = (*lights[size_t(s)])[size_t(sources[i].index)];
    }
  }
  for (int t : block) {
    const Vec3 at = targets.position_mm[size_t(t)];
    for (int region = 0; region < kRegionCount; ++region) {
      const float share = targets.regions[size_t(t)][size_t(region)];
      if (share < 0.004f) continue;
      const Table* tables = &tables_[size_t(region * kSizes)];
      Rgb4 sum[kLights] = {}, norm{};
      for (size_t i = 0; i < sources.size(); ++i) {
        const Vec3 d = sources[i].centre_mm - at;
        const int k = int(std::sqrt(dot(d, d)) * (1.f / Profile::kStep));
        if (k >= Profile::kCount) continue;
        const Rgb4 kernel = tables[sources[i].size][size_t(k)];
        norm += kernel * sources[i].area_mm2;
        for (int s = 0; s < kLights; ++s) sum[s] += kernel * power[i * kLights + size_t(s)];
      }
      const Rgb4 scale = totals_[size_t(region)] * share / norm;
      for (int s = 0; s < kLights; ++s) {
        const Rgb4 out = sum[s] * scale;
        (*radiance)[size_t(s)][size_t(t)] += Vec3(out[0], out[1], out[2]);
      }
    }
  }
}

std::vector<std::vector<Vec3>> Diffusion::scatter(
    const ScatterTargets& targets, const std::vector<const PatchLight*>& lights) const {
  std::vector<std::vector<Vec3>> result;
  for (size_t first = 0; first < lights.size(); first += kTogether) {
    const size_t count = std::min(lights.size() - first, size_t(kTogether));
    std::vector<const PatchLight*> some(lights.begin() + long(first),
                                        lights.begin() + long(first + count));
    if (count > 1) some.resize(kTogether, some.back());  // a full register costs little more
    std::vector<std::vector<Vec3>> part(some.size(), std::vector<Vec3>(targets.position_mm.size()));
    parallel_for(
        int(targets.blocks.size()),
        [&](int b) {
          const std::vector<int>& block = targets.blocks[size_t(b)];
          if (count > 1) {
            scatter_block<kTogether>(targets, block, some, &part);
          } else {
            scatter_block<1>(targets, block, some, &part);
          }
        },
        4);
    part.resize(count);
    for (auto& radiance : part) result.push_back(std::move(radiance));
  }
  return result;
}

}  // namespace lamella::twin
