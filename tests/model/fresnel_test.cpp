#include "model/fresnel.h"

#include <gtest/gtest.h>

namespace lamella::model {
namespace {

TEST(Fresnel, AtNormalIncidenceIsTheClosedForm) {
  EXPECT_NEAR(fresnel_reflectance(1.0, 1.38), 0.38 * 0.38 / (2.38 * 2.38), 1e-12);
  EXPECT_NEAR(fresnel_reflectance(1.0, 1.38), fresnel_at_normal(1.38), 1e-12);
}

TEST(Fresnel, ReflectsEverythingAtGrazingAndNothingWithoutABoundary) {
  EXPECT_NEAR(fresnel_reflectance(0.0, 1.38), 1.0, 1e-12);
  EXPECT_NEAR(fresnel_reflectance(0.6, 1.0 + 1e-9), 0.0, 1e-12);
}

TEST(Fresnel, AtBrewstersAngleIsHalfOfThePerpendicularPartAlone) {
  const double eta = 1.38, tan_i = eta;
  const double cos_i = 1 / std::sqrt(1 + tan_i * tan_i), cos_t = refracted_cosine(cos_i, eta);
  const double perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
  EXPECT_NEAR(fresnel_reflectance(cos_i, eta), 0.5 * perpendicular * perpendicular, 1e-12);
}

TEST(Fresnel, DiffuseInternalReflectanceAndBoundaryFactorMeetTheCheckedValues) {
  EXPECT_NEAR(diffuse_internal_reflectance(1.38), 0.5136, 5e-4);
  EXPECT_NEAR(boundary_factor(1.38), 3.112, 4e-3);
  EXPECT_NEAR(boundary_factor(1.0), 1.0, 1e-9);
}

TEST(Refraction, ObeysSnellAndStaysInThePlaneOfIncidence) {
  const Vec3 n = unit(Vec3(0.2f, -0.1f, 0.9f));
  const Vec3 w = unit(Vec3(0.7f, 0.3f, 0.5f));
  const Vec3 inside = refracted_direction(w, n);
  EXPECT_NEAR(length(inside), 1.f, 1e-5f);
  EXPECT_NEAR(length(cross(inside, n)) * 1.38f, length(cross(w, n)), 1e-5f);
  EXPECT_NEAR(dot(inside, cross(w, n)), 0.f, 1e-5f);
  EXPECT_GT(dot(inside, n), dot(w, n));
}

}  // namespace
}  // namespace lamella::model
