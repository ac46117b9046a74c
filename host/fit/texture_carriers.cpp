#include "fit/texture_carriers.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "base/parallel.h"
#include "fit/order_statistics.h"

namespace lamella::fit {

namespace {

constexpr double kPixelMm = 0.6;      // of a texture: finer ones cost more and tell no more
constexpr double kDetailMm = 1.1;     // wider than pores and freckles, finer than shading
constexpr double kLeastDetailPx = 2;  // or else only noise is left
constexpr double kCoarseFringe =
    10;                             // times kDetailMm: the period of a fringe that leaves no trace
constexpr float kLitShare = 0.05f;  // of the bright end
constexpr int kFewestBlocks = 32;   // across a subject that is large enough
constexpr int kShareBox_px = 15;    // of the skin's colour
// How far registration is off where nothing moves, by twins and heads of others.
constexpr double kSameWhiteMm = 0.006;     // parts of the projector's white
constexpr double kOtherAnalyserMm = 0.03;  // with and without the surface's reflection
constexpr double kFrontalGradientMm = 0.015;
constexpr double kOtherLightMm = 0.03;  // LEDs all around, projector in front

struct Reduced {
  Image3 rgb;
  double time_us = 0;
};

Image1 sum_of_channels(const Image3& image) {
  Image1 sum;
  cv::transform(image, sum, cv::Matx13f(1, 1, 1));
  return sum;
}

// A photograph whose texture is asked for, and what it is compared with.
struct Light {
  std::string name;
  double time_us;
  Image1 image;
};

class CarrierMaker {
 public:
  CarrierMaker(const Session& session, const Camera& camera, const Photographs& photographs)
      : session_(session), camera_(camera), photographs_(photographs) {
    out_.bin_px = std::max(1, int(std::lround(kPixelMm / camera.pixel_mm())));
    out_.pixel_mm = camera.pixel_mm() * out_.bin_px;
  }

  TextureCarriers run(const Labels& labels) {
    find_box(labels);
    if (std::min(box_.width, box_.height) < kFewestBlocks * out_.bin_px) return out_;
    reduce_all();
    if (!find(Role::kFront)) return out_;
    find_subject(labels);
    const size_t front = add(*find(Role::kFront), "FRONT CROSS", without_black(Role::kFront, 0));
    add_leds(front);
    if (const Reduced* parallel = find(Role::kFront, 0, Analyser::kParallel)) {
      link(front, add(*parallel, "FRONT PARALLEL", parallel->rgb), kSameWhiteMm);
    }
    add_fringes(front);
    for (int k = 0; k < 2; ++k) add_stripes(k, front);
    make_textures();
    return std::move(out_);
  }

 private:
  using Key = std::tuple<Role, int, Analyser>;

  // The subject's part of the picture, in whole blocks.
  void find_box(const Labels& labels) {
    cv::Rect box(0, 0, camera_.width, camera_.height);
    if (!labels.empty()) box = cv::boundingRect(labels > 0);
    const int bin = out_.bin_px;
    const cv::Point first(box.x / bin, box.y / bin);
    const cv::Point end((box.x + box.width) / bin, (box.y + box.height) / bin);
    box_ = cv::Rect(first * bin, end * bin);
  }

  bool is_coarse(size_t fringe) const {
    const double width_mm = session_.projector.width * session_.projector.pixel_mm();
    return width_mm / session_.patterns.fringe_periods[fringe] > kCoarseFringe * kDetailMm;
  }

  std::vector<Key> wanted() const {
    std::vector<Key> keys;
    for (const Analyser a : {Analyser::kCross, Analyser::kParallel}) {
      for (const Role role : {Role::kGradientFull, Role::kGradientZ, Role::kFront}) {
        keys.push_back({role, 0, a});
      }
    }
    keys.push_back({Role::kBlack, 0, Analyser::kCross});
    for (int k = 0; k < 4; ++k) keys.push_back({Role::kStripes, k, Analyser::kCross});
    for (size_t k = 0; k < session_.patterns.fringe_periods.size(); ++k) {
      if (is_coarse(k)) keys.push_back({Role::kFringe, int(k), Analyser::kCross});
    }
    return keys;
  }

  void reduce_all() {
    std::vector<std::pair<Key, const Frame*>> frames;
    for (const Key& key : wanted()) {
      const auto& [role, index, analyser] = key;
      const Frame* frame = session_.find(camera_.id, role, index, analyser);
      if (frame && photographs_.count(frame)) frames.push_back({key, frame});
    }
    std::vector<Reduced> reduced(frames.size());
    parallel_for(int(frames.size()), [&](int i) {
      const Frame* frame = frames[size_t(i)].second;
      reduced[size_t(i)] = {reduce(photographs_.at(frame).radiance, frame->role),
                            frame->trigger_us};
    });
    for (size_t i = 0; i < frames.size(); ++i) reduced_[frames[i].first] = std::move(reduced[i]);
  }

