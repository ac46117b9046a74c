#include "model/torrance_sparrow.h"

namespace lamella::model {

float torrance_sparrow(const LobeTable& lobe, const Vec3& n, const Vec3& l, const Vec3& v) {
  const float n_l = dot(n, l), n_v = dot(n, v);
  if (n_l <= 0.f || n_v <= 0.f) return 0.f;
  const Vec3 h = unit(l + v);
  return lobe_times_cosine(lobe, dot(n, h), n_v, n_l, dot(v, h)) / n_l;
}

}  // namespace lamella::model
