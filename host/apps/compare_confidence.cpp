#include "apps/compare_confidence.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lamella::apps {

namespace {

constexpr size_t kMostBins = 10, kFewestPixels = 100;
constexpr double kLargestRankCorrelation = -0.6, kLeastFall = 1.2;

struct SurePixel {
  double confidence, error;
};

std::vector<SurePixel> sorted_pixels(const std::vector<double>& confidence,
                                     const std::vector<double>& error) {
  std::vector<SurePixel> pixels;
  for (size_t i = 0; i < error.size(); ++i) {
    if (!std::isfinite(error[i]) || !std::isfinite(confidence[i])) continue;
    pixels.push_back({confidence[i], error[i]});
  }
  std::stable_sort(pixels.begin(), pixels.end(), [](const SurePixel& a, const SurePixel& b) {
    return a.confidence < b.confidence;
  });
  return pixels;
}

using Pixels = std::vector<SurePixel>::const_iterator;

ConfidenceBin bin_of(Pixels begin, Pixels end) {
  std::vector<double> error;
  double sum = 0;
  for (Pixels p = begin; p != end; ++p) {
    error.push_back(p->error);
    sum += p->confidence;
  }
  return {begin->confidence, sum / double(error.size()), error.size(), median(error),
          percentile(error, 0.95)};
}

std::vector<ConfidenceBin> bins_of(const std::vector<SurePixel>& pixels) {
  std::vector<ConfidenceBin> bins;
  if (pixels.size() < kFewestPixels) return bins;
  // Pixels of one confidence belong where the middle one of them does.
  const auto bin_at = [&](Pixels begin, Pixels end) {
    const size_t middle = size_t(begin - pixels.begin()) + size_t(end - begin) / 2;
    return std::min(kMostBins - 1, kMostBins * middle / pixels.size());
  };
  const auto ties_end = [&](Pixels begin) {
    return std::find_if(begin, pixels.end(),
                        [&](const SurePixel& p) { return p.confidence != begin->confidence; });
  };
  for (Pixels begin = pixels.begin(), end; begin != pixels.end(); begin = end) {
    end = ties_end(begin);
    const size_t bin = bin_at(begin, end);
    for (Pixels next; end != pixels.end(); end = next) {
      next = ties_end(end);
      if (bin_at(end, next) != bin) break;
    }
    bins.push_back(bin_of(begin, end));
  }
  return bins;
}

double rank_correlation_of(const std::vector<SurePixel>& pixels) {
  std::vector<double> confidence, error;
  for (const SurePixel& p : pixels) {
    confidence.push_back(p.confidence);
    error.push_back(p.error);
  }
  return rank_correlation(confidence, error);
}

double norm_at(const MapValues& map, size_t pixel) {
  double squares = 0;
  for (const auto& channel : map.channels) squares += channel[pixel] * channel[pixel];
  return std::sqrt(squares);
}

double difference_at(const MapValues& a, const MapValues& b, size_t pixel) {
  double squares = 0;
  for (size_t c = 0; c < a.channels.size(); ++c) {
    const double d = a.channels[c][pixel] - b.channels[c][pixel];
    squares += d * d;
  }
  return std::sqrt(squares);
}

double mean_degrees_at(const MapValues& a, const MapValues& b, size_t pixel) {
  const int normals = int(a.channels.size()) / 3;
  double sum = 0;
  for (int n = 0; n < normals; ++n) {
    sum += degrees_between(a.vector(pixel, 3 * n), b.vector(pixel, 3 * n));
  }
  return sum / normals;
}

Json json_from_bin(const ConfidenceBin& bin, const std::string& unit) {
  return {{"confidence_least", bin.least_confidence},
          {"confidence_mean", bin.mean_confidence},
          {"pixels", bin.pixels},
          {"error_median_" + unit, number(bin.median_error)},
          {"error_p95_" + unit, number(bin.p95_error)}};
}

ConfidenceBin bin_from_json(const Json& bin, const std::string& unit) {
  return {bin["confidence_least"], bin["confidence_mean"], bin["pixels"],
          bin["error_median_" + unit], bin["error_p95_" + unit]};
}

struct MapLabel {
  const char *map, *label;
};
constexpr MapLabel kLabels[] = {{"position", "position"},
                                {"normal_specular", "specular normal"},
                                {"normal_diffuse", "diffuse normals"},
                                {"specular_intensity", "specular c"},
                                {"single_albedo", "single albedo"},
                                {"total_albedo", "total albedo"},
                                {"shallow_albedo", "shallow albedo"},
                                {"deep_albedo", "deep albedo"},
                                {"deep_alpha", "deep alpha"},
                                {"deep_ld", "deep l_d"}};

const MapLabel* label_of(const std::string& map) {
  return std::find_if(std::begin(kLabels), std::end(kLabels),
                      [&](const MapLabel& known) { return map == known.map; });
}

}  // namespace

