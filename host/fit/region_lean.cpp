#include "fit/region_lean.h"

#include <cmath>

namespace lamella::fit {

namespace {

constexpr double kSpreadVariance = kRegionSpread * kRegionSpread;

// Of the logarithm.
double variance_of(const DeepProfile& deep) { return std::pow(deep.ld_mm_stddev / deep.ld_mm, 2); }

}  // namespace

std::vector<DeepProfile> leaned_on_each_other(std::vector<DeepProfile> regions) {
  if (regions.size() < 2) return regions;
  double sum = 0, weight = 0;
  for (const DeepProfile& deep : regions) {
    const double w = 1 / (variance_of(deep) + kSpreadVariance);
    sum += w * std::log(deep.ld_mm);
    weight += w;
  }
  const double typical = sum / weight;
  for (DeepProfile& deep : regions) {
    const double own = variance_of(deep), trust = kSpreadVariance / (own + kSpreadVariance);
    deep.ld_mm = std::exp(trust * std::log(deep.ld_mm) + (1 - trust) * typical);
    deep.ld_mm_stddev = deep.ld_mm * std::sqrt(own * trust);
  }
  return regions;
}

}  // namespace lamella::fit
