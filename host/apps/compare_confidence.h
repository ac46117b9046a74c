// Error against confidence: whether a map is wrong less where the fit is surer of it.
#pragma once

#include <string>
#include <vector>

#include "apps/compare_maps.h"

namespace lamella::apps {

// Pixels of like confidence.
struct ConfidenceBin {
  double least_confidence, mean_confidence;  // 0 to 1
  size_t pixels;
  double median_error, p95_error;  // in the unit of the map's errors
};

// Up to ten bins of about as many pixels each, from the least sure to the most. Pixels of the same
// confidence stay together, so there are fewer bins where it has few values. A pixel without a
// finite confidence and error counts nowhere; none under 100 that do.
std::vector<ConfidenceBin> confidence_bins(const std::vector<double>& confidence,
                                           const std::vector<double>& error);

// Whether the median error falls as confidence rises, in its order (rank correlation over the bins
// of -0.6 or less, which chance gives to one noise in thirty) and in its size (a fifth more in the
// first bin than in the last). Not for a single bin.
bool falls(const std::vector<ConfidenceBin>& bins);

struct PixelErrors {
  std::vector<double> value;  // NaN where the map or the truth is not known
  const char* unit = "";      // as the end of a name: "mm", "deg", "percent"
};

// Of a map by its name: position in mm; normals in degrees, diffuse ones in the mean of the three
// channels; others in percent, the length of the difference over that of the true colour.
PixelErrors pixel_errors(const std::string& map, const MapValues& found, const MapValues& truth);

// mean, and where there are errors spearman_confidence_vs_error (-1 is a perfect ranking), unit,
// falls (null where there is one bin) and the curve, a bin an object: confidence_least,
// confidence_mean, pixels, error_median_mm, error_p95_mm, or whatever the unit is.
Json confidence_figures(const std::vector<double>& confidence, const PixelErrors& errors);

// One map's curve, out of a comparison's report.
struct ConfidenceCurve {
  std::string map, label, unit;  // "deep_albedo", "deep albedo", "percent"
  bool falls = false;
  std::vector<ConfidenceBin> bins;
};

// From the shape to the skin.
std::vector<ConfidenceCurve> confidence_curves_of(const Json& comparison);

// "mm", "degrees", "%".
std::string unit_words(const std::string& unit);

}  // namespace lamella::apps
