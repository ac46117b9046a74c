#include "fit/black_check.h"

#include <vector>

#include "base/parallel.h"

namespace lamella::fit {

namespace {

struct LightOfRow {
  double black = 0, front = 0, missed = 0;  // of the stripes, above what FRONT and BLACK explain
};

}  // namespace

// With STRIPES, FRONT and BLACK as S, F, B and the true black b: sum S = 2 F + 2 b, so that of what
// is left with B removed from each, sum (S - B) / 2 - (F - B) = b - B.
BlackLevels compare_black(const Burst& burst) {
  std::vector<LightOfRow> rows(size_t(burst.regions.rows));
  parallel_for(burst.regions.rows, [&](int y) {
    LightOfRow& row = rows[size_t(y)];
    for (int x = 0; x < burst.regions.cols; ++x) {
      if (!burst.regions(y, x) || is_clipped(burst.clipped_projector, y, x) ||
          is_clipped(burst.clipped_stripes, y, x)) {
        continue;
      }
      double stripes = 0;
      for (const Image3& image : burst.stripes) stripes += double(mean(image(y, x)));
      const double front_lit = double(mean(burst.front_lit(y, x)));
      if (!is_finite(float(stripes + front_lit))) continue;
      row.missed += stripes / 2 - front_lit;
      row.black += double(mean(burst.black(y, x)));
      row.front += double(mean(burst.front.cross(y, x)));
    }
  });
  LightOfRow all;
  for (const LightOfRow& row : rows) {
    all.black += row.black;
    all.front += row.front;
    all.missed += row.missed;
  }
  if (!(all.front > 0)) return {};
  return {all.black / all.front, (all.black + all.missed) / all.front};
}

}  // namespace lamella::fit
