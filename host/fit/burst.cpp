#include "fit/burst.h"

#include <algorithm>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "base/error.h"
#include "base/parallel.h"
#include "base/process_heap.h"
#include "fit/order_statistics.h"

namespace lamella::fit {

namespace {

constexpr double kQuantisationSteps = 4095;  // 12 bits over the saturation, as the format says
constexpr double kClippedShare = 1 - 1e-5;   // of the saturation, after two roundings
constexpr double kLitShare = 0.05;           // of the bright end: darker than this is background

// Where one photograph of the burst goes.
struct Slot {
  const Frame* frame;
  Image3* image;
};

bool is_projector_lit(Role role) {
  return role == Role::kFringe || role == Role::kBlack || role == Role::kDots ||
         role == Role::kFront || role == Role::kStripes;
}

void transform_colours(Image3* image, const Mat33d& matrix) {
  if (matrix == Mat33d::eye()) return;
  const cv::Matx33f m(matrix);
  parallel_for(image->rows, [&](int y) {
    Vec3* row = (*image)[y];
    for (int x = 0; x < image->cols; ++x) row[x] = m * row[x];
  });
}

Image3 difference(const Image3& a, const Image3& b) {
  Image3 out(a.size());
  parallel_for(a.rows, [&](int y) {
    for (int x = 0; x < a.cols; ++x) out(y, x) = a(y, x) - b(y, x);
  });
  return out;
}

void subtract(Image3* image, const Image3& offset) {
  if (image->empty() || offset.empty()) return;
  parallel_for(image->rows, [&](int y) {
    for (int x = 0; x < image->cols; ++x) (*image)(y, x) -= offset(y, x);
  });
}

// cross = D/2 + e S and parallel = S + D/2: solve for S and D/2.
void remove_extinction(AnalyserPair* pair, double extinction) {
  if (extinction <= 0) return;
  const float e = float(extinction);
  parallel_for(pair->cross.rows, [&](int y) {
    for (int x = 0; x < pair->cross.cols; ++x) {
      const Vec3 s = (pair->parallel(y, x) - pair->cross(y, x)) * (1.f / (1.f - e));
      pair->cross(y, x) -= s * e;
      pair->parallel(y, x) = pair->cross(y, x) + s;
    }
  });
}

class Reader {
 public:
  explicit Reader(const Session& session) : session_(session) {}

  void add(const std::string& camera, Role role, int index, Analyser analyser, Image3* image) {
    if (const Frame* frame = session_.find(camera, role, index, analyser)) {
      slots_.push_back({frame, image});
    }
  }

  // Fills every image, and the burst's masks of clipped pixels.
  void take(const Photographs& photographs, Burst* burst) {
    std::vector<Mask> clipped(slots_.size());
    parallel_for(int(slots_.size()), [&](int slot) {
      const size_t i = size_t(slot);
      const Photograph& photograph = photographs.at(slots_[i].frame);
      *slots_[i].image = photograph.radiance;
      if (is_projector_lit(slots_[i].frame->role)) {
        transform_colours(slots_[i].image, session_.projector_to_led);
      }
      clipped[i] = photograph.clipped;
    });
    for (size_t i = 0; i < slots_.size(); ++i) {
      if (clipped[i].empty()) continue;
      const Frame& frame = *slots_[i].frame;
      for (Mask* mask : masks_of(frame, burst)) add(clipped[i], mask);
      const bool by_leds = !is_projector_lit(frame.role);
      if (by_leds && frame.camera == "left" && frame.analyser == Analyser::kCross) {
        add_channels(frame, photographs.at(&frame), &burst->clipped_led_cross);
      }
    }
  }

 private:
  // What is not measured where this frame is clipped.
  std::vector<Mask*> masks_of(const Frame& frame, Burst* burst) const {
    const int finest = int(session_.patterns.fringe_periods.size()) - 1;
    if (frame.role == Role::kFringe && frame.index != finest) return {};  // counts turns alone
    if (frame.camera != "left") return {&burst->clipped_right};
    if (frame.role == Role::kFringe) return {&burst->clipped_fringe};
    if (frame.role == Role::kDots) return {&burst->clipped_dots};
    if (frame.role == Role::kStripes) return {&burst->clipped_stripes};
    if (is_projector_lit(frame.role)) return {&burst->clipped_projector};
    return {&burst->clipped_led};
  }

