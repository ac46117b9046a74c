#include "fit/smooth.h"

#include <cmath>

#include "base/parallel.h"

namespace lamella::fit {

namespace {

// Both sides of the middle.
float sum_of(const std::vector<float>& taps) {
  float sum = -taps[0];
  for (float t : taps) sum += 2 * t;
  return sum;
}

// Of two averages' weights.
float product(const std::vector<float>& a, const std::vector<float>& b) {
  float sum = -a[0] * b[0];
  for (size_t k = 0; k < std::min(a.size(), b.size()); ++k) sum += 2 * a[k] * b[k];
  return sum / (sum_of(a) * sum_of(b));
}

// A row of spans under way: `open` where no step has ended them yet.
struct SpanRow {
  std::vector<int> open, span;

  explicit SpanRow(const float* here, int cols)
      : open(static_cast<size_t>(cols)), span(open.size(), 0) {
    for (size_t x = 0; x < open.size(); ++x) open[x] = here[x] == here[x] ? 1 : 0;
  }

  // With neighbours `k` to either side of the pixels from `x0` to `x1`; the others have none.
  void extend(const float* here, const float* before, const float* after, cv::Range x,
              float limit_mm) {
    std::fill(open.begin(), open.begin() + x.start, 0);
    std::fill(open.begin() + x.end, open.end(), 0);
    for (int i = x.start; i < x.end; ++i) {
      const int goes_on = int(std::abs(before[i] - here[i]) < limit_mm) &
                          int(std::abs(after[i] - here[i]) < limit_mm);
      open[size_t(i)] &= goes_on;
      span[size_t(i)] += open[size_t(i)];
    }
  }

  void store(const float* here, uchar* to) const {
    for (size_t x = 0; x < span.size(); ++x) {
      to[x] = here[x] == here[x] ? uchar(span[x]) : SurfaceSpan::kOff;
    }
  }
};

// One pass of an average, along rows or columns.
class Pass {
 public:
  explicit Pass(const std::vector<float>& taps) : taps_(taps), per_weight_(taps.size()) {
    float weight = -taps[0];
    for (size_t k = 0; k < taps.size(); ++k) {
      weight += 2 * taps[k];
      per_weight_[k] = 1 / weight;
    }
  }

  int reach() const { return int(taps_.size()) - 1; }

  // A row of `channels`; `step`: floats from a pixel to its neighbour in the pass's direction.
  void row(const float* from, const uchar* span, const cv::Size& shape, ptrdiff_t step,
           float* to) const {
    const int cols = shape.width, channels = shape.height;
    for (int x = 0, end; x < cols; x = end) {
      const int reach_here = reach_of(span[x]);
      end = x + 1;
      while (end < cols && end - x < kMostPixels && reach_of(span[end]) == reach_here) ++end;
      if (reach_here < 0) continue;
      average(from + x * channels, {(end - x) * channels, reach_here}, step, to + x * channels);
    }
  }

 private:
  static constexpr int kMostPixels = 32;

  int reach_of(uchar span) const {
    return span == SurfaceSpan::kOff ? -1 : std::min(int(span), reach());
  }

  struct Run {
    int floats, reach;
  };

  void average(const float* from, const Run& run, ptrdiff_t step, float* to) const {
    float sum[kMostPixels * detail::kMostChannels];
    for (int i = 0; i < run.floats; ++i) sum[i] = from[i] * taps_[0];
    for (int k = 1; k <= run.reach; ++k) {
      const float tap = taps_[size_t(k)];
      const float *before = from - k * step, *after = from + k * step;
      for (int i = 0; i < run.floats; ++i) sum[i] += (before[i] + after[i]) * tap;
    }
    for (int i = 0; i < run.floats; ++i) to[i] = sum[i] * per_weight_[size_t(run.reach)];
  }

  const std::vector<float>& taps_;
  std::vector<float> per_weight_;
};

// Rows of the image that are smoothed at a time: what lies between the two passes stays in cache.
struct Band {
  int first, last;                // rows to smooth
  int first_needed, last_needed;  // and those that they are averaged from
};

void smooth_band(const cv::Mat& image, const SurfaceSpan& span, const Pass& pass, const Band& band,
                 cv::Mat* to) {
  const cv::Size shape(image.cols, image.channels());
  cv::Mat rows(band.last_needed - band.first_needed, image.cols, image.type());
  for (int y = band.first_needed; y < band.last_needed; ++y) {
    pass.row(image.ptr<float>(y), span.along_row()[y], shape, image.channels(),
             rows.ptr<float>(y - band.first_needed));
  }
  const auto step = ptrdiff_t(rows.step1());
  for (int y = band.first; y < band.last; ++y) {
    pass.row(rows.ptr<float>(y - band.first_needed), span.along_column()[y], shape, step,
             to->ptr<float>(y));
  }
}

}  // namespace

std::vector<float> gaussian_taps(float sigma_px) {
  std::vector<float> taps;
  const int reach = int(std::ceil(2 * sigma_px));
  for (int k = 0; k <= reach; ++k) {
    taps.push_back(std::exp(-0.5f * float(k * k) / (sigma_px * sigma_px)));
  }
  return taps;
}

float noise_gain(const std::vector<float>& taps) {
  const float one = product(taps, taps);
  return one * one;
}

float noise_gain(const std::vector<float>& fine, const std::vector<float>& coarse) {
  const float both = product(fine, coarse);
  return noise_gain(fine) - 2 * both * both + noise_gain(coarse);
}

SurfaceSpan::SurfaceSpan(const Image1& distance_mm, float px_mm, int most_px)
    : along_row_(distance_mm.size()), along_column_(distance_mm.size()) {
  const int rows = distance_mm.rows, cols = distance_mm.cols;
  parallel_for(rows, [&](int y) {
    const float* here = distance_mm[y];
    SpanRow along_row(here, cols), along_column(here, cols);
    for (int k = 1; k <= std::min({most_px, 254, (cols - 1) / 2}); ++k) {
      along_row.extend(here, here - k, here + k, {k, cols - k}, silhouette_step_mm(k, px_mm));
    }
    for (int k = 1; k <= std::min({most_px, 254, y, rows - 1 - y}); ++k) {
      along_column.extend(here, distance_mm[y - k], distance_mm[y + k], {0, cols},
                          silhouette_step_mm(k, px_mm));
    }
    along_row.store(here, along_row_[y]);
    along_column.store(here, along_column_[y]);
  });
}

SurfaceSpan span_for(const Image1& distance_mm, float px_mm, float width_px) {
  return {distance_mm, px_mm, int(std::ceil(2 * width_px))};
}

void detail::smooth_floats(const cv::Mat& image, const SurfaceSpan& span, float width_px,
                           cv::Mat* to) {
  const std::vector<float> taps = gaussian_taps(width_px);
  const Pass pass(taps);
  const int height = std::clamp(8 * pass.reach(), 64, 256);
  parallel_for((image.rows + height - 1) / height, [&](int i) {
    const int first = i * height, last = std::min(image.rows, first + height);
    smooth_band(
        image, span, pass,
        {first, last, std::max(0, first - pass.reach()), std::min(image.rows, last + pass.reach())},
        to);
  });
}

}  // namespace lamella::fit
