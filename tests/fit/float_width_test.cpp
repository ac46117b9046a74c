// What the fit's inner loops lose by being in single precision: each against the same formula in
// double precision, over all that it is asked for. The largest relative difference is printed.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "fit/led_response.h"
#include "model/multipole.h"
#include "synthetic_sphere.h"

namespace lamella::fit {
namespace {

class Difference {
 public:
  explicit Difference(const char* name) : name_(name) {}

  // `floor`: what is next to nothing beside the largest value.
  void add(double found, double exact, double floor = 0) {
    largest_ = std::max(largest_, std::abs(found - exact) / std::max(std::abs(exact), floor));
  }

  // Prints it, too.
  double largest() const {
    fmt::print("float against double: {}: {:.1e}, relative, at most\n", name_, largest_);
    return largest_;
  }

 private:
  const char* name_;
  double largest_ = 0;
};

// The table's own cells, looked up in double precision.
double exact_density(const model::LobeTable& lobe, double cosine) {
  const double x = (1 - cosine) * model::LobeTable::kCells;
  const auto i = size_t(x);
  const double below = double(lobe.cells()[i]), above = double(lobe.cells()[i + 1]);
  return below + (x - double(i)) * (above - below);
}

// f of eq. 3 times (n.l) for amplitude 1.
double exact_single(const SkinModel& skin, const Vec3d& n, const Vec3d& l, const Vec3d& v) {
  const double n_l = n.dot(l), n_v = n.dot(v), g = double(skin.g);
  const double cos_l = model::refracted_cosine(n_l), cos_v = model::refracted_cosine(n_v);
  const double cosine = model::scattering_cosine(l.dot(v), n_l, n_v, cos_l, cos_v);
  return n_l * model::alpha_from_amplitude(1, g) * double(skin.transmittance(float(n_l))) *
         double(skin.transmittance(float(n_v))) * model::henyey_greenstein(cosine, g) /
         (cos_l + cos_v);
}

double exact_lobe(const SkinModel& skin, const Vec3d& n, const Vec3d& l, const Vec3d& v) {
  const Vec3d h = cv::normalize(l + v);
  const double v_h = v.dot(h), n_h = n.dot(h), n_l = n.dot(l), n_v = n.dot(v);
  return exact_density(skin.lobe, n_h) * model::fresnel_reflectance(v_h) *
         model::v_groove(n_h, n_v, n_l, v_h) / n_v;
}

SkinModel skin_of(double m) {
  const model::LobeTable lobe = gaussian_lobe(m);
  return {lobe, model::TransmittanceTable(lobe, 0.25), 0.65f};
}

// Directions from the normal to just above the horizon, with every azimuth between them.
std::vector<Vec3> directions() {
  std::vector<Vec3> all;
  for (int i = 0; i <= 14; ++i) {
    for (int k = 0; k < 12; ++k) {
      const float theta = 0.11f * float(i), phi = 0.5236f * float(k);
      all.push_back(
          {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    }
  }
  return all;
}

TEST(FloatWidth, OfTheSurfaceLobeAndOfSingleScattering) {
  const SkinModel skin = skin_of(0.2);
  const Vec3 n(0, 0, 1);
  Difference lobe("surface lobe"), single("single scattering");
  const double peak = double(skin.lobe.density(1));
  for (const Vec3& l : directions()) {
    for (const Vec3& v : directions()) {
      const double n_l = double(l[2]);
      lobe.add(double(model::torrance_sparrow(skin.lobe, n, l, v)) * n_l, exact_lobe(skin, n, l, v),
               1e-4 * peak);
      single.add(double(model::single_scattering(skin.transmittance, skin.g, n, l, v)) * n_l,
                 exact_single(skin, n, l, v));
    }
  }
  EXPECT_LT(lobe.largest(), 3e-5);
  EXPECT_LT(single.largest(), 3e-6);
}

TEST(FloatWidth, OfTheDipoleTheMultipoleAndTheTableOfAlpha) {
  Difference dipole("dipole"), multipole("multipole"), alpha("table of alpha'");
  for (const double a : {0.3, 0.9, 0.99}) {
    for (double r_mm = 0.1; r_mm < 8; r_mm *= 1.3) {
      dipole.add(double(model::dipole_reflectance(model::Dipole<float>{float(a), 1.f}, r_mm)),
                 model::dipole_reflectance(model::Dipole<double>{double(float(a)), 1}, r_mm));
      const model::Multipole<double> slab{double(float(a)), 1, 0.5};
      multipole.add(
          double(model::multipole_reflectance(model::Multipole<float>{float(a), 1.f, 0.5}, r_mm)),
          model::multipole_reflectance(slab, r_mm), 1e-6 * model::multipole_reflectance(slab, 0.1));
    }
  }
  const model::AlphaTable table;
  for (float r = 0.001f; r < 0.97f; r += 0.0037f) {
    alpha.add(double(table.alpha(r)), *model::alpha_from_reflectance(double(r)), 0.05);
  }
  EXPECT_LT(dipole.largest(), 3e-6);
  EXPECT_LT(multipole.largest(), 2e-4);
  EXPECT_LT(alpha.largest(), 2e-4);
}

// In lanes of eight, with divisions taken together: what every pixel is fitted with.
TEST(FloatWidth, OfTheResponseToTheLeds) {
  const LightStage stage = even_stage();
  const Surroundings around;
  const LightVisibility visibility(around);
  const LedField field(stage, visibility);
  const SkinModel skin = skin_of(0.3);
  Difference lobe("lobe under the LEDs"), single("single scattering under the LEDs");
  for (const Vec3& n : directions()) {
    const Vec3 v = unit(Vec3(0.1f, 0.2f, 1));
    if (dot(n, v) < 0.1f) continue;
    LedCell cell;
    field.enter_cell(32, 32, {{0, 0, 0}, n, v}, &cell);
    field.enter_pixel(32, 32, n, &cell);
    double exact_lobes = 0, exact_singles = 0;
    for (size_t i = 0; i < cell.used; ++i) {
      const Vec3 l(cell.x[i], cell.y[i], cell.z[i]);
      if (dot(n, l) <= kLedHorizon || cell.reached[i] <= 0) continue;
      const double light = M_PI * double(cell.reached[i]);
      exact_lobes += light * exact_lobe(skin, n, l, v);
      exact_singles += light * exact_single(skin, n, l, v);
    }
    const LedResponse found = led_response(cell, skin, n, v);
    lobe.add(double(found.lobe), exact_lobes);
    single.add(double(found.single), exact_singles);
  }
  EXPECT_LT(lobe.largest(), 2e-4);
  EXPECT_LT(single.largest(), 3e-6);
}

}  // namespace
}  // namespace lamella::fit
