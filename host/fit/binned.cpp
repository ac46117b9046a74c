#include "fit/binned.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"
#include "calib/pattern_scale.h"
#include "fit/smooth.h"

namespace lamella::fit {

namespace {

int blocks_of(int pixels, int bin_px) { return (pixels + bin_px - 1) / bin_px; }

cv::Size binned_size(const cv::Size& size, int bin_px) {
  return {blocks_of(size.width, bin_px), blocks_of(size.height, bin_px)};
}

Camera binned_camera(Camera camera, int bin_px) {
  camera.width = blocks_of(camera.width, bin_px);
  camera.height = blocks_of(camera.height, bin_px);
  camera.fx /= bin_px;
  camera.fy /= bin_px;
  camera.cx = (camera.cx + 0.5) / bin_px - 0.5;
  camera.cy = (camera.cy + 0.5) / bin_px - 0.5;
  return camera;
}

Image3 binned(const Image3& image, int bin_px) {
  if (image.empty()) return {};
  Image3 out(binned_size(image.size(), bin_px));
  parallel_for(out.rows, [&](int y) {
    const int end_y = std::min(image.rows, (y + 1) * bin_px);
    for (int x = 0; x < out.cols; ++x) {
      const int end_x = std::min(image.cols, (x + 1) * bin_px);
      Vec3 sum(0, 0, 0);
      for (int j = y * bin_px; j < end_y; ++j) {
        const Vec3* row = image[j];
        for (int i = x * bin_px; i < end_x; ++i) sum += row[i];
      }
      out(y, x) = sum * (1.f / float((end_y - y * bin_px) * (end_x - x * bin_px)));
    }
  });
  return out;
}

AnalyserPair binned(const AnalyserPair& pair, int bin_px) {
  return {binned(pair.parallel, bin_px), binned(pair.cross, bin_px)};
}

// `chosen(count)` of how often each value is in a block.
template <class Choice>
cv::Mat1b binned_bytes(const cv::Mat1b& image, int bin_px, const Choice& chosen) {
  cv::Mat1b out(binned_size(image.size(), bin_px));
  parallel_for(out.rows, [&](int y) {
    for (int x = 0; x < out.cols; ++x) {
      std::array<int, 256> count{};
      for (int j = y * bin_px; j < std::min(image.rows, (y + 1) * bin_px); ++j) {
        for (int i = x * bin_px; i < std::min(image.cols, (x + 1) * bin_px); ++i) {
          ++count[image(j, i)];
        }
      }
      out(y, x) = uchar(chosen(count));
    }
  });
  return out;
}

Mask binned_mask(const Mask& mask, int bin_px) {
  return binned_bytes(mask, bin_px, [](const auto& count) { return count[255] ? 255 : 0; });
}

cv::Mat3b binned_channels(const cv::Mat3b& channels, int bin_px) {
  if (channels.empty()) return {};
  std::array<Mask, 3> planes;
  cv::split(channels, planes.data());
  for (Mask& plane : planes) plane = binned_mask(plane, bin_px);
  cv::Mat3b out;
  cv::merge(planes.data(), planes.size(), out);
  return out;
}

Labels binned_labels(const Labels& labels, int bin_px) {
  return binned_bytes(labels, bin_px, [](const auto& count) {
    return std::max_element(count.begin(), count.end()) - count.begin();
  });
}

void bin_noise(NoiseModel* noise, int bin_px) {
  noise->read_variance /= bin_px * bin_px;
  noise->photon_variance_per_unit /= bin_px * bin_px;
}

float unknown(float) { return kNaN; }
Vec3 unknown(const Vec3&) { return Vec3::all(kNaN); }

// What each of the four blocks around every pixel says of it.
class Spread {
 public:
  Spread(const Labels& regions, const Image3& position_mm, const Camera& left, int bin_px)
      : bin_px_(bin_px), weights_(regions.size(), cv::Vec4f::all(0)) {
    parallel_for(regions.rows, [&](int y) {
      for (int x = 0; x < regions.cols; ++x) {
        if (regions(y, x)) weights_(y, x) = weights_at(y, x, position_mm, left);
      }
    });
  }

  template <class Value>
  void apply(cv::Mat_<Value>* map) const {
    if (map->empty()) return;
    cv::Mat_<Value> out(weights_.size());
    parallel_for(out.rows, [&](int y) {
      for (int x = 0; x < out.cols; ++x) {
        const bool known = weights_(y, x) != cv::Vec4f::all(0);
        out(y, x) = known ? value_at(y, x, *map) : unknown(Value());
      }
    });
    *map = out;
  }

 private:
  struct Blocks {
    std::array<cv::Point, 4> at;
    float right, below;  // shares of the blocks to the right and below
  };

  Blocks blocks_around(int y, int x, const cv::Size& size) const {
    const float u = (float(x) + 0.5f) / float(bin_px_) - 0.5f;
    const float v = (float(y) + 0.5f) / float(bin_px_) - 0.5f;
    const int x0 = int(std::floor(u)), y0 = int(std::floor(v));
    Blocks blocks{{}, u - float(x0), v - float(y0)};
    for (int k = 0; k < 4; ++k) {
      blocks.at[size_t(k)] = {std::clamp(x0 + k % 2, 0, size.width - 1),
                              std::clamp(y0 + k / 2, 0, size.height - 1)};
    }
    return blocks;
  }

