// The review window draws what `render` draws: the twin's head, layer by layer, by both.
#include "review/window.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "base/error.h"
#include "io/fake_session.h"
#include "render/render.h"
#include "render/scene.h"
#include "review/display.h"
#include "review/renderer.h"
#include "twin/truth_writer.h"

namespace lamella {
namespace {

using review::LayerGains;

constexpr int kSide = 400;
constexpr float kFarMm = 1e6f;

// The camera that an orbit is.
Camera camera_of(const review::Orbit& orbit) {
  const cv::Matx44f view = review::look_at(orbit.eye_mm(), orbit.target_mm);
  Camera camera;
  camera.width = camera.height = kSide;
  camera.fx = camera.fy = kSide / 2 / std::tan(orbit.field_rad / 2);
  camera.cx = camera.cy = (kSide - 1) / 2.0;
  for (int i = 0; i < 3; ++i) {
    const double sign = i == 0 ? 1 : -1;  // y down, z forward
    for (int j = 0; j < 3; ++j) camera.cam_from_rig(i, j) = sign * double(view(i, j));
    camera.translation_mm[i] = sign * double(view(i, 3));
  }
  return camera;
}

// As far away as makes no difference.
View view_of(const review::Orbit& orbit, const review::Lighting& lighting) {
  View view;
  view.camera = camera_of(orbit);
  for (const review::DistantLight& l : review::lights_of(lighting)) {
    Light light;
    light.position_mm = l.direction * kFarMm;
    light.radiance_at_origin = l.colour;
    view.lights.push_back(light);
  }
  return view;
}

// The twin's truth at half size, with a slab in each region for its shallow light.
render::Subject twin_head() {
  twin::Photographer::Options options;
  options.scale = 0.5;
  options.photons = 20000;
  const twin::Photographer photographer(options);
  const testing::ScratchFolder scratch;
  twin::write_truth(scratch.path(), photographer);
  const Session& rig = photographer.rig();
  render::Subject subject{rig.stage,
                          rig.left,
                          rig.projector,
                          read_layer_maps(scratch.path()),
                          read_layers(scratch.path() / "layers.json"),
                          rig.region_names};
  for (v1::Region& region : *subject.layers.mutable_regions()) {
    v1::ShallowScattering& shallow = *region.mutable_shallow();
    shallow.set_thickness_mm(0.5);
    for (double ld_mm : {3.0, 2.2, 1.7}) {
      shallow.add_ld_mm(ld_mm);
      shallow.add_alpha(0.999);
    }
  }
  return subject;
}

// A plane with a ridge that casts a hard shadow, white skin, all of its light shallow.
render::Subject ridge() {
  const auto height_mm = [](float x_mm) { return 12 * std::exp(-(x_mm + 15) * (x_mm + 15) / 25); };
  const auto skin = [&](const Vec3& eye, const Vec3& ray) {
    render::Skin at;
    at.position_mm = eye - ray * (eye[2] / ray[2]);
    for (int i = 0; i < 20; ++i) {
      at.position_mm = eye - ray * ((eye[2] - height_mm(at.position_mm[0])) / ray[2]);
    }
    const float x = at.position_mm[0] + 15;
    at.normal = unit(Vec3(height_mm(at.position_mm[0]) * 2 * x / 25, 0, 1));
    at.shallow = Vec3::all(0.6f);
    return at;
  };
  render::Subject subject = render::subject_of(render::front_camera(200, 0.4), skin);
  subject.maps.total_albedo = subject.maps.shallow_albedo.clone();
  subject.maps.single_albedo = Image3(subject.maps.regions.size(), Vec3(0, 0, 0));
  v1::ShallowScattering& shallow = *subject.layers.mutable_regions(0)->mutable_shallow();
  shallow.set_thickness_mm(1.5);
  for (double ld_mm : {3.0, 2.0, 1.5}) {
    shallow.add_ld_mm(ld_mm);
    shallow.add_alpha(0.98);
  }
  return subject;
}

// What is left when the maps of other layers are black.
render::Subject only(const render::Subject& all, const LayerGains& gains) {
  render::Subject subject = all;
  LayerMaps& m = subject.maps;
  m.specular_intensity = Image1(m.specular_intensity.clone() * gains.specular);
  m.single_albedo = Image3(m.single_albedo.clone() * gains.single);
  m.shallow_albedo = Image3(m.shallow_albedo.clone() * gains.shallow);
  m.deep_albedo = Image3(m.deep_albedo.clone() * gains.deep);
  return subject;
}

// How soft the edge of the shadow is that the middle row runs out of, in pixels: the integral of
// p (1 - p) with p from 0 in the dark to 1 in the light.
template <class Image>
double softness_px(const Image& image, int channel) {
  const auto at = [&](int x) { return double(image(kSide / 2, x)[channel]); };
  const double light = at(kSide * 7 / 10);
  int edge = kSide * 7 / 10;
  while (edge > 40 && at(edge) > light / 2) --edge;
  double sum = 0;
  for (int x = edge - 30; x < edge + 30; ++x) {
    const double p = std::clamp(at(x) / light, 0.0, 1.0);
    sum += p * (1 - p);
  }
  return sum;
}

class TheWindow : public ::testing::Test {
 protected:
  // One context for all: making one takes longer than the tests.
  static void SetUpTestSuite() {
    try {
      review::ensure_display();
      window_ = std::make_unique<review::Window>("test", 64, 64, false, 13.f);
    } catch (const Error& e) {
      no_screen_ = e.what();
    }
  }

