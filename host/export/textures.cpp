#include "export/textures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "base/fill.h"
#include "base/parallel.h"
#include "export/normal_bake.h"
#include "export/picture_jpeg.h"
#include "io/picture_png.h"

namespace lamella::exporting {

namespace {

constexpr int kJpegQuality = 92;
constexpr float kDielectricC = 0.25f;  // c of a clean smooth interface: specular strength 1
constexpr int kRoughnessSidePx = 256;  // six regions and soft borders need no more
constexpr float kBorderBlur = 0.012f;  // of the roughness, share of the width
constexpr float kDefaultAlpha = 0.3f;  // skin of no region: the middle of the paper's widths

cv::Size limited(cv::Size size, int side_px) {
  const double scale = std::min(1.0, double(side_px) / std::max(size.width, size.height));
  return {std::max(1, int(std::lround(size.width * scale))),
          std::max(1, int(std::lround(size.height * scale)))};
}

template <class Image>
Image fitted(const Image& map, int side_px) {
  const cv::Size size = limited(map.size(), side_px);
  if (size == map.size()) return map;
  Image result;
  cv::resize(map, result, size, 0, 0, cv::INTER_AREA);
  return result;
}

uchar byte_of(float value) { return uchar(std::clamp(value, 0.f, 1.f) * 255.f + 0.5f); }

EncodedImage encoded(const char* name, const cv::Mat& bgr, bool as_jpeg) {
  if (as_jpeg) return {name, "image/jpeg", encode_jpeg(bgr, kJpegQuality)};
  const std::string png = encode_png(bgr);
  return {name, "image/png", {png.begin(), png.end()}};
}

// Bytes in OpenCV's order, b g r.
cv::Mat3b bytes_of(const Image3& rgb, const std::function<uchar(float)>& byte) {
  cv::Mat3b bgr(rgb.size());
  parallel_for(
      rgb.rows,
      [&](int y) {
        for (int x = 0; x < rgb.cols; ++x) {
          const Vec3& v = rgb(y, x);
          bgr(y, x) = {byte(v[2]), byte(v[1]), byte(v[0])};
        }
      },
      16);
  return bgr;
}

std::vector<uchar> srgb_table() {
  std::vector<uchar> table(4096);
  for (size_t i = 0; i < table.size(); ++i) table[i] = byte_of(srgb_from_linear(float(i) / 4095.f));
  return table;
}

EncodedImage base_colour(const FaceMaps& face, int side_px) {
  static const std::vector<uchar> kTable = srgb_table();
  const LayerMaps& m = face.maps;
  Image3 albedo = m.total_albedo;
  if (albedo.empty())
    albedo = m.shallow_albedo.empty() ? m.deep_albedo : Image3(m.deep_albedo + m.shallow_albedo);
  const auto byte = [](float a) { return kTable[size_t(std::clamp(a, 0.f, 1.f) * 4095.f + 0.5f)]; };
  return encoded("base_colour", bytes_of(fitted(albedo, side_px), byte), true);
}

EncodedImage normal_texture(const FaceMaps& face, const EngineMesh& mesh, int side_px) {
  const Image3 t = tangent_space_normals(fitted(face.maps.normal_specular, side_px), mesh);
  return encoded("normal", bytes_of(t, [](float a) { return byte_of(0.5f + 0.5f * a); }), false);
}

EncodedImage roughness_texture(const FaceMaps& face, const v1::Layers& layers, int side_px) {
  const Labels& regions = face.maps.regions;
  const cv::Size size = limited(regions.size(), std::min(kRoughnessSidePx, side_px));
  Labels small;
  cv::resize(regions, small, size, 0, 0, cv::INTER_NEAREST);
  Image1 alpha(size, kNaN);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const int i = small(y, x) - 1;
      if (i < 0 || i >= layers.regions_size() || !layers.regions(i).has_specular()) continue;
      alpha(y, x) = 0.f;
    }
  }
  std::vector<float> of_region(size_t(layers.regions_size()), kDefaultAlpha);
  for (int i = 0; i < layers.regions_size(); ++i) {
    if (layers.regions(i).has_specular()) of_region[i] = ggx_alpha(layers.regions(i).specular());
  }
  for (int i = 0; i < size.area(); ++i) {
    float& a = alpha(i / size.width, i % size.width);
    if (is_finite(a)) a = of_region[small(i / size.width, i % size.width) - 1];
  }
  const bool any = cv::countNonZero(alpha == alpha) > 0;
  alpha = any ? fill_unknown(alpha) : Image1(size, kDefaultAlpha);
  cv::GaussianBlur(alpha, alpha, {}, 1.0 + kBorderBlur * size.width);
  cv::Mat3b bgr(size);
  for (int i = 0; i < size.area(); ++i) {
    const int y = i / size.width, x = i % size.width;
    bgr(y, x) = {0, byte_of(std::sqrt(alpha(y, x))), 255};
  }
  return encoded("roughness", bgr, false);
}

