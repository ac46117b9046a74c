#include "io/face_maps.h"

#include <algorithm>
#include <functional>

#include "base/error.h"
#include "base/fill.h"
#include "base/parallel.h"
#include "base/rim.h"
#include "io/doubtful.h"

namespace lamella {

namespace {

constexpr float kUnlitShare =
    0.15f;  // of the median albedo; below, the picture is out of the light

const Image3& diffuse_albedo(const LayerMaps& maps, const std::string& where) {
  if (!maps.total_albedo.empty()) return maps.total_albedo;
  if (!maps.deep_albedo.empty()) return maps.deep_albedo;
  throw_bad_input(where, "no total_albedo.exr", "run fit to its end");
}

float brightest(const Vec3& rgb) { return std::max({rgb[0], rgb[1], rgb[2]}); }

float median_brightness(const Image3& albedo) {
  std::vector<float> values;
  for (int y = 0; y < albedo.rows; y += 4) {
    for (int x = 0; x < albedo.cols; x += 4) {
      if (is_finite(albedo(y, x)) && brightest(albedo(y, x)) > 0.f) {
        values.push_back(brightest(albedo(y, x)));
      }
    }
  }
  if (values.empty()) return 0.f;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

// 255 where `answer(y, x)`.
template <class Answer>
Mask mask_of(cv::Size size, const Answer& answer) {
  Mask mask(size, uchar(0));
  parallel_for(
      size.height,
      [&](int y) {
        for (int x = 0; x < size.width; ++x) mask(y, x) = answer(y, x) ? 255 : 0;
      },
      32);
  return mask;
}

template <class Image>
Image dressed(const Image& map, const FaceOutline& outline) {
  if (map.empty()) return map;
  Image inner = map(outline.box).clone();
  inner.setTo(cv::Scalar::all(kNaN), outline.torn);
  return fill_unknown(inner);
}

// Columns: what the position gains per pixel to the right, per pixel down, and at pixel (0, 0).
cv::Matx33f mean_slope(const Image3& position_mm) {
  cv::Matx33d squares = cv::Matx33d::zeros(), products = cv::Matx33d::zeros();
  for (int y = 0; y < position_mm.rows; y += 4) {
    for (int x = 0; x < position_mm.cols; x += 4) {
      if (!is_finite(position_mm(y, x))) continue;
      const Vec3d at(x, y, 1), p = position_mm(y, x);
      squares += at * at.t();
      products += p * at.t();
    }
  }
  return products * squares.inv();
}

// A position goes on growing where nothing was measured: filled relative to the mean slope, so that
// the mesh does not fold at its border.
Image3 dressed_positions(const Image3& position_mm, const FaceOutline& outline) {
  Image3 relative = position_mm(outline.box).clone();
  relative.setTo(cv::Scalar::all(kNaN), outline.torn);
  const cv::Matx33f slope = mean_slope(relative);
  const auto add = [&](Image3* image, float sign) {
    parallel_for(
        image->rows,
        [&](int y) {
          for (int x = 0; x < image->cols; ++x) {
            (*image)(y, x) += slope * Vec3(float(x), float(y), 1.f) * sign;
          }
        },
        32);
  };
  add(&relative, -1.f);
  Image3 filled = fill_unknown(relative);
  add(&filled, 1.f);
  smooth_along_rim(outline.inside_px, &filled);
  return filled;
}

void normalise(Image3* normals) {
  parallel_for(
      normals->rows,
      [&](int y) {
        for (int x = 0; x < normals->cols; ++x) (*normals)(y, x) = unit((*normals)(y, x));
      },
      32);
}

}  // namespace

FaceMaps face_from_maps(const LayerMaps& measured, const std::string& where) {
  const LayerMaps maps = without_doubtful(measured);
  const Image3& albedo = diffuse_albedo(measured, where);
  const auto known = [&](int y, int x) {
    return is_finite(maps.position_mm(y, x)) && is_finite(measured.normal_specular(y, x)) &&
           is_finite(albedo(y, x));
  };
  const float unlit = kUnlitShare * median_brightness(albedo);
  const auto lit = [&](int y, int x) { return known(y, x) && brightest(albedo(y, x)) > unlit; };
  FaceMaps face;
  face.outline = outline_face(maps.position_mm, mask_of(albedo.size(), lit));
  const cv::Rect box = face.outline.box;
  if (box.empty())
    throw_bad_input(where, "no pixel has position, normal and albedo", "run fit again");
  std::vector<std::function<void()>> jobs;
  for (Image3 LayerMaps::*m :
       {&LayerMaps::normal_specular, &LayerMaps::single_albedo, &LayerMaps::total_albedo,
        &LayerMaps::shallow_albedo, &LayerMaps::deep_albedo, &LayerMaps::deep_alpha,
        &LayerMaps::deep_ld_mm}) {
    jobs.push_back([&, m] { face.maps.*m = dressed(maps.*m, face.outline); });
  }
  jobs.push_back(
      [&] { face.maps.position_mm = dressed_positions(maps.position_mm, face.outline); });
  for (int c = 0; c < 3; ++c) {
    jobs.push_back([&, c] {
      face.maps.normal_diffuse[c] = dressed(maps.normal_diffuse[c], face.outline);
      normalise(&face.maps.normal_diffuse[c]);
    });
  }
  jobs.push_back(
      [&] { face.maps.specular_intensity = dressed(maps.specular_intensity, face.outline); });
  parallel_for(int(jobs.size()), [&](int i) { jobs[size_t(i)](); });
  normalise(&face.maps.normal_specular);
  face.maps.regions = maps.regions(box).clone();
  for (const auto& [name, map] : maps.confidence) face.maps.confidence[name] = map(box).clone();
  return face;
}

}  // namespace lamella
