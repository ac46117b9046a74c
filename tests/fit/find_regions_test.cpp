#include "fit/find_regions.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "synthetic_sphere.h"

namespace lamella::fit {
namespace {

// What skin within a circle on the sphere's front has other than the skin around it.
struct Patch {
  float radius_mm = 20;
  float red = 1;       // times the red that is reflected
  float gloss = 0.8f;  // cosine by which S keeps to the mirror direction; 0.8 is that around it
};

const Vec3 kPatchCentre(0.1f, -0.2f, 1);  // on the sphere of radius 1, not yet unit

SyntheticSphere plain_sphere() {
  static const SyntheticSphere sphere = SpherePhotographer().photograph(
      {SyntheticSkin{}}, [](float, float) { return 1; }, false);
  SyntheticSphere copy = sphere;
  for (AnalyserPair* pair : {&copy.burst.full, &copy.burst.front}) {
    pair->parallel = pair->parallel.clone();
    pair->cross = pair->cross.clone();
  }
  copy.burst.front_lit = copy.burst.front.cross;
  copy.burst.regions = sphere.burst.regions.clone();
  copy.burst.region_names = {"background", "face"};
  copy.burst.clipped_led = sphere.burst.clipped_led.clone();
  return copy;
}

bool is_in(const Patch& patch, const Vec3& position_mm) {
  const Vec3 centre = unit(kPatchCentre) * SpherePhotographer::kRadiusMm;
  return is_finite(position_mm) && length(position_mm - centre) < patch.radius_mm;
}

// The gradients hold what S of `gloss` about the mirror direction gives.
SyntheticSphere sphere_with(const Patch& patch) {
  SyntheticSphere s = plain_sphere();
  for (AnalyserPair& gradient : s.burst.gradient) {
    gradient = {s.burst.full.parallel.clone(), s.burst.full.cross.clone()};
  }
  for (int y = 0; y < s.burst.regions.rows; ++y) {
    for (int x = 0; x < s.burst.regions.cols; ++x) {
      if (!s.burst.regions(y, x)) continue;
      const bool inside = is_in(patch, s.geometry.position_mm(y, x));
      const Vec3 polarized = s.burst.full.parallel(y, x) - s.burst.full.cross(y, x);
      if (inside) s.burst.full.cross(y, x)[0] *= patch.red;
      s.burst.full.parallel(y, x) = s.burst.full.cross(y, x) + polarized;
      const Vec3 n = s.normals.specular(y, x), v = s.geometry.to_camera(y, x);
      const Vec3 mirror = n * (2 * dot(n, v)) - v;
      for (int a = 0; a < 3; ++a) {
        const float share = 0.5f + 0.5f * mirror[a] * (inside ? patch.gloss : Patch().gloss);
        s.burst.gradient[size_t(a)].parallel(y, x) =
            s.burst.gradient[size_t(a)].cross(y, x) + polarized * share;
      }
    }
  }
  return s;
}

FoundRegions found_on(SyntheticSphere sphere) {
  settle(&sphere);
  return find_regions(sphere.burst, sphere.geometry, sphere.normals);
}

// Of the patch's pixels, those of label 2; less than 0 where others have it too, beyond its rim.
double share_found(const Patch& patch, const FoundRegions& found) {
  const SyntheticSphere s = plain_sphere();
  double all = 0, hit = 0;
  for (int y = 0; y < found.labels.rows; ++y) {
    for (int x = 0; x < found.labels.cols; ++x) {
      Patch rim = patch;
      rim.radius_mm += 6;
      const Vec3& at = s.geometry.position_mm(y, x);
      if (found.labels(y, x) == 2 && !is_in(rim, at)) return -1;
      if (!is_in(patch, at)) continue;
      all += 1;
      hit += found.labels(y, x) == 2;
    }
  }
  return hit / all;
}

TEST(FindRegions, SkinThatIsAlikeIsOneFace) {
  const FoundRegions found = found_on(sphere_with({}));
  EXPECT_EQ(found.names, (std::vector<std::string>{"background", "face"}));
  EXPECT_EQ(cv::countNonZero(found.labels != plain_sphere().burst.regions), 0);
}

TEST(FindRegions, RedderSkinIsARegionAndIsNamedSo) {
  const Patch lips{.red = 1.4f};
  const FoundRegions found = found_on(sphere_with(lips));
  ASSERT_EQ(found.names.size(), 3u);
  EXPECT_EQ(found.names[1], "region 1 (least red)");
  EXPECT_EQ(found.names[2], "region 2 (reddest)");
  EXPECT_GT(share_found(lips, found), 0.9);
}

TEST(FindRegions, GlossierSkinOfTheSameColourIsARegion) {
  const Patch nose{.gloss = 0.88f};
  const FoundRegions found = found_on(sphere_with(nose));
  ASSERT_EQ(found.names.size(), 3u);
  EXPECT_EQ(found.names[2], "region 2 (glossiest)");
  EXPECT_GT(share_found(nose, found), 0.9);
}

// Failure: a mole would be fitted to no dot and to no peak of a lobe.
TEST(FindRegions, WhatIsTooSmallForTheFitsIsPartOfWhatIsAroundIt) {
  EXPECT_EQ(found_on(sphere_with({.radius_mm = 8, .red = 1.6f})).names.size(), 2u);
}

TEST(FindRegions, AreTheSameOnOneProcessor) {
  const Patch lips{.red = 1.4f};
  const FoundRegions several = found_on(sphere_with(lips));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const FoundRegions found = found_on(sphere_with(lips));
  EXPECT_EQ(found.names, several.names);
  EXPECT_EQ(cv::countNonZero(found.labels != several.labels), 0);
}

TEST(FindRegions, WhereNothingIsSeenWellThereIsOneFace) {
  SyntheticSphere dazzled = sphere_with({.red = 1.4f});
  dazzled.burst.clipped_led.setTo(255);
  EXPECT_EQ(found_on(dazzled).names, (std::vector<std::string>{"background", "face"}));
}

TEST(LabelsOfPixels, GiveABorderBetweenBlocksAndNothingOutsideTheSubject) {
  Labels blocks(2, 4, uchar(1));
  blocks.colRange(2, 4).setTo(2);
  Mask subject(16, 32, uchar(255));
  subject.row(3).setTo(0);
  const Labels labels = labels_of_pixels(blocks, 8, subject);
  EXPECT_EQ(labels(5, 15), 1);
  EXPECT_EQ(labels(5, 16), 2);
  EXPECT_EQ(cv::countNonZero(labels.row(3)), 0);
  EXPECT_EQ(cv::countNonZero(labels), 15 * 32);
}

TEST(LabelsOfPixels, OfABlockWithoutALabelAreThoseOfTheNearestThatHasOne) {
  Labels blocks(1, 8, uchar(0));
  blocks(0, 1) = 3;
  blocks(0, 7) = 5;
  const Labels labels = labels_of_pixels(blocks, 1, Mask(1, 8, uchar(255)));
  EXPECT_EQ(labels(0, 0), 3);
  EXPECT_EQ(labels(0, 3), 3);
  EXPECT_EQ(labels(0, 5), 5);
}

}  // namespace
}  // namespace lamella::fit