  static void TearDownTestSuite() { window_.reset(); }

  void SetUp() override {
    if (!window_) GTEST_SKIP() << "NOT TESTED: " << no_screen_;
  }

  void show(const render::Subject& subject) {
    subject_ = std::make_unique<render::Subject>(subject);
    renderer_ =
        std::make_unique<review::Renderer>(face_from_maps(subject.maps, "test"), subject.layers);
  }

  // Single scattering alone by what is missing without it: its transmittance hangs on c.
  Image3 layers_of(const LayerGains& gains, const View& view, const Image3& whole) const {
    if (gains.single == 0 || gains.specular > 0) return render_view(only(*subject_, gains), view);
    return whole - render_view(only(*subject_, {1, 0, 1, 1}), view);
  }

  // The same picture by the window and by `render`.
  struct Pair {
    cv::Mat4f window;
    Image3 picture;
    Mask both;  // show the face, and so do their neighbours
  };

  Pair draw(const LayerGains& gains, const review::Lighting& lighting) {
    review::Look look;
    look.orbit = review::orbit_before(renderer_->face(), 1, 0.8f);
    look.orbit.azimuth_rad += 0.1f;
    look.gains = gains;
    renderer_->light(lighting);
    const View view = view_of(look.orbit, lighting);
    const Image3 whole = render_view(*subject_, view);
    Pair pair{renderer_->radiance(look, {kSide, kSide}), layers_of(gains, view, whole),
              Mask(kSide, kSide, uchar(0))};
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        pair.both(y, x) = pair.window(y, x)[3] > 0.999f && whole(y, x)[0] > 0 ? 255 : 0;
      }
    }
    cv::erode(pair.both, pair.both, Mask::ones(7, 7));
    EXPECT_GT(cv::countNonZero(pair.both), kSide * kSide / 8);
    return pair;
  }

  // Root of the mean squared difference, of the root mean square.
  double relative_error(const LayerGains& gains, const review::Lighting& lighting) {
    const Pair pair = draw(gains, lighting);
    double squares = 0, difference = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        for (int c = 0; pair.both(y, x) && c < 3; ++c) {
          const double wanted = double(pair.picture(y, x)[c]);
          const double d = double(pair.window(y, x)[c]) - wanted;
          squares += wanted * wanted;
          difference += d * d;
        }
      }
    }
    return std::sqrt(difference / squares);
  }

  static inline std::unique_ptr<review::Window> window_;
  static inline std::string no_screen_;
  std::unique_ptr<render::Subject> subject_;
  std::unique_ptr<review::Renderer> renderer_;
};

TEST_F(TheWindow, ShowsEveryLayerOfTheTwinsHeadAsRenderDoes) {
  show(twin_head());
  const review::Lighting lighting = review::portrait_lighting();
  EXPECT_LT(relative_error({1, 1, 1, 1}, lighting), 0.07);
  EXPECT_LT(relative_error({0, 0, 0, 1}, lighting), 0.07);
  EXPECT_LT(relative_error({0, 0, 1, 0}, lighting), 0.07);
  EXPECT_LT(relative_error({0, 1, 0, 0}, lighting), 0.06);
  EXPECT_LT(relative_error({1, 0, 0, 0}, lighting), 0.18);
}

TEST_F(TheWindow, BlursShallowLightAcrossTheEdgeOfAShadow) {
  show(ridge());
  const Pair pair = draw({0, 0, 1, 0}, review::single_light({-1, 0, 0.7f}));
  for (int c = 0; c < 3; ++c) {
    const double wanted = softness_px(pair.picture, c);
    EXPECT_NEAR(softness_px(pair.window, c), wanted, 0.25 * wanted) << c;
  }
}

}  // namespace
}  // namespace lamella