std::vector<ConfidenceBin> confidence_bins(const std::vector<double>& confidence,
                                           const std::vector<double>& error) {
  return bins_of(sorted_pixels(confidence, error));
}

bool falls(const std::vector<ConfidenceBin>& bins) {
  if (bins.size() < 2) return false;
  std::vector<double> order(bins.size()), error;
  std::iota(order.begin(), order.end(), 0);
  for (const ConfidenceBin& bin : bins) error.push_back(bin.median_error);
  return error.front() >= kLeastFall * error.back() &&
         rank_correlation(order, error) <= kLargestRankCorrelation;
}

PixelErrors pixel_errors(const std::string& map, const MapValues& found, const MapValues& truth) {
  const bool is_normal = map.starts_with("normal"), is_position = map == "position";
  PixelErrors errors{std::vector<double>(truth.channels[0].size(), kNaN), is_position ? "mm"
                                                                          : is_normal ? "deg"
                                                                                      : "percent"};
  for (size_t i = 0; i < errors.value.size(); ++i) {
    if (!found.known(i) || !truth.known(i)) continue;
    errors.value[i] = is_normal     ? mean_degrees_at(found, truth, i)
                      : is_position ? difference_at(found, truth, i)
                                    : 100 * difference_at(found, truth, i) / norm_at(truth, i);
  }
  return errors;
}

Json confidence_figures(const std::vector<double>& confidence, const PixelErrors& errors) {
  const std::vector<double> known = finite(confidence);
  Json out{
      {"mean", number(std::accumulate(known.begin(), known.end(), 0.0) / double(known.size()))}};
  const std::vector<SurePixel> pixels = sorted_pixels(confidence, errors.value);
  const std::vector<ConfidenceBin> bins = bins_of(pixels);
  if (bins.empty()) return out;
  if (pixels.front().confidence < pixels.back().confidence) {
    out["spearman_confidence_vs_error"] = number(rank_correlation_of(pixels));
  }
  out["unit"] = errors.unit;
  out["falls"] = bins.size() > 1 ? Json(falls(bins)) : Json();
  out["curve"] = Json::array();
  for (const ConfidenceBin& bin : bins) out["curve"].push_back(json_from_bin(bin, errors.unit));
  return out;
}

std::vector<ConfidenceCurve> confidence_curves_of(const Json& comparison) {
  std::vector<ConfidenceCurve> curves;
  if (!comparison.contains("confidence")) return curves;
  for (const auto& [map, figures] : comparison["confidence"].items()) {
    if (!figures.contains("curve")) continue;
    const MapLabel* known = label_of(map);
    ConfidenceCurve curve{map,
                          known == std::end(kLabels) ? map : known->label,
                          figures["unit"],
                          figures["falls"] == true,
                          {}};
    for (const Json& bin : figures["curve"]) curve.bins.push_back(bin_from_json(bin, curve.unit));
    curves.push_back(curve);
  }
  std::stable_sort(curves.begin(), curves.end(),
                   [](const ConfidenceCurve& a, const ConfidenceCurve& b) {
                     return label_of(a.map) < label_of(b.map);
                   });
  return curves;
}

std::string unit_words(const std::string& unit) {
  return unit == "deg" ? "degrees" : unit == "percent" ? "%" : unit;
}

}  // namespace lamella::apps