  // Which channels are at the sensor's end; all, where none can be told to be.
  void add_channels(const Frame& frame, const Photograph& photograph, cv::Mat3b* to) const {
    if (to->empty()) *to = cv::Mat3b(photograph.clipped.size(), cv::Vec3b(0, 0, 0));
    const Vec3 end = frame.radiance_scale * float(kClippedShare * session_.left.saturation);
    parallel_for(to->rows, [&](int y) {
      for (int x = 0; x < to->cols; ++x) {
        if (!photograph.clipped(y, x)) continue;
        const Vec3& v = photograph.radiance(y, x);
        const bool any = v[0] >= end[0] || v[1] >= end[1] || v[2] >= end[2];
        for (int c = 0; c < 3; ++c) {
          if (!any || v[c] >= end[c]) (*to)(y, x)[c] = 255;
        }
      }
    });
  }

  static void add(const Mask& clipped, Mask* to) {
    if (to->empty()) *to = Mask(clipped.size(), 0);
    cv::bitwise_or(*to, clipped, *to);
  }

  const Session& session_;
  std::vector<Slot> slots_;
};

// Of photographs like the one of `role`, whose radiance_scale turns stored values into radiance.
NoiseModel noise_of(const Session& session, const Camera& camera, Role role,
                    Analyser analyser = Analyser::kCross) {
  const Frame* frame = session.find(camera.id, role, 0, analyser);
  const double scale = frame ? mean(frame->radiance_scale) : 1;
  const bool known = camera.saturation < 1e29;
  const double step = known ? camera.saturation / kQuantisationSteps : 0;
  NoiseModel noise;
  noise.read_variance = scale * scale * (camera.read_noise * camera.read_noise + step * step / 12);
  if (known && camera.full_well_electrons > 0) {
    noise.photon_variance_per_unit = scale * camera.saturation / camera.full_well_electrons;
  }
  return noise;
}

// b: what the projector emits when told black, as a share of what it emits when told white.
float estimate_black_level(const Image3& black, const Image3& front_cross, const Labels& regions) {
  std::vector<double> dark_of(size_t(black.rows), 0), lit_of = dark_of;  // of each row
  parallel_for(black.rows, [&](int y) {
    for (int x = 0; x < black.cols; ++x) {
      if (regions(y, x) == 0) continue;
      dark_of[size_t(y)] += mean(black(y, x));
      lit_of[size_t(y)] += mean(front_cross(y, x));
    }
  });
  const double dark = std::accumulate(dark_of.begin(), dark_of.end(), 0.0);
  const double lit = std::accumulate(lit_of.begin(), lit_of.end(), 0.0);
  return lit > 0 ? float(std::clamp(dark / lit, 0.0, 0.5)) : 0.f;
}

// Without a label image the subject is the largest lit piece of the photograph.
Labels subject_mask(const Image3& front_lit) {
  Image1 brightness(front_lit.size());
  parallel_for(front_lit.rows, [&](int y) {
    for (int x = 0; x < front_lit.cols; ++x) brightness(y, x) = mean(front_lit(y, x));
  });
  cv::GaussianBlur(brightness, brightness, cv::Size(0, 0), 2.0);
  const Mask lit = brightness > kLitShare * bright_end(brightness);
  cv::Mat1i pieces, stats;
  cv::Mat centres;
  const int count = cv::connectedComponentsWithStats(lit, pieces, stats, centres);
  int largest = 1;
  for (int i = 2; i < count; ++i) {
    if (stats(i, cv::CC_STAT_AREA) > stats(largest, cv::CC_STAT_AREA)) largest = i;
  }
  Labels labels(front_lit.size(), 0);
  if (count > 1) labels.setTo(1, pieces == largest);
  return labels;
}

// BLACK shows b of what FRONT shows, polarized light that leaks through the analyser included.
void remove_projector_extinction(double extinction, Burst* burst) {
  remove_extinction(&burst->front, extinction);
  if (extinction <= 0) return;
  const float leak = float(extinction) * burst->black_level;
  burst->black -= polarized(burst->front) * leak;
}

void remove_black(Burst* burst, const Image3& right_black) {
  burst->front_lit = difference(burst->front.cross, burst->black);
  subtract(&burst->dots, burst->black);
  for (Image3& image : burst->fringe) subtract(&image, burst->black);
  for (Image3& image : burst->stripes) subtract(&image, burst->black);
  subtract(&burst->right_front_lit, right_black);
  for (Image3& image : burst->right_fringe) subtract(&image, right_black);
}

void add_left_frames(Reader* reader, Burst* burst) {
  const auto pair = [&](Role role, AnalyserPair* to) {
    reader->add("left", role, 0, Analyser::kParallel, &to->parallel);
    reader->add("left", role, 0, Analyser::kCross, &to->cross);
  };
  pair(Role::kGradientFull, &burst->full);
  pair(Role::kGradientX, &burst->gradient[0]);
  pair(Role::kGradientY, &burst->gradient[1]);
  pair(Role::kGradientZ, &burst->gradient[2]);
  pair(Role::kFront, &burst->front);
  for (size_t i = 0; i < burst->fringe.size(); ++i) {
    reader->add("left", Role::kFringe, int(i), Analyser::kCross, &burst->fringe[i]);
  }
  for (int i = 0; i < 4; ++i) {
    reader->add("left", Role::kStripes, i, Analyser::kCross, &burst->stripes[size_t(i)]);
  }
  reader->add("left", Role::kBlack, 0, Analyser::kCross, &burst->black);
  reader->add("left", Role::kDots, 0, Analyser::kCross, &burst->dots);
}

void remove_ambient(Burst* burst, const AnalyserPair& ambient) {
  // Room light is unpolarized: one photograph of it serves both analysers.
  const Image3& parallel = ambient.parallel.empty() ? ambient.cross : ambient.parallel;
  const Image3& cross = ambient.cross.empty() ? ambient.parallel : ambient.cross;
  for (AnalyserPair* pair :
       {&burst->full, &burst->gradient[0], &burst->gradient[1], &burst->gradient[2]}) {
    subtract(&pair->parallel, parallel);
    subtract(&pair->cross, cross);
  }
  if (parallel.empty()) return;
  // The colours of projector-lit photographs were turned, and with them the ambient light in them.
  Image3 turned_parallel = parallel.clone(), turned_cross = cross.clone();
  transform_colours(&turned_parallel, burst->session->projector_to_led);
  transform_colours(&turned_cross, burst->session->projector_to_led);
  subtract(&burst->front.parallel, turned_parallel);
  for (Image3* image : {&burst->front.cross, &burst->black, &burst->dots}) {
    subtract(image, turned_cross);
  }
  for (Image3& image : burst->fringe) subtract(&image, turned_cross);
  for (Image3& image : burst->stripes) subtract(&image, turned_cross);
}

// Where the patterns of a subject that moved lie on it.
void place_patterns(const Session& session, Burst* burst) {
  const auto mended_mm = [&](Role role, int index) {
    const Frame* frame = session.find("left", role, index, Analyser::kCross);
    return frame ? burst->motion.mended_mm(frame->trigger_us) : Vec3d(0, 0, 0);
  };
  const auto place = [&](Role role, int index) {
    const Frame* frame = session.find("left", role, index, Analyser::kCross);
    const cv::Vec2d by_px = burst->motion.mended_px(session.left, frame->trigger_us);
    return PatternPlace{pattern_moved_px(session.projector, mended_mm(role, index)),
                        Vec2(by_px - burst->motion.mended_whole_px(session, role))};
  };
  const int finest = int(session.patterns.fringe_periods.size()) - 1;
  burst->fringe_moved_mm = mended_mm(Role::kFringe, finest);
  burst->dots_place = place(Role::kDots, 0);
  for (int k = 0; k < 4; ++k) burst->stripes_place[size_t(k)] = place(Role::kStripes, k);
}

// When a fit lets go of a photograph. What goes at one time is read at one time: what it leaves is
// whole memory for what is larger.
int let_go(const Frame& frame) {
  if (frame.camera != "left" || frame.role == Role::kFringe) return 0;
  switch (frame.role) {
    case Role::kGradientX:
    case Role::kGradientY:
    case Role::kGradientZ:
      return 1;
    case Role::kStripes:
    case Role::kDots:
      return 2;
    default:
      return 3;
  }
}

// What a fit needs beside what is read, and nothing that it does not.
Photographs read_rest(const Session& session, ShapeFrom shape, Photographs read) {
  Photographs photographs;
  std::vector<const Frame*> rest;
  for (const Frame* frame : frames_to_fit(session, shape)) {
    const auto found = read.find(frame);
    if (found == read.end()) {
      rest.push_back(frame);
    } else {
      photographs[frame] = std::move(found->second);
    }
  }
  std::stable_sort(rest.begin(), rest.end(),
                   [](const Frame* a, const Frame* b) { return let_go(*a) < let_go(*b); });
  size_t pixels = 0;
  for (const Frame* frame : rest) pixels += size_t(session.window(frame->camera).area.area());
  warm_heap(pixels * sizeof(Vec3));
  photographs.merge(read_photographs(session, rest));
  return photographs;
}

void set_regions(const Session& session, Burst* burst) {
  burst->has_given_regions = !session.regions_file.empty();
  if (!burst->has_given_regions) {
    burst->regions = subject_mask(difference(burst->front.cross, burst->black));
    burst->region_names = {"background", "face"};
  } else {
    burst->region_names = session.region_names;
  }
  if (cv::countNonZero(burst->regions) == 0) {
    throw_bad_input((session.path / "session.json").string(), "no subject in the photographs",
                    "give a label image in regions.file");
  }
}

}  // namespace

Image3 polarized(const AnalyserPair& pair) { return difference(pair.parallel, pair.cross); }

Burst linearise(const Session& session, const TriangleMesh* mesh, Photographs read) {
  const ShapeFrom shape = mesh ? ShapeFrom::kMesh : ShapeFrom::kFringes;
  require_burst(session, shape);
  Photographs photographs = read_rest(session, shape, std::move(read));
  Burst burst;
  burst.mesh = mesh;
  if (!session.regions_file.empty()) burst.regions = read_regions(session);
  parallel_both([&] { burst.check = check_burst(session, photographs, burst.regions, shape); },
                [&] { burst.motion = estimate_motion(session, photographs, burst.regions); });
  require_usable(burst.check);
  mend_motion(session, burst.motion, &photographs);
  place_patterns(session, &burst);
  burst.session = &session;
  burst.led_noise = noise_of(session, session.left, Role::kGradientFull);
  burst.projector_noise = noise_of(session, session.left, Role::kFront);
  burst.led_parallel_noise =
      noise_of(session, session.left, Role::kGradientFull, Analyser::kParallel);
  burst.front_parallel_noise = noise_of(session, session.left, Role::kFront, Analyser::kParallel);
  if (!mesh) burst.fringe.resize(session.patterns.fringe_periods.size());
  Reader reader(session);
  add_left_frames(&reader, &burst);
  AnalyserPair ambient;
  reader.add("left", Role::kAmbient, 0, Analyser::kParallel, &ambient.parallel);
  reader.add("left", Role::kAmbient, 0, Analyser::kCross, &ambient.cross);
  Image3 right_black;
  if (!mesh && has_right_geometry(session)) {
    burst.right_noise = noise_of(session, *session.right, Role::kFront);
    burst.right_fringe.resize(burst.fringe.size());
    for (size_t i = 0; i < burst.fringe.size(); ++i) {
      reader.add("right", Role::kFringe, int(i), Analyser::kCross, &burst.right_fringe[i]);
    }
    reader.add("right", Role::kFront, 0, Analyser::kCross, &burst.right_front_lit);
    reader.add("right", Role::kBlack, 0, Analyser::kCross, &right_black);
  }
  reader.take(photographs, &burst);

  remove_ambient(&burst, ambient);
  set_regions(session, &burst);
  burst.black_level = estimate_black_level(burst.black, burst.front.cross, burst.regions);
  remove_extinction(&burst.full, session.left.extinction);
  for (AnalyserPair& g : burst.gradient) remove_extinction(&g, session.left.extinction);
  remove_projector_extinction(session.left.extinction, &burst);
  remove_black(&burst, right_black);
  return burst;
}

void forget_fringes(Burst* burst) {
  for (Image3& image : burst->fringe) image.release();
  for (Image3& image : burst->right_fringe) image.release();
  burst->right_front_lit.release();
}

void forget_gradients(Burst* burst) {
  for (AnalyserPair& gradient : burst->gradient) gradient = {};
}

void forget_stripes(Burst* burst) {
  for (Image3& image : burst->stripes) image.release();
  burst->black.release();
}

}  // namespace lamella::fit