  Image3 reduce(const Image3& radiance, Role role) const {
    Image3 small;
    cv::resize(radiance(box_), small, box_.size() / out_.bin_px, 0, 0, cv::INTER_AREA);
    if (role > Role::kGradientZ) {
      cv::transform(small, small, cv::Matx33f(session_.projector_to_led));
    }
    return small;
  }

  const Reduced* find(Role role, int index = 0, Analyser analyser = Analyser::kCross) const {
    const auto found = reduced_.find({role, index, analyser});
    return found == reduced_.end() ? nullptr : &found->second;
  }

  // Pattern light of the projector alone.
  Image3 without_black(Role role, int index) const {
    const Reduced* black = find(Role::kBlack);
    const Image3& rgb = find(role, index)->rgb;
    return black ? Image3(rgb - black->rgb) : rgb;
  }

  void keep_lit(Role role) {
    const Image1 light = sum_of_channels(find(role)->rgb);
    subject_ &= light > kLitShare * bright_end(light);
  }

  void find_subject(const Labels& labels) {
    const cv::Size size = find(Role::kFront)->rgb.size();
    subject_ = Mask(size, 255);
    if (!labels.empty()) {
      cv::resize(labels(box_) > 0, subject_, size, 0, 0, cv::INTER_AREA);
      subject_ = subject_ == 255;
    }
    keep_lit(Role::kFront);
    if (find(Role::kGradientFull)) keep_lit(Role::kGradientFull);
  }

  size_t add(const Reduced& taken, const std::string& name, const Image3& rgb) {
    lights_.push_back({name, taken.time_us, sum_of_channels(rgb)});
    return lights_.size() - 1;
  }

  void link(size_t from, size_t to, double sigma_mm) { out_.links.push_back({from, to, sigma_mm}); }

  void add_leds(size_t front) {
    const auto led = [&](Role role, Analyser a) {
      const Reduced* taken = find(role, 0, a);
      return add(*taken, fmt::format("{} {}", role_name(role), analyser_name(a)), taken->rgb);
    };
    if (!find(Role::kGradientFull, 0, Analyser::kParallel)) return;
    const size_t cross = led(Role::kGradientFull, Analyser::kCross);
    const size_t parallel = led(Role::kGradientFull, Analyser::kParallel);
    link(front, cross, kOtherLightMm);
    link(cross, parallel, kOtherAnalyserMm);
    link(cross, led(Role::kGradientZ, Analyser::kCross), kFrontalGradientMm);
    link(parallel, led(Role::kGradientZ, Analyser::kParallel), kFrontalGradientMm);
  }

  // Three cosines a third of a turn apart: their sum is white, each channel by what it is of that.
  void add_fringes(size_t front) {
    const Image3 white = without_black(Role::kFront, 0);
    Image3 share;
    cv::blur(white, share, cv::Size(kShareBox_px, kShareBox_px));
    for (size_t k = 0; k < session_.patterns.fringe_periods.size(); ++k) {
      const Reduced* fringe = find(Role::kFringe, int(k));
      if (!fringe) continue;
      Image3 even = without_black(Role::kFringe, int(k));
      for (int y = 0; y < even.rows; ++y) {
        for (int x = 0; x < even.cols; ++x) {
          const Vec3& s = share(y, x);
          const float whole = s[0] + s[1] + s[2];
          for (int c = 0; c < 3; ++c) even(y, x)[c] *= whole / std::max(s[c], 0.02f * whole);
        }
      }
      link(front, add(*fringe, fmt::format("FRINGE {}", k), even), kSameWhiteMm);
    }
  }

  // Half a period apart, two are white.
  void add_stripes(int first, size_t front) {
    const Patterns& patterns = session_.patterns;
    if (std::abs(4 * patterns.stripe_shift_px - patterns.stripe_period_px) > 1e-6) return;
    const Reduced *a = find(Role::kStripes, first), *b = find(Role::kStripes, first + 2);
    if (!a || !b) return;
    Reduced both{a->rgb + b->rgb, 0.5 * (a->time_us + b->time_us)};
    if (const Reduced* black = find(Role::kBlack)) both.rgb -= black->rgb * 2;
    link(front, add(both, fmt::format("STRIPES {} and {}", first, first + 2), both.rgb),
         kSameWhiteMm);
  }

  void make_textures() {
    out_.carriers.resize(lights_.size());
    const double detail_px = std::max(kLeastDetailPx, kDetailMm / out_.pixel_mm);
    parallel_for(int(lights_.size()), [&](int i) {
      const Light& light = lights_[size_t(i)];
      out_.carriers[size_t(i)] = {light.name, light.time_us,
                                  texture_of(light.image, subject_, detail_px)};
    });
  }

  const Session& session_;
  const Camera& camera_;
  const Photographs& photographs_;
  cv::Rect box_;
  std::map<Key, Reduced> reduced_;
  Mask subject_;
  std::vector<Light> lights_;
  TextureCarriers out_;
};

}  // namespace

TextureCarriers texture_carriers(const Session& session, const Camera& camera,
                                 const Photographs& photographs, const Labels& labels) {
  return CarrierMaker(session, camera, photographs).run(labels);
}

}  // namespace lamella::fit
