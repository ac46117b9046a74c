// The lit head on a screen in memory (Xvfb where there is no display).
#include "review/review.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "model/dipole.h"
#include "model/torrance_sparrow.h"
#include "review/display.h"
#include "review/shader_sources.h"
#include "review/sheet.h"
#include "review/window.h"

namespace lamella::review {
namespace {

std::string no_screen;

class Screen : public ::testing::Environment {
 public:
  void SetUp() override {
    try {
      ensure_display();  // starts this program again under xvfb-run where it has to
    } catch (const Error& e) {
      no_screen = e.what();
    }
  }
};
const auto* const kScreen = ::testing::AddGlobalTestEnvironment(new Screen);

constexpr int kSide = 120;
constexpr float kRadiusMm = 60.f, kPixelMm = 1.f;

// A hemisphere that faces +Z.
LayerMaps dome() {
  LayerMaps m;
  const cv::Size size(kSide, kSide);
  const Vec3 unknown(kNaN, kNaN, kNaN);
  m.position_mm = m.normal_specular = Image3(size, unknown);
  m.normal_specular = m.normal_specular.clone();
  m.total_albedo = Image3(size, unknown);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const float px = (float(x) - kSide / 2) * kPixelMm, py = (kSide / 2 - float(y)) * kPixelMm;
      if (px * px + py * py > 0.8f * kRadiusMm * kRadiusMm) continue;
      const Vec3 p(px, py, std::sqrt(kRadiusMm * kRadiusMm - px * px - py * py));
      m.position_mm(y, x) = p;
      m.normal_specular(y, x) = unit(p);
      m.total_albedo(y, x) = {0.6f, 0.5f, 0.4f};
    }
  }
  m.shallow_albedo = m.total_albedo * 0.25f;
  m.deep_albedo = m.total_albedo * 0.75f;
  m.deep_ld_mm = Image3(size, Vec3(2.f, 1.f, 0.7f));
  m.single_albedo = Image3(size, Vec3(0.5f, 0.5f, 0.5f));
  m.specular_intensity = Image1(size, 0.25f);
  m.regions = Labels(size, uchar(1));
  return m;
}

v1::Layers one_region() {
  v1::Layers layers;
  v1::Region* r = layers.add_regions();
  r->set_name("skin");
  for (double theta = 0; theta < 0.785; theta += 0.01) {
    r->mutable_specular()->add_theta(theta);
    r->mutable_specular()->add_p(3.5 * std::exp(-theta * theta / 0.09));
  }
  return layers;
}

class Review : public ::testing::Test {
 protected:
  // One context for all: making one takes longer than the tests.
  static void SetUpTestSuite() {
    if (!no_screen.empty()) return;
    try {
      window_ = std::make_unique<Window>("test", 64, 64, false, 13.f);
      renderer_ = std::make_unique<Renderer>(face_from_maps(dome(), "dome"), one_region());
    } catch (const Error& e) {
      no_screen = e.what();
    }
  }

  static void TearDownTestSuite() {
    renderer_.reset();
    window_.reset();
  }

  void SetUp() override {
    if (!renderer_) GTEST_SKIP() << "NOT TESTED: " << no_screen;
    renderer_->light(single_light({0, 0, 1}));
  }

  Look front(const LayerGains& gains) const {
    Look look;
    look.orbit = orbit_before(renderer_->face(), 1.f, 0.8f);
    look.gains = gains;
    return look;
  }

  cv::Mat3b head(const LayerGains& gains) {
    return draw_head(renderer_.get(), front(gains), {96, 96});
  }

  // Linear value in the middle of the picture.
  Vec3 middle(const LayerGains& gains) {
    const cv::Vec3b bgr = head(gains)(48, 48);
    Vec3 rgb;
    for (int c = 0; c < 3; ++c) {
      const float v = float(bgr[2 - c]) / 255.f;
      rgb[c] = v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
    }
    return rgb;
  }

  static inline std::unique_ptr<Window> window_;
  static inline std::unique_ptr<Renderer> renderer_;
};

