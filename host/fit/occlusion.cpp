#include "fit/occlusion.h"

#include "base/parallel.h"

namespace lamella::fit {

namespace {

using Moments4 = cv::Vec4f;  // C, 2 G_a - C

Vec3 direction_of(const Moments4& m) {
  const float full = std::max(m[0], 1e-9f);
  return {m[1] / full, m[2] / full, m[3] / full};
}

OcclusionAtNode occlusion_at(const Surroundings& around, size_t node, const LedsFrom& leds,
                             const std::vector<float>& solid_angle_sr, const Vec3& normal,
                             const cv::Mat_<DiffuseMoments>& moments) {
  std::array<Moments4, 3> lit{}, free{};
  for (size_t i = 0; i < leds.count(); ++i) {
    const float cosine = dot(normal, leds.towards(i));
    if (cosine <= 0) continue;
    const int32_t blocker = around.at(node, i);
    const Vec3 axis = leds.axis(i), irradiance = leds.irradiance(i);
    for (int c = 0; c < 3; ++c) {
      const Moments4 direct = Moments4(1, axis[0], axis[1], axis[2]) * (cosine * irradiance[c]);
      free[size_t(c)] += direct;
      if (!around.hidden(node, i)) lit[size_t(c)] += direct;
      if (blocker < 0) continue;
      const DiffuseMoments& m = moments(blocker / moments.cols, blocker % moments.cols);
      lit[size_t(c)] += Moments4(m[4 * c], m[4 * c + 1], m[4 * c + 2], m[4 * c + 3]) *
                        (cosine * solid_angle_sr[i] / kPi);
    }
  }
  OcclusionAtNode o;
  float seen = 0, all = 0;
  for (size_t i = 0; i < leds.count(); ++i) {
    const float gives = std::max(0.f, dot(normal, leds.towards(i))) * mean(leds.irradiance(i));
    all += gives;
    if (!around.hidden(node, i)) seen += gives;
  }
  o.ambient_visibility = all > 0 ? seen / all : 1.f;
  for (size_t c = 0; c < 3; ++c) o.bend[c] = direction_of(lit[c]) - direction_of(free[c]);
  return o;
}

}  // namespace

std::vector<OcclusionAtNode> occlusion_at_nodes(const Surroundings& around, const LightStage& stage,
                                                const Image3& position_mm, const Image3& normal,
                                                const cv::Mat_<DiffuseMoments>& moments) {
  std::vector<OcclusionAtNode> occlusion(around.pixel.size());
  const std::vector<float> solid_angle_sr = solid_angles(stage);
  parallel_for(
      int(occlusion.size()),
      [&](int node) {
        const cv::Point p = around.pixel[size_t(node)];
        const LedsFrom leds(stage, position_mm(p));
        occlusion[size_t(node)] =
            occlusion_at(around, size_t(node), leds, solid_angle_sr, normal(p), moments);
      },
      16);
  return occlusion;
}

}  // namespace lamella::fit
