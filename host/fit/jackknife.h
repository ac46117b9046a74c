// Deviations by leaving out: what of a figure changes with the data, whatever their noise is.
#pragma once

#include <cmath>
#include <vector>

namespace lamella::fit {

// Deviation of a figure from its values without each of as many equal parts of the data; 0 of fewer
// than two.
inline double jackknife_stddev(const std::vector<double>& without_part) {
  const double count = double(without_part.size());
  if (count < 2) return 0;
  double mean = 0, square = 0;
  for (double value : without_part) mean += value / count;
  for (double value : without_part) square += (value - mean) * (value - mean);
  return std::sqrt(square * (count - 1) / count);
}

}  // namespace lamella::fit
