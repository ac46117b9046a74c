#include "fit/depth_relax.h"

#include <gtest/gtest.h>

#include "fit/synthetic_rig.h"

namespace lamella::fit {
namespace {

constexpr float kPxMm = 1.25f;
const cv::Rect kGap(70, 80, 14, 14), kBesideGap(66, 76, 22, 22);

// A plane through the origin, seen by the left camera.
class DepthRelax : public ::testing::Test {
 protected:
  float plane_mm(int y, int x) const {
    return -dot(normal_, Vec3(camera_.centre_mm())) / dot(normal_, Vec3(camera_.ray(x, y)));
  }

  Image1 plane() const {
    Image1 mm(size_);
    for (int y = 0; y < mm.rows; ++y) {
      for (int x = 0; x < mm.cols; ++x) mm(y, x) = plane_mm(y, x);
    }
    return mm;
  }

  DepthMap measured() const { return {plane(), Image1(size_, .05f), Image1(), kPxMm}; }

  float worst_mm(const Image1& mm, const cv::Rect& where) const {
    float worst = 0;
    for (int y = where.y; y < where.br().y; ++y) {
      for (int x = where.x; x < where.br().x; ++x) {
        worst = std::max(worst, std::abs(mm(y, x) - plane_mm(y, x)));
      }
    }
    return worst;
  }

  const Camera camera_ = testing::make_session().left;
  const cv::Size size_{testing::kWidth, testing::kHeight};
  const Vec3 normal_ = unit(Vec3(.3f, .2f, 1));
  const SurfaceNormals normals_{Image3(size_, normal_), Image1(size_, .06f)};
};

TEST_F(DepthRelax, CarriesThePlaneOverAGapWhateverTheStart) {
  DepthMap data = measured();
  data.distance_mm(kGap).setTo(kNaN);
  Image1 mm = plane();
  for (int y = kGap.y; y < kGap.br().y; ++y) {
    for (int x = kGap.x; x < kGap.br().x; ++x) mm(y, x) += y % 2 ? 2.f : -3.f;  // crumpled
  }
  relax_depth(camera_, normals_, data, 3, &mm);
  EXPECT_LT(worst_mm(mm, kGap), 0.05f);
}

// Pixels finer than what the evidence tells are moved in blocks: no block is seen in the end.
TEST_F(DepthRelax, CarriesThePlaneInFinePixelsToo) {
  DepthMap data = measured();
  data.px_mm = 0.1f;
  data.distance_mm(kGap).setTo(kNaN);
  Image1 mm = plane();
  for (int y = kGap.y; y < kGap.br().y; ++y) {
    for (int x = kGap.x; x < kGap.br().x; ++x) mm(y, x) += 0.2f * float((x + y) % 3);
  }
  relax_depth(camera_, normals_, data, 3, &mm);
  EXPECT_LT(worst_mm(mm, kGap), 0.02f);
}

TEST_F(DepthRelax, GivesUpWhatWasMeasuredInScatteredLight) {
  DepthMap data = measured();
  // Beside a shadow the projector's light comes from elsewhere: millimetres off, and says so
  // little.
  data.sigma_mm(kBesideGap).setTo(.3f);
  for (int x = kBesideGap.x; x < kGap.x; ++x) {
    data.distance_mm.col(x).rowRange(kGap.y, kGap.br().y) += 4.f;
  }
  data.distance_mm(kGap).setTo(kNaN);
  Image1 mm = data.distance_mm.clone();
  mm(kGap).setTo(plane_mm(kGap.y, kGap.x) + 4.f);
  relax_depth(camera_, normals_, data, 3, &mm);
  EXPECT_LT(worst_mm(mm, kBesideGap), 0.3f);
}

TEST_F(DepthRelax, BelievesNormalsNoFurtherThanTheySayTheyAreRight) {
  const cv::Rect edge(140, 0, 20, size_.height);  // beyond it nothing holds the surface
  DepthMap data = measured();
  data.sigma_mm(edge).setTo(.5f);
  const auto worst_with = [&](float sigma_rad) {
    SurfaceNormals tilted{normals_.unit.clone(), normals_.sigma_rad.clone()};
    tilted.unit(edge).setTo(unit(normal_ + Vec3(.1f, 0, 0)));
    tilted.sigma_rad(edge).setTo(sigma_rad);
    Image1 mm = plane();
    relax_depth(camera_, tilted, data, 3, &mm);
    return worst_mm(mm, edge);
  };
  EXPECT_LT(worst_with(.5f), 0.1f);
  EXPECT_GT(worst_with(.06f), 0.3f);
}

TEST_F(DepthRelax, LeavesASureMeasurementAsItIs) {
  DepthMap data = measured();
  data.distance_mm(kGap).setTo(kNaN);
  Image1 mm = plane();
  mm(20, 20) += 1.f;  // a wart that the normals do not show
  relax_depth(camera_, normals_, data, 3, &mm);
  EXPECT_FLOAT_EQ(mm(20, 20), plane_mm(20, 20) + 1.f);
}

TEST_F(DepthRelax, BelievesAMeshUpToItsEdge) {
  DepthMap data = measured();
  data.penumbra_px = 0;
  data.distance_mm.col(kGap.x - 1) += 0.5f;  // a fold that the normals do not show
  Image1 mm = data.distance_mm.clone();
  data.distance_mm(kGap).setTo(kNaN);
  relax_depth(camera_, normals_, data, 3, &mm);
  EXPECT_FLOAT_EQ(mm(kGap.y + 7, kGap.x - 1), plane_mm(kGap.y + 7, kGap.x - 1) + 0.5f);
}

TEST_F(DepthRelax, DoesNotBridgeASilhouette) {
  constexpr float kBehindMm = 40;
  DepthMap data = measured();
  data.distance_mm.colRange(80, size_.width) += kBehindMm;
  Image1 mm = data.distance_mm.clone();
  data.distance_mm.colRange(76, 88).rowRange(80, 94).setTo(kNaN);
  relax_depth(camera_, normals_, data, 3, &mm);
  for (int x = 70; x < 94; ++x) {
    EXPECT_NEAR(mm(86, x) - plane_mm(86, x), x < 80 ? 0 : kBehindMm, 1.f) << x;
  }
}

}  // namespace
}  // namespace lamella::fit
