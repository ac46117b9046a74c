// The phase function of Henyey and Greenstein: how light that is scattered once is spread.
#pragma once

#include <cmath>

#include "base/vec.h"

namespace lamella::model {

// Per steradian; integrates to 1 over the sphere and has mean cosine `g`, -1 < g < 1. `cosine` is
// between the two *propagation* directions: -l'.v' for l', v' away from the surface. The exponent
// is 3/2 of 1 + g^2 - 2 g cos; the paper's print lost the square.
template <class Real>
inline Real henyey_greenstein(Real cosine, Real g) {
  const Real x = Real(1) + g * g - Real(2) * g * cosine;
  return (Real(1) - g * g) / (Real(4) * Real(kPi) * x * std::sqrt(x));
}

}  // namespace lamella::model
