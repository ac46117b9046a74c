#include "render/render.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "model/torrance_sparrow.h"
#include "render/reflection.h"
#include "render/scene.h"

namespace lamella::render {
namespace {

Light environment_of_one() {
  Light light;
  light.kind = Light::Kind::kEnvironment;
  light.file = fs::temp_directory_path() / ("lamella_white_" + std::to_string(getpid()) + ".exr");
  write_exr_rgb(light.file, Image3(32, 64, Vec3::all(1)));
  return light;
}

Skin white_skin() {
  Skin skin;
  skin.shallow = Vec3::all(0.4f);
  skin.deep = Vec3::all(0.6f);
  skin.ld_mm = {3, 1, 0.5f};
  return skin;
}

void add_lobe(double gaussian_m, Subject* subject) {
  auto* lobe = subject->layers.mutable_regions(0)->mutable_specular();
  for (int i = 0; i <= 90; ++i) {
    const double theta = i * M_PI / 360;
    lobe->add_theta(theta);
    lobe->add_p(std::exp(-theta * theta / (gaussian_m * gaussian_m)));
  }
}

TEST(WhiteFurnace, ShowsAWhiteSphereUnderEvenLightAsWhite) {
  const Camera camera = front_camera(120, 0.5);
  const Light light = environment_of_one();
  const Image3 image = render_view(sphere(camera, 20, white_skin()), lit_by(camera, light));
  fs::remove(light.file);
  int seen = 0;
  for (int i = 0; i < 120; ++i) {
    for (int j = 0; j < 120; ++j) {
      if (std::hypot(i - 59.5, j - 59.5) > 36) continue;
      ++seen;
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(image(i, j)[c], 1, 0.03) << i << " " << j;
    }
  }
  EXPECT_GT(seen, 4000);
}

TEST(LambertianLimit, IsAlbedoTimesIrradianceWhereLightHardlySpreads) {
  const Camera camera = front_camera(60, 1);
  Skin skin = white_skin();
  skin.shallow = {0.1f, 0.2f, 0.3f};
  skin.deep = {0.4f, 0.2f, 0.1f};
  skin.ld_mm = Vec3::all(0.01f);
  const Vec3 light(300, 0, 400);
  const Image3 image = render_view(plane(camera, skin), lit_by(camera, point_light(light)));
  const Vec3 x(-9.5f, 4.5f, 0), to_light = light - x;
  const float e = dot(light, light) / dot(to_light, to_light) * unit(to_light)[2];
  const Vec3 shown = image(25, 20);
  EXPECT_NEAR(shown[0], 0.5f * e, 2e-3);
  EXPECT_NEAR(shown[1], 0.4f * e, 2e-3);
  EXPECT_NEAR(shown[2], 0.4f * e, 2e-3);
}

TEST(Shadow, OfADiscFallsWhereTheLightSaysAndSoftensWithTheMeanFreePath) {
  const Camera camera = front_camera(161, 0.5);
  Skin skin = white_skin();
  skin.shallow = Vec3(0, 0, 0);
  skin.deep = Vec3::all(1);
  const Subject subject = subject_of(camera, [&](const Vec3& eye, const Vec3& ray) {
    Skin at = skin;
    const Vec3 high = eye - ray * ((eye[2] - 40) / ray[2]);
    const bool disc = std::hypot(high[0] - 12, high[1]) < 6;
    at.position_mm = disc ? high : eye - ray * (eye[2] / ray[2]);
    return at;
  });
  // Light from the right at 45 degrees: the disc at x = 12 shades the plane around x = -28.
  const Image3 image = render_view(subject, lit_by(camera, point_light({10000, 0, 10000})));
  const auto at_mm = [&](float x, float y) { return image(80 - int(y * 2), 80 + int(x * 2)); };
  EXPECT_LT(at_mm(-28, 0)[2], 0.01);
  EXPECT_GT(at_mm(-28, 0)[0], 2 * at_mm(-28, 0)[2]);  // red leaks further in
  EXPECT_NEAR(at_mm(-14, 15)[2], 0.71, 0.03);
  EXPECT_LT(at_mm(-36, 0)[0], at_mm(-36, 0)[2] - 0.03);  // and darkens the lit side more
}

TEST(Light, AddsUp) {
  const Camera camera = front_camera(50, 1);
  Skin skin = white_skin();
  skin.intensity = 0.3f;
  Subject subject = sphere(camera, 20, skin);
  add_lobe(0.3, &subject);
  const Light a = point_light({300, 100, 600}), b = point_light({-200, 500, 300}, 0.5f);
  View both = lit_by(camera, a);
  both.lights.push_back(b);
  const Image3 sum =
      render_view(subject, lit_by(camera, a)) + render_view(subject, lit_by(camera, b));
  const Image3 image = render_view(subject, both);
  EXPECT_LT(cv::norm(image, sum, cv::NORM_INF), 1e-4 * cv::norm(sum, cv::NORM_INF));
  EXPECT_GT(cv::norm(image, cv::NORM_INF), 0.5);
}

TEST(SurfaceReflection, ReturnsTheEnergyOfEquationOne) {
  const Camera camera = front_camera(8, 1);
  Subject subject = plane(camera, Skin());
  add_lobe(0.25, &subject);
  const Reflection reflection(subject);
  const auto& s = subject.layers.regions(0).specular();
  const model::LobeTable lobe({s.theta().begin(), s.theta().end()}, {s.p().begin(), s.p().end()});
  for (float n_v : {1.f, 0.8f, 0.5f}) {
    SkinPoint point;
    point.region = 1;
    point.normal = {0, 0, 1};
    point.to_camera = {std::sqrt(1 - n_v * n_v), 0, n_v};
    point.intensity = 0.25f;
    float sum = 0;
    for (const LightSample& l : cut_environment(Image3(128, 256, Vec3::all(1)), 8000)) {
      sum += reflection.radiance(point, {l.place, l.strength, 1})[1];
    }
    const double expected = 0.25 * model::directional_reflectance(lobe, n_v);
    EXPECT_NEAR(sum, expected, 0.03 * expected) << n_v;
    EXPECT_LT(sum, 0.2);
  }
}

TEST(SurfaceReflection, IsReciprocal) {
  const Camera camera = front_camera(8, 1);
  Subject subject = plane(camera, Skin());
  add_lobe(0.25, &subject);
  for (double amplitude : {0.05, 0.04, 0.03}) {
    subject.layers.mutable_regions(0)->mutable_single()->add_amplitude(amplitude);
  }
  const Reflection reflection(subject);
  const Vec3 a = unit(Vec3(0.3f, 0.1f, 1)), b = unit(Vec3(-0.7f, 0.4f, 0.8f));
  SkinPoint point;
  point.region = 1;
  point.normal = {0, 0, 1};
  point.intensity = 0.25f;
  point.single_alpha = region_single_alpha(subject, 1);
  point.to_camera = a;
  const Vec3 from_b = reflection.radiance(point, {b, Vec3::all(1), 1}) * (1 / b[2]);
  point.to_camera = b;
  const Vec3 from_a = reflection.radiance(point, {a, Vec3::all(1), 1}) * (1 / a[2]);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(from_a[c], from_b[c], 1e-5);
  EXPECT_GT(from_a[0], from_a[2]);  // single scattering is there and has the colour asked for
}

TEST(Nothing, IsShownWhereRaysMeetNothing) {
  const Camera camera = front_camera(60, 1);
  const Image3 image =
      render_view(sphere(camera, 10, white_skin()), lit_by(camera, point_light({0, 0, 500})));
  EXPECT_EQ(image(2, 2), Vec3(0, 0, 0));
  EXPECT_GT(image(30, 30)[0], 0.9);
}

}  // namespace
}  // namespace lamella::render