TEST_F(Review, ShowsTheShallowAlbedoWhereTheLightIsSquare) {
  const Vec3 seen = middle({0, 0, 1, 0});
  EXPECT_NEAR(seen[0], 0.150f, 0.006f);
  EXPECT_NEAR(seen[1], 0.125f, 0.006f);
  EXPECT_NEAR(seen[2], 0.100f, 0.006f);
}

TEST_F(Review, DiffusesDeepLightWithoutLosingAny) {
  const Vec3 seen = middle({0, 0, 0, 1});
  EXPECT_NEAR(seen[0], 0.45f, 0.015f);
  EXPECT_NEAR(seen[2], 0.30f, 0.012f);
}

TEST_F(Review, ChangesWithEveryLayerThatIsSwitchedOff) {
  const cv::Mat3b all = head({1, 1, 1, 1});
  const LayerGains without[] = {{0, 1, 1, 1}, {1, 0, 1, 1}, {1, 1, 0, 1}, {1, 1, 1, 0}};
  for (const LayerGains& gains : without) {
    const cv::Mat3b darker = head(gains);
    EXPECT_GT(cv::norm(all, darker, cv::NORM_INF), 1.0);
    EXPECT_GT(cv::sum(all)[1], cv::sum(darker)[1]);
  }
}

TEST_F(Review, IsBackdropAloneWithEverythingOff) {
  const cv::Mat3b off = head({0, 0, 0, 0});
  Look away = front({1, 1, 1, 1});
  away.orbit.shift = {10.f, 0.f};  // the face is out of the picture
  EXPECT_EQ(cv::norm(off, draw_head(renderer_.get(), away, {96, 96}), cv::NORM_INF), 0.0);
}

TEST_F(Review, MakesTheSideAwayFromTheLightDark) {
  renderer_->light(single_light({-1, 0, 0.15f}));
  const cv::Mat3b lit = head({0, 0, 1, 0});
  EXPECT_GT(int(lit(48, 26)[1]), 4 * int(lit(48, 70)[1]));
}

TEST_F(Review, PutsTheTopOfTheFaceAtTheTop) {
  renderer_->light(single_light({0, 1, 0.3f}));
  const cv::Mat3b lit = head({0, 0, 1, 0});
  EXPECT_GT(int(lit(26, 48)[1]), 2 * int(lit(70, 48)[1]));
}

TEST_F(Review, DrawsASheetOfTheSizeAskedFor) {
  SheetRequest request;
  request.subject = "dome";
  request.size = {480, 300};
  request.look = front({1, 1, 1, 1});
  const cv::Mat3b sheet = draw_sheet(renderer_.get(), window_->fonts(), one_region(), request);
  EXPECT_EQ(sheet.size(), request.size);
  cv::Scalar mean, deviation;
  cv::meanStdDev(sheet, mean, deviation);
  EXPECT_GT(deviation[1], 10.0);
}

TEST_F(Review, KeepsTheWordsOfASmallSheetWithinTheirTiles) {
  const auto tiles_of = [&](const std::string& subject, const LayerGains& gains) {
    SheetRequest request{.subject = subject, .size = {480, 300}, .look = front(gains)};
    return draw_sheet(renderer_.get(), window_->fonts(), one_region(), request)
        .colRange(232, 480)  // the four tiles
        .clone();
  };
  const cv::Mat3b plain = tiles_of("dome", {1, 1, 1, 1});
  const cv::Mat3b named = tiles_of(std::string(60, 'm'), {1, 1, 1, 1});
  EXPECT_EQ(cv::norm(plain, named, cv::NORM_INF), 0) << "the title runs into the tiles";
  const cv::Mat3b without_deep = tiles_of("dome", {1, 1, 1, 0});
  const cv::Rect shallow(126, 0, 122, 150);
  EXPECT_EQ(cv::norm(plain(shallow), without_deep(shallow), cv::NORM_INF), 0)
      << "the words of one tile run into the next";
}

// The shader's lobe, drawn against the angle in backscatter.
constexpr char kProbe[] = R"(
in vec2 uv;
out vec4 value;
void main() {
  float c = cos(uv.x * 0.78539816);
  value = vec4(facet_density(0, c) * lobe_rest(c, c, c, 1.0));
})";

