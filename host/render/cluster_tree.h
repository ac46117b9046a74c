// Lit surface points in a hierarchy, so that what scatters out at one point is gathered from its
// neighbours one by one and from the distance in clusters (Jensen and Buhler 2002).
#pragma once

#include <array>
#include <vector>

#include "base/vec.h"
#include "render/kernel.h"

namespace lamella::render {

struct SurfaceSample {
  Vec3 position_mm;
  float area_mm2;
  Vec3 irradiance;  // radiance of a white surface lying there
};

// How light leaves at one point: a kernel and its scale for each channel.
struct ExitKernels {
  std::array<const RadialKernel*, 3> kernel{};  // nullptr: light leaves where it enters
  Vec3 per_mm{1, 1, 1};                         // one over the kernel's length

  bool any() const { return kernel[0] || kernel[1] || kernel[2]; }
};

// Sums over the surface, per channel.
struct Gathered {
  Vec3 light{0, 0, 0};   // sum of kernel x area x irradiance
  Vec3 weight{0, 0, 0};  // sum of kernel x area: 1 on a flat, endless surface
};

class ClusterTree {
 public:
  // `opening`: a cluster stands for its points when its radius over its distance is below this.
  ClusterTree(const std::vector<SurfaceSample>& samples, float opening);

  Gathered gather(const Vec3& position_mm, const ExitKernels& kernels) const;

  // Positions of the samples in the order of the tree: neighbours lie together.
  const std::vector<int>& order() const { return order_; }

 private:
  struct Node {
    Vec3 centre;  // area-weighted
    float radius;
    Vec3 flux;  // sum of area x irradiance
    float area;
    int first, count;  // of the samples, in the tree's order
    int skip;          // next node when this one needs no opening; nodes are depth first
  };

  int build(int first, int count);
  void summarise(Node* node) const;

  std::vector<SurfaceSample> samples_;  // in the tree's order
  std::vector<int> order_;
  std::vector<Node> nodes_;
  float opening_;
};

}  // namespace lamella::render
