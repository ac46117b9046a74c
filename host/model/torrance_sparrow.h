// The surface lobe of eq. 1: f = c p(h) F(v.h) G / ((l.n)(v.n)), in this form everywhere.
#pragma once

#include <algorithm>

#include "base/vec.h"
#include "model/fresnel.h"
#include "model/lobe.h"

namespace lamella::model {

// Shadowing and masking by V-shaped grooves: min(1, 2(n.h)(n.v)/(v.h), 2(n.h)(n.l)/(v.h)).
template <class Real>
inline Real v_groove(Real n_h, Real n_v, Real n_l, Real v_h) {
  return std::min(Real(1), Real(2) * n_h * std::min(n_v, n_l) / v_h);
}

// f (n.l) of eq. 1 with c = 1, per steradian, from the four cosines; the caller has checked that
// n.l and n.v are positive. A white surface of radiance E shows pi times this times E.
inline float lobe_times_cosine(const LobeTable& lobe, float n_h, float n_v, float n_l, float v_h) {
  return lobe.density(n_h) * fresnel_reflectance(v_h) * v_groove(n_h, n_v, n_l, v_h) / n_v;
}

// f of eq. 1 with c = 1, per steradian; 0 where light or camera are below the surface.
// All vectors unit, `l` and `v` away from the surface.
float torrance_sparrow(const LobeTable& lobe, const Vec3& n, const Vec3& l, const Vec3& v);

}  // namespace lamella::model
