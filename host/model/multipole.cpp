#include "model/multipole.h"

namespace lamella::model {

int half_count_for(const Multipole<double>& m, double tolerance, int limit) {
  double total = multipole_total(m, 0);
  for (int n = 0; n < limit; ++n) {
    const double next = multipole_total(m, n + 1);
    if (std::abs(next - total) <= tolerance * std::abs(next)) return n;
    total = next;
  }
  return limit;
}

}  // namespace lamella::model