  cv::Vec4f weights_at(int y, int x, const Image3& position_mm, const Camera& left) const {
    const Blocks blocks = blocks_around(y, x, position_mm.size());
    cv::Vec4f weights;
    int nearest = -1;
    for (int k = 0; k < 4; ++k) {
      if (!is_finite(position_mm(blocks.at[size_t(k)]))) continue;
      weights[k] =
          (k % 2 ? blocks.right : 1 - blocks.right) * (k / 2 ? blocks.below : 1 - blocks.below);
      if (nearest < 0 || weights[k] > weights[nearest]) nearest = k;
    }
    if (nearest < 0) return weights;
    const Vec3 here = position_mm(blocks.at[size_t(nearest)]);
    const float block_mm = float(left.depth_mm(here) / left.fx) * float(bin_px_);
    for (int k = 0; k < 4; ++k) {
      const float step_mm = length(position_mm(blocks.at[size_t(k)]) - here);
      if (!(step_mm < silhouette_step_mm(2, block_mm))) weights[k] = 0;
    }
    return weights;
  }

  template <class Value>
  Value value_at(int y, int x, const cv::Mat_<Value>& map) const {
    const Blocks blocks = blocks_around(y, x, map.size());
    Value sum{};
    float total = 0;
    for (int k = 0; k < 4; ++k) {
      const Value value = map(blocks.at[size_t(k)]);
      const float weight = weights_(y, x)[k];
      if (weight == 0 || !is_finite(value)) continue;
      sum += value * weight;
      total += weight;
    }
    return total > 0 ? sum * (1 / total) : unknown(sum);
  }

  int bin_px_;
  cv::Mat4f weights_;
};

void make_unit(Image3* map) {
  parallel_for(map->rows, [&](int y) {
    for (int x = 0; x < map->cols; ++x) (*map)(y, x) = unit((*map)(y, x));
  });
}

}  // namespace

int resolving_bin_px(const Session& session, int asked) {
  const PatternScale scale = pattern_scale(session);
  const double most = std::min(scale.stripe_px / kLeastBlockScale.stripe_px,
                               scale.dot_px / kLeastBlockScale.dot_px);
  return std::clamp(int(std::min(most, double(asked))), 1, asked);
}

Session binned_session(const Session& session, int bin_px) {
  Session out = session;
  out.left = binned_camera(session.left, bin_px);
  if (session.right) out.right = binned_camera(*session.right, bin_px);
  return out;
}

Burst binned_burst(const Burst& burst, const Session& session, int bin_px) {
  Burst out = burst;
  out.session = &session;
  for (AnalyserPair* pair :
       {&out.full, &out.gradient[0], &out.gradient[1], &out.gradient[2], &out.front}) {
    *pair = binned(*pair, bin_px);
  }
  for (Image3* image : {&out.black, &out.front_lit, &out.dots, &out.right_front_lit}) {
    *image = binned(*image, bin_px);
  }
  for (Image3& image : out.fringe) image = binned(image, bin_px);
  for (Image3& image : out.stripes) image = binned(image, bin_px);
  for (Image3& image : out.right_fringe) image = binned(image, bin_px);
  out.regions = binned_labels(burst.regions, bin_px);
  out.clipped_led_cross = binned_channels(burst.clipped_led_cross, bin_px);
  for (Mask* mask : {&out.clipped_led, &out.clipped_projector, &out.clipped_dots,
                     &out.clipped_stripes, &out.clipped_fringe, &out.clipped_right}) {
    *mask = binned_mask(*mask, bin_px);
  }
  for (NoiseModel* noise : {&out.led_noise, &out.led_parallel_noise, &out.projector_noise,
                            &out.front_parallel_noise, &out.right_noise}) {
    bin_noise(noise, bin_px);
  }
  out.dots_place.rest_px /= float(bin_px);
  for (PatternPlace& place : out.stripes_place) place.rest_px /= float(bin_px);
  return out;
}

void unbin_maps(const Labels& regions, const Camera& left, int bin_px, LayerMaps* maps) {
  maps->regions = regions;
  if (maps->position_mm.empty()) return;
  const Spread spread(regions, maps->position_mm, left, bin_px);
  for (Image3* map : {&maps->position_mm, &maps->normal_specular, &maps->normal_diffuse[0],
                      &maps->normal_diffuse[1], &maps->normal_diffuse[2], &maps->single_albedo,
                      &maps->total_albedo, &maps->shallow_albedo, &maps->deep_albedo,
                      &maps->deep_alpha, &maps->deep_ld_mm}) {
    spread.apply(map);
  }
  spread.apply(&maps->specular_intensity);
  for (auto& [name, map] : maps->confidence) spread.apply(&map);
  for (auto& [name, map] : maps->stddev) spread.apply(&map);
  for (Image3* map : {&maps->normal_specular, &maps->normal_diffuse[0], &maps->normal_diffuse[1],
                      &maps->normal_diffuse[2]}) {
    make_unit(map);
  }
}

}  // namespace lamella::fit
