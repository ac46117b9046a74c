#include "fit/subject_window.h"

#include <algorithm>
#include <vector>

#include "base/parallel.h"
#include "fit/order_statistics.h"

namespace lamella::fit {

namespace {

constexpr int kBlock_px = 8;             // averaged, so that noise is no light
constexpr int kGrid_px = 16;             // what steps that look at every nth pixel begin on
constexpr int kMargin_px = 16;           // at least, for averages over neighbours
constexpr float kLeastLitShare = 0.01f;  // of the bright end

Image1 block_means(const Image3& image) {
  Image1 means(image.rows / kBlock_px, image.cols / kBlock_px, 0.f);
  parallel_for(means.rows, [&](int y) {
    for (int i = 0; i < kBlock_px; ++i) {
      const Vec3* row = image[y * kBlock_px + i];
      for (int x = 0; x < means.cols * kBlock_px; ++x) means(y, x / kBlock_px) += mean(row[x]);
    }
  });
  return means;
}

// Nothing stays nothing.
cv::Rect widened(const cv::Rect& area, cv::Size size) {
  if (area.empty()) return area;
  const int left = std::max(0, area.x - kMargin_px) / kGrid_px * kGrid_px;
  const int top = std::max(0, area.y - kMargin_px) / kGrid_px * kGrid_px;
  const int right = (area.br().x + kMargin_px + kGrid_px - 1) / kGrid_px * kGrid_px;
  const int bottom = (area.br().y + kMargin_px + kGrid_px - 1) / kGrid_px * kGrid_px;
  return cv::Rect(left, top, right - left, bottom - top) & cv::Rect({0, 0}, size);
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
  const cv::Rect all({0, 0}, image.size());
  const Image1 means = block_means(image);
  if (means.empty()) return all;
  const float bright = bright_end(means);
  const cv::Rect blocks = bounds_of(means > kLeastLitShare * bright);
  if (!(bright > 0) || blocks.empty()) return all;
  return widened({blocks.tl() * kBlock_px, blocks.br() * kBlock_px}, image.size());
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
    if (frame->camera == "left") window.area |= widened(bounds_of(labels), window.whole);
    cut(window, &photograph);
  });
  for (const auto& [frame, window] : windows) {
    cut(window, frame->camera == "left" ? &burst.session.left : &*burst.session.right);
    burst.session.windows[frame->camera] = window;
  }
  return burst;
}

}  // namespace lamella::fit
