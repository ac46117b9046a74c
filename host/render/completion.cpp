#include "render/completion.h"

#include <algorithm>
#include <functional>
#include <vector>

#include "base/parallel.h"
#include "base/rim.h"
#include "io/doubtful.h"
#include "render/rim.h"

namespace lamella::render {

namespace {

constexpr float kBeyondRimPx = 4;  // triangles two pixels wide that end on it have their corners
// A surface seen from its side falls away fast: the rim goes no further than this a pixel.
constexpr float kLongestRimMm = 3;
constexpr int kRelaxations = 150;
const cv::Point kAround[8] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}};

bool inside(const cv::Mat& map, const cv::Point& p) {
  return p.x >= 0 && p.y >= 0 && p.x < map.cols && p.y < map.rows;
}

template <class Value>
Mask known_pixels(const cv::Mat_<Value>& map) {
  Mask known(map.size(), 0);
  for (int i = 0; i < map.rows; ++i) {
    for (int j = 0; j < map.cols; ++j) known(i, j) = is_finite(map(i, j)) ? 255 : 0;
  }
  return known;
}

// The unknown pixels of `wanted` in the order in which a front that starts at the known ones
// reaches them.
std::vector<cv::Point> inward_order(const Mask& wanted, Mask known) {
  std::vector<cv::Point> order, front;
  for (int i = 0; i < wanted.rows; ++i) {
    for (int j = 0; j < wanted.cols; ++j) {
      if (!wanted(i, j) || known(i, j)) continue;
      const bool touches = std::any_of(kAround, kAround + 4, [&](const cv::Point& d) {
        return inside(known, cv::Point(j, i) + d) && known(cv::Point(j, i) + d);
      });
      if (touches) front.emplace_back(j, i);
    }
  }
  while (!front.empty()) {
    for (const cv::Point& p : front) known(p) = 255;
    order.insert(order.end(), front.begin(), front.end());
    std::vector<cv::Point> next;
    for (const cv::Point& p : front) {
      for (int d = 0; d < 4; ++d) {
        const cv::Point q = p + kAround[d];
        if (!inside(known, q) || known(q) || !wanted(q)) continue;
        known(q) = 1;  // in the next front already
        next.push_back(q);
      }
    }
    front.swap(next);
  }
  return order;
}

template <class Value>
Value mean_of_neighbours(const cv::Mat_<Value>& map, const cv::Point& p, int neighbours) {
  Value sum{};
  float count = 0;
  for (int d = 0; d < neighbours; ++d) {
    const cv::Point q = p + kAround[d];
    if (!inside(map, q) || !is_finite(map(q))) continue;
    sum += map(q);
    ++count;
  }
  return sum * (1 / count);
}

template <class Value>
void fill(const Mask& wanted, cv::Mat_<Value>* map) {
  const std::vector<cv::Point> order = inward_order(wanted, known_pixels(*map));
  for (const cv::Point& p : order) (*map)(p) = mean_of_neighbours(*map, p, 8);
  constexpr float kOverRelaxation = 1.8f;
  for (int n = 0; n < kRelaxations; ++n) {
    for (const cv::Point& p : order) {
      (*map)(p) += (mean_of_neighbours(*map, p, 4) - (*map)(p)) * kOverRelaxation;
    }
  }
}

// One more pixel of `wanted` all around, in the straight continuation of the last two. False where
// there was none.
bool extend_rim(const Mask& wanted, Image3* position_mm) {
  bool any = false;
  const Image3 before = position_mm->clone();
  for (int i = 0; i < before.rows; ++i) {
    for (int j = 0; j < before.cols; ++j) {
      if (!wanted(i, j) || is_finite(before(i, j))) continue;
      Vec3 sum(0, 0, 0);
      float count = 0;
      for (const cv::Point& d : kAround) {
        const cv::Point near = cv::Point(j, i) + d, next = near + d;
        if (!inside(before, next) || !is_finite(before(near)) || !is_finite(before(next))) continue;
        const Vec3 onward = before(near) - before(next);
        sum += before(near) + onward * std::min(1.f, kLongestRimMm / length(onward));
        ++count;
      }
      if (count == 0) continue;
      (*position_mm)(i, j) = sum * (1 / count);
      any = true;
    }
  }
  return any;
}

// Labels spread from the nearest pixel that has one.
void spread_labels(const Mask& wanted, Labels* labels) {
  for (const cv::Point& p : inward_order(wanted, *labels > 0)) {
    for (int d = 0; d < 4 && !(*labels)(p); ++d) {
      if (inside(*labels, p + kAround[d])) (*labels)(p) = (*labels)(p + kAround[d]);
    }
  }
}

void mark_runs(const Mask& known, int longest, bool columns, Mask* holes) {
  const int lines = columns ? known.cols : known.rows, length = columns ? known.rows : known.cols;
  for (int line = 0; line < lines; ++line) {
    const auto at = [&](int k) { return columns ? cv::Point(line, k) : cv::Point(k, line); };
    int last = -1;  // known pixel
    for (int k = 0; k < length; ++k) {
      if (!known(at(k))) continue;
      if (last >= 0 && k - last <= longest) {
        for (int m = last + 1; m < k; ++m) (*holes)(at(m)) = 255;
      }
      last = k;
    }
  }
}

}  // namespace

void fill_smoothly(const Mask& wanted, Image3* map) { fill(wanted, map); }
void fill_smoothly(const Mask& wanted, Image1* map) { fill(wanted, map); }

Mask holes_of(const Mask& known, int longest) {
  Mask holes(known.size(), 0);
  mark_runs(known, longest, false, &holes);
  mark_runs(known, longest, true, &holes);
  return holes;
}

CompleteMaps complete_maps(const LayerMaps& measured) {
  const LayerMaps maps = without_doubtful(measured);
  CompleteMaps result{maps, {}};
  LayerMaps& whole = result.maps;
  whole.position_mm = maps.position_mm.clone();
  const Mask known = known_pixels(maps.position_mm);
  const Mask holes = holes_of(known, maps.position_mm.rows / 9);
  result.inside_px = rim_around(known | holes);
  fill(holes, &whole.position_mm);
  const Mask shown = result.inside_px > -kBeyondRimPx;
  while (extend_rim(shown, &whole.position_mm)) {
  }
  fill(shown, &whole.position_mm);  // where no two pixels in a row say how it goes on
  smooth_along_rim(result.inside_px, &whole.position_mm);
  const Mask wanted = known_pixels(whole.position_mm);
  std::vector<std::function<void()>> jobs{[&] {
    whole.regions = maps.regions.clone();
    spread_labels(wanted, &whole.regions);
  }};
  for (Image3 LayerMaps::*member :
       {&LayerMaps::normal_specular, &LayerMaps::single_albedo, &LayerMaps::shallow_albedo,
        &LayerMaps::deep_albedo, &LayerMaps::deep_ld_mm}) {
    if ((maps.*member).empty()) continue;
    jobs.push_back([&whole, &maps, &wanted, member] {
      whole.*member = (maps.*member).clone();
      fill(wanted, &(whole.*member));
    });
  }
  if (!maps.specular_intensity.empty()) {
    jobs.push_back([&] {
      whole.specular_intensity = maps.specular_intensity.clone();
      fill(wanted, &whole.specular_intensity);
    });
  }
  parallel_for(int(jobs.size()), [&](int i) { jobs[i](); });
  for (Vec3& n : whole.normal_specular) n = unit(n);
  return result;
}

}  // namespace lamella::render
