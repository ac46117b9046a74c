#include "fit/subject_window.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/parallel.h"

namespace lamella::fit {

namespace {

// Neither noise nor a hot pixel is light: most of a square of this side is brighter than the least,
// and the brightest square of that side says what is bright.
constexpr int kLit_px = 8, kBright_px = 32;
constexpr double kLitOfSquare = 0.7;
constexpr int kMargin_px = 20;           // for averages over neighbours
constexpr int kLabelMargin_px = 8;       // labels that end where the light does change nothing
constexpr float kLeastLitShare = 0.01f;  // of what is bright

Image1 brightness_of(const Image3& image) {
  Image1 brightness(image.size());
  parallel_for(image.rows, [&](int y) {
    for (int x = 0; x < image.cols; ++x) brightness(y, x) = mean(image(y, x));
  });
  return brightness;
}

// Dark beyond the edge.
template <class Image>
Image box_means(const Image& image, int side_px) {
  Image means;
  cv::boxFilter(image, means, -1, {side_px, side_px}, {-1, -1}, true, cv::BORDER_CONSTANT);
  return means;
}

// Nothing stays nothing.
cv::Rect widened(const cv::Rect& area, int margin_px, cv::Size size) {
  if (area.empty()) return area;
  const cv::Point margin(margin_px, margin_px);
  return cv::Rect(area.tl() - margin, area.br() + margin) & cv::Rect({0, 0}, size);
}

void cut(const PixelWindow& window, Camera* camera) {
  camera->width = window.area.width;
  camera->height = window.area.height;
  camera->cx -= window.area.x;
  camera->cy -= window.area.y;
}

void cut(const PixelWindow& window, Photograph* photograph) {
  photograph->radiance = photograph->radiance(window.area).clone();
  if (!photograph->clipped.empty()) {
    photograph->clipped = photograph->clipped(window.area).clone();
  }
}

std::vector<const Frame*> front_frames(const Session& session) {
  std::vector<const Frame*> fronts;
  for (const char* camera : {"left", "right"}) {
    const Frame* frame = session.find(camera, Role::kFront, 0, Analyser::kCross);
    if (frame) fronts.push_back(frame);
  }
  return fronts;
}

}  // namespace

cv::Rect bounds_of(const Mask& mask) {
  cv::Rect bounds;
  for (int y = 0; y < mask.rows; ++y) {
    const uchar* row = mask[y];
    const uchar* end = row + mask.cols;
    const uchar* first = std::find_if(row, end, [](uchar v) { return v != 0; });
    if (first == end) continue;
    int last = mask.cols - 1;
    while (!row[last]) --last;
    bounds |= cv::Rect(int(first - row), y, last - int(first - row) + 1, 1);
  }
  return bounds;
}

cv::Rect lit_area(const Image3& image) {
  const Image1 brightness = brightness_of(image);
  double bright = 0;
  cv::minMaxLoc(box_means(brightness, kBright_px), nullptr, &bright);
  const Mask lit = brightness > std::max(0.0, kLeastLitShare * bright);
  const cv::Rect area = bounds_of(box_means(lit, kLit_px) > 255 * kLitOfSquare);
  return area.empty() ? cv::Rect({0, 0}, image.size()) : widened(area, kMargin_px, image.size());
}

SubjectBurst find_subject(const Session& session) {
  SubjectBurst burst{session, {}};
  Labels labels;
  parallel_both(
      [&] {
        if (!session.regions_file.empty()) labels = read_regions(session);
      },
      [&] { burst.fronts = read_photographs(burst.session, front_frames(burst.session)); });
  burst.session.given_labels = labels;
  std::vector<std::pair<const Frame*, PixelWindow>> windows;
  for (const auto& [frame, photograph] : burst.fronts) {
    windows.emplace_back(frame, whole_window(photograph.radiance.size()));
  }
  parallel_for(int(windows.size()), [&](int i) {
    auto& [frame, window] = windows[size_t(i)];
    Photograph& photograph = burst.fronts.at(frame);
    window.area = lit_area(photograph.radiance);
    if (frame->camera == "left")
      window.area |= widened(bounds_of(labels), kLabelMargin_px, window.whole);
    cut(window, &photograph);
  });
  for (const auto& [frame, window] : windows) {
    cut(window, frame->camera == "left" ? &burst.session.left : &*burst.session.right);
    burst.session.windows[frame->camera] = window;
  }
  return burst;
}

}  // namespace lamella::fit