void specular_texture(const FaceMaps& face, int side_px, FaceTextures* textures) {
  Image1 c(face.maps.position_mm.size(), kDielectricC);
  if (!face.maps.specular_intensity.empty()) c = face.maps.specular_intensity;
  c = fitted(c, side_px / 2);
  std::vector<float> sorted(c.begin(), c.end());
  const size_t high = sorted.size() * 995 / 1000;
  std::nth_element(sorted.begin(), sorted.begin() + high, sorted.end());
  // Strength goes to 1 at most; a stronger reflection is carried by the colour factor.
  const float largest = std::max(sorted[high], kDielectricC);
  textures->specular_colour_factor = largest / kDielectricC;
  cv::Mat4b bgra(c.size(), cv::Vec4b(255, 255, 255, 255));
  for (int y = 0; y < c.rows; ++y) {
    for (int x = 0; x < c.cols; ++x) bgra(y, x)[3] = byte_of(c(y, x) / largest);
  }
  textures->specular = encoded("specular", bgra, false);
}

float ggx(float alpha, float theta_rad) {
  const float c = std::cos(theta_rad), a2 = alpha * alpha, d = c * c * (a2 - 1.f) + 1.f;
  return a2 / (kPi * d * d);
}

}  // namespace

float srgb_from_linear(float a) {
  return a <= 0.0031308f ? 12.92f * a : 1.055f * std::pow(a, 1.f / 2.4f) - 0.055f;
}

float ggx_alpha(const v1::SpecularLobe& lobe) {
  if (lobe.theta_size() < 2 || lobe.p_size() != lobe.theta_size()) {
    return lobe.has_gaussian_m() ? std::clamp(float(lobe.gaussian_m()), 0.05f, 1.f) : kDefaultAlpha;
  }
  float best = kDefaultAlpha;
  double least = 1e300;
  for (float alpha = 0.05f; alpha <= 1.f; alpha += 0.005f) {
    double error = 0;
    for (int i = 0; i < lobe.theta_size(); ++i) {
      const float theta = float(lobe.theta(i));
      const double d = lobe.p(i) - ggx(alpha, theta);
      error += d * d * std::sin(theta);
    }
    if (error < least) {
      least = error;
      best = alpha;
    }
  }
  return best;
}

FaceTextures face_textures(const FaceMaps& face, const v1::Layers& layers, const EngineMesh& mesh,
                           int side_px) {
  FaceTextures textures;
  const std::function<void()> jobs[] = {
      [&] { textures.normal = normal_texture(face, mesh, side_px); },
      [&] { textures.base_colour = base_colour(face, side_px); },
      [&] { textures.roughness = roughness_texture(face, layers, side_px); },
      [&] { specular_texture(face, side_px, &textures); },
  };
  parallel_for(int(std::size(jobs)), [&](int i) { jobs[i](); });
  return textures;
}

}  // namespace lamella::exporting
