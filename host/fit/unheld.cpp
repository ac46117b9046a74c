#include "fit/unheld.h"

#include <opencv2/imgproc.hpp>
#include <vector>

namespace lamella::fit {

namespace {

constexpr float kBridged_px = 5;  // from what was measured

// Of every component of `gaps`, whether it touches the edge of the picture or of the regions.
std::vector<bool> open_components(const cv::Mat_<int>& component, int count, const Mask& labelled) {
  std::vector<bool> open(size_t(count), false);
  const cv::Rect inside(0, 0, labelled.cols, labelled.rows);
  for (int y = 0; y < labelled.rows; ++y) {
    for (int x = 0; x < labelled.cols; ++x) {
      if (component(y, x) == 0) continue;
      for (const cv::Point& step : {cv::Point(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const cv::Point q = cv::Point(x, y) + step;
        if (!inside.contains(q) || !labelled(q)) open[size_t(component(y, x))] = true;
      }
    }
  }
  return open;
}

}  // namespace

Mask unheld_pixels(const Labels& regions, const Mask& measured) {
  const Mask labelled = regions > 0, held = measured & labelled, gaps = labelled & ~measured;
  cv::Mat_<int> component;
  const int count = cv::connectedComponents(gaps, component, 8, CV_32S);
  const std::vector<bool> open = open_components(component, count, labelled);
  Image1 away_px;
  cv::distanceTransform(~held, away_px, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  Mask unheld(regions.size(), 0);
  for (int y = 0; y < unheld.rows; ++y) {
    for (int x = 0; x < unheld.cols; ++x) {
      if (component(y, x) == 0) continue;
      if (open[size_t(component(y, x))] || away_px(y, x) > kBridged_px) unheld(y, x) = 255;
    }
  }
  return unheld;
}

}  // namespace lamella::fit
