// Regions of one face are alike: what the dots of one leave open, the others say.
#pragma once

#include <vector>

#include "fit/layer_profile.h"

namespace lamella::fit {

// One standard deviation of the logarithm of l_d over the regions of one face. (Ghosh et al. 2008,
// table 1: forehead and cheek are 0.35 apart in red, 0.01 in green and 0.06 in blue.)
inline constexpr double kRegionSpread = 0.2;

// Of one channel, one profile a region: each l_d weighted with what all of them together let one
// expect, by their deviations and that spread; and the deviation that this leaves. One region alone
// stays as it is.
std::vector<DeepProfile> leaned_on_each_other(std::vector<DeepProfile> regions);

}  // namespace lamella::fit
