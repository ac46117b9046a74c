#include "fit/turns.h"

#include <gtest/gtest.h>

namespace lamella::fit {
namespace {

TEST(Turns, AreThoseOfTheLibraryAllAround) {
  for (int i = -5000; i <= 5000; ++i) {
    const double angle = 3.14159265358979 * i / 5000;
    for (const double length : {1e-6, 1.0, 3e4}) {
      const float sine = float(length * std::sin(angle)), cosine = float(length * std::cos(angle));
      const double turns = std::atan2(double(sine), double(cosine)) / (2 * 3.14159265358979);
      EXPECT_NEAR(turns_of(sine, cosine), turns, 3e-7) << angle;
    }
  }
}

TEST(Turns, OfNothingAreNone) { EXPECT_EQ(turns_of(0, 0), 0); }

}  // namespace
}  // namespace lamella::fit