TEST_F(Review, HasTheProcessorsLobeInItsShader) {
  constexpr int kAngles = 64;
  const Program probe("probe", {kFullScreenVert}, {kLobeGlsl, kProbe});
  probe.bind("lobes", 0, renderer_->face().lobes);
  const Target target = make_target(kAngles, 1, GL_RGBA32F, false);
  draw_to(target);
  probe.use();
  GLuint vertex_array = 0;
  glGenVertexArrays(1, &vertex_array);
  const VertexArrayName owner(vertex_array);
  glBindVertexArray(vertex_array);
  glDisable(GL_DEPTH_TEST);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<cv::Vec4f> values(kAngles);
  glReadPixels(0, 0, kAngles, 1, GL_RGBA, GL_FLOAT, values.data());

  const v1::Layers layers = one_region();
  const auto& s = layers.regions(0).specular();
  const model::LobeTable lobe({s.theta().begin(), s.theta().end()}, {s.p().begin(), s.p().end()});
  for (int i = 0; i < kAngles; ++i) {
    const float theta = (float(i) + 0.5f) / kAngles * kPi / 4;
    const Vec3 n(0, 0, 1), l(std::sin(theta), 0, std::cos(theta));
    const float wanted = model::torrance_sparrow(lobe, n, l, l) * l[2];
    EXPECT_NEAR(values[size_t(i)][0], wanted, 0.01f * wanted + 1e-5f) << theta;
  }
}

TEST(GaussianShares, HoldTheDipolesLightWithinEveryRadius) {
  for (double ld_mm : {0.6, 1.0, 2.0, 2.9}) {
    const cv::Vec4f share = gaussian_shares(ld_mm, 0.9);
    const model::Dipole<double> dipole{0.9, ld_mm};
    double total = 0, inside = 0;
    const double step = 0.01;
    for (double r = step / 2; r < 40; r += step) {
      total += model::dipole_reflectance(dipole, r) * r * step;
    }
    for (double r = step / 2; r < 6; r += step) {
      inside += model::dipole_reflectance(dipole, r) * r * step;
      if (r < 0.5 * ld_mm) continue;
      double ours = 0;
      for (int k = 0; k < 4; ++k) {
        const double v = 2.0 * kGaussianSigmaMm[size_t(k)] * kGaussianSigmaMm[size_t(k)];
        ours += double(share[k]) * (1 - std::exp(-r * r / v));
      }
      ASSERT_NEAR(ours, inside / total, 0.08) << "l_d " << ld_mm << ", r " << r;
    }
  }
}

TEST(RegionWeights, SumToOneAlsoWhereNothingIsLabelled) {
  Labels labels(40, 60, uchar(0));
  labels(cv::Rect(10, 10, 15, 20)).setTo(1);
  labels(cv::Rect(25, 10, 15, 20)).setTo(2);
  const std::vector<Image1> planes = region_weights(labels, 2);
  EXPECT_LT(cv::norm(planes[0] + planes[1], Image1(40, 60, 1.f), cv::NORM_INF), 1e-4);
  EXPECT_GT(planes[0](20, 12), 0.9f);
  EXPECT_GT(planes[1](20, 38), 0.9f);
}

TEST(Lights, OfThePortraitFitTheShader) {
  const std::vector<DistantLight> lights = lights_of(portrait_lighting());
  EXPECT_LE(lights.size(), size_t(kMostLights));
  for (const DistantLight& l : lights) EXPECT_NEAR(length(l.direction), 1.f, 1e-5f);
}

TEST(Arguments, ThatNameNoLightOrLayerAreRefused) {
  EXPECT_THROW(lighting_named("moon"), Error);
  EXPECT_THROW(lighting_named("0,0,0"), Error);
  EXPECT_THROW(gains_named("specular,bark"), Error);
  EXPECT_EQ(gains_named("deep").specular, 0.f);
  EXPECT_EQ(gains_named("deep,single").single, 1.f);
}

}  // namespace
}  // namespace lamella::review
