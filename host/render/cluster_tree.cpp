#include "render/cluster_tree.h"

#include <algorithm>
#include <numeric>

namespace lamella::render {

namespace {

constexpr int kLeafSamples = 8;

float distance_squared(const Vec3& a, const Vec3& b) {
  const Vec3 d = a - b;
  return dot(d, d);
}

int widest_axis(const Vec3& low, const Vec3& high) {
  const Vec3 extent = high - low;
  return extent[0] > extent[1] ? (extent[0] > extent[2] ? 0 : 2) : (extent[1] > extent[2] ? 1 : 2);
}

// Beyond this distance every channel's kernel is nothing.
float reach_mm(const ExitKernels& kernels) {
  float reach = 0;
  for (int c = 0; c < 3; ++c) {
    if (kernels.kernel[c]) {
      reach = std::max(reach, kernels.kernel[c]->reach() / kernels.per_mm[c]);
    }
  }
  return reach;
}

// Light of `flux` (area times irradiance) at distance `r_mm`.
void add(const ExitKernels& kernels, float r_mm, float area_mm2, const Vec3& flux, Gathered* sum) {
  for (int c = 0; c < 3; ++c) {
    if (!kernels.kernel[c]) continue;
    const float k = (*kernels.kernel[c])(r_mm, kernels.per_mm[c]);
    sum->weight[c] += k * area_mm2;
    sum->light[c] += k * flux[c];
  }
}

}  // namespace

ClusterTree::ClusterTree(const std::vector<SurfaceSample>& samples, float opening)
    : samples_(samples), order_(samples.size()), opening_(opening) {
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(samples.size() / 2 + 1);
  if (!samples.empty()) build(0, int(samples.size()));
  std::vector<SurfaceSample> sorted(samples.size());
  for (size_t i = 0; i < sorted.size(); ++i) sorted[i] = samples[order_[i]];
  samples_ = std::move(sorted);
  for (Node& node : nodes_) summarise(&node);
}

int ClusterTree::build(int first, int count) {
  const int index = int(nodes_.size());
  nodes_.push_back({});
  nodes_[index].first = first;
  nodes_[index].count = count;
  if (count > kLeafSamples) {
    Vec3 low = samples_[order_[first]].position_mm, high = low;
    for (int i = first; i < first + count; ++i) {
      for (int a = 0; a < 3; ++a) {
        const float x = samples_[order_[i]].position_mm[a];
        low[a] = std::min(low[a], x);
        high[a] = std::max(high[a], x);
      }
    }
    const int axis = widest_axis(low, high), half = count / 2;
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + half, begin + count, [&](int a, int b) {
      return samples_[a].position_mm[axis] < samples_[b].position_mm[axis];
    });
    build(first, half);
    build(first + half, count - half);
  }
  nodes_[index].skip = int(nodes_.size());
  return index;
}

void ClusterTree::summarise(Node* node) const {
  Vec3 centre(0, 0, 0);
  for (int i = node->first; i < node->first + node->count; ++i) {
    const SurfaceSample& s = samples_[i];
    node->area += s.area_mm2;
    node->flux += s.irradiance * s.area_mm2;
    centre += s.position_mm * s.area_mm2;
  }
  node->centre = node->area > 0 ? centre * (1 / node->area) : samples_[node->first].position_mm;
  float squared = 0;
  for (int i = node->first; i < node->first + node->count; ++i) {
    squared = std::max(squared, distance_squared(samples_[i].position_mm, node->centre));
  }
  node->radius = std::sqrt(squared);
}

Gathered ClusterTree::gather(const Vec3& position_mm, const ExitKernels& kernels) const {
  Gathered sum;
  const float reach = reach_mm(kernels);
  const int end = int(nodes_.size());
  for (int n = 0; n < end;) {
    const Node& node = nodes_[n];
    const float r = std::sqrt(distance_squared(node.centre, position_mm));
    if (r - node.radius > reach) {
      n = node.skip;
    } else if (node.radius < opening_ * r) {
      add(kernels, r, node.area, node.flux, &sum);
      n = node.skip;
    } else if (node.count <= kLeafSamples) {
      for (int i = node.first; i < node.first + node.count; ++i) {
        const SurfaceSample& s = samples_[i];
        add(kernels, std::sqrt(distance_squared(s.position_mm, position_mm)), s.area_mm2,
            s.irradiance * s.area_mm2, &sum);
      }
      n = node.skip;
    } else {
      ++n;
    }
  }
  return sum;
}

}  // namespace lamella::render
