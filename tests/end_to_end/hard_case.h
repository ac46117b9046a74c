// A burst of a twin, spoilt or seen otherwise, and the fit of the burst as it was.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "end_to_end/whole_maps.h"
#include "io/exr.h"
#include "io/fake_session.h"
#include "io/labels.h"
#include "twin/session_writer.h"
#include "twin/truth_writer.h"

namespace lamella {

using Json = nlohmann::json;

// A session's folder, to be changed and fitted.
class SpoiltSession {
 public:
  explicit SpoiltSession(const fs::path& original) : folder_(scratch_.path() / "session") {
    fs::copy(original, folder_, fs::copy_options::recursive);
    std::ifstream(folder_ / "session.json") >> manifest;
  }

  Json manifest;

  bool is(const Json& frame, const std::string& role, const std::string& analyser = "") const {
    return frame["role"] == role && (analyser.empty() || frame["analyser"] == analyser);
  }

  Image3 photograph(const Json& frame) const { return read_exr_rgb(folder_ / frame["file"]); }
  Image3 photograph(const std::string& role, const std::string& analyser) const {
    for (const Json& frame : manifest["frames"]) {
      if (frame["camera"] == "left" && is(frame, role, analyser)) return photograph(frame);
    }
    ADD_FAILURE() << "no " << role;
    return {};
  }

  double scale(const std::string& role, const std::string& analyser) const {
    for (const Json& frame : manifest["frames"]) {
      if (frame["camera"] == "left" && is(frame, role, analyser)) return frame["radiance_scale"][0];
    }
    return 1;
  }

  // Calls `change(frame, &photograph)` for every photograph.
  template <class Change>
  void change_photographs(const Change& change) {
    for (Json& frame : manifest["frames"]) {
      Image3 image = photograph(frame);
      change(frame, &image);
      write_exr_rgb(folder_ / frame["file"], image);
    }
  }

  Labels regions() const { return read_labels(folder_ / "regions.png"); }
  void set_regions(const Labels& labels) { write_labels(folder_ / "regions.png", labels); }
  fs::path file(const Json& frame) const { return folder_ / frame["file"]; }

  fit::LayeredFit fitted(fit::Step until = fit::Step::kAlbedo) const {
    std::ofstream(folder_ / "session.json") << manifest;
    fit::LayeredFit fit = fit::fit_layers(read_session(folder_), until);
    fit.maps = testing::in_whole(std::move(fit.maps));
    return fit;
  }

 private:
  testing::ScratchFolder scratch_;
  fs::path folder_;
};

inline std::map<std::string, cv::Mat> maps_of(const LayerMaps& maps) {
  const auto named = named_maps(maps);
  return {named.begin(), named.end()};
}

inline void expect_numbers_where_confident(const LayerMaps& maps) {
  for (const auto& [name, map] : maps_of(maps)) {
    ASSERT_EQ(maps.confidence.count(name), 1u) << name;
    const Image1& confidence = maps.confidence.at(name);
    int wrong = 0;
    for (int y = 0; y < map.rows; ++y) {
      for (int x = 0; x < map.cols; ++x) {
        if (!(confidence(y, x) > 0)) continue;
        const float* values = map.ptr<float>(y) + x * map.channels();
        for (int k = 0; k < map.channels(); ++k) wrong += !std::isfinite(values[k]);
      }
    }
    EXPECT_EQ(wrong, 0) << name << ": not a number where confidence is above zero";
  }
}

// Of the pixels that both answer, at this quantile: how far `a` is from `b` relative to the length
// of `b`.
inline double difference(const cv::Mat& a, const cv::Mat& b, double quantile = 0.99) {
  std::vector<double> all;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      const float *p = a.ptr<float>(y) + x * a.channels(), *q = b.ptr<float>(y) + x * b.channels();
      double off = 0, length = 0;
      for (int k = 0; k < a.channels(); ++k)
        off += (p[k] - q[k]) * (p[k] - q[k]), length += q[k] * q[k];
      if (std::isfinite(off) && length > 0) all.push_back(std::sqrt(off / length));
    }
  }
  if (all.empty()) return 0;
  const auto at = all.begin() + std::ptrdiff_t(quantile * double(all.size() - 1));
  std::nth_element(all.begin(), at, all.end());
  return *at;
}

// "12 pixels, the first at (70, 40): 0.25 and 0.26".
inline std::string pixels_that_differ(const cv::Mat& a, const cv::Mat& b) {
  int count = 0;
  std::string first;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      const uchar *p = a.ptr(y, x), *q = b.ptr(y, x);
      if (std::memcmp(p, q, a.elemSize()) == 0 || ++count > 1) continue;
      const float found = *reinterpret_cast<const float*>(p);
      const float was = *reinterpret_cast<const float*>(q);
      first = fmt::format(", the first at ({}, {}): {:.9g} and {:.9g}", x, y, found, was);
    }
  }
  return count == 0 ? "" : fmt::format("{} pixels", count) + first;
}

inline double answered(const cv::Mat& map, const Labels& regions) {
  double known = 0, asked = 0;
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      if (!regions(y, x)) continue;
      asked += 1;
      known += std::isfinite(map.ptr<float>(y)[x * map.channels()]);
    }
  }
  return known / asked;
}

constexpr double kDriftMm = 2;

class HardCase : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = std::make_unique<testing::ScratchFolder>();
    twin::Photographer::Options options;
    options.subject = "sphere";
    options.scale = 0.3;
    options.photons = 20000;
    twin::Photographer photographer(options);
    twin::write_truth(scratch->path() / "truth", photographer);
    twin::Studio studio(photographer, 1);
    for (const char* session : {"session", "drifting"}) {
      twin::write_session(scratch->path() / session, photographer, &studio);
      fs::copy_file(scratch->path() / "truth" / "regions.png",
                    scratch->path() / session / "regions.png");
      photographer.set_drift(kDriftMm);
    }
    whole = std::make_unique<fit::LayeredFit>(spoilt().fitted());
  }
  static void TearDownTestSuite() {
    whole.reset();
    scratch.reset();
  }

  static SpoiltSession spoilt() { return SpoiltSession(scratch->path() / "session"); }

  static void expect_the_same_bytes(const fit::LayeredFit& found) {
    const auto maps = maps_of(found.maps);
    for (const auto& [name, map] : maps_of(whole->maps)) {
      EXPECT_EQ(pixels_that_differ(maps.at(name), map), "") << name;
    }
    for (const auto& [name, map] : whole->maps.stddev) {
      EXPECT_EQ(pixels_that_differ(found.maps.stddev.at(name), map), "") << name;
    }
  }

  // Everything that the fit says of every map, pixel by pixel.
  static void expect_the_same(const fit::LayeredFit& found, double tolerance) {
    const auto maps = maps_of(found.maps);
    for (const auto& [name, map] : maps_of(whole->maps)) {
      EXPECT_LE(difference(maps.at(name), map), tolerance) << name;
    }
    for (int r = 0; r < whole->layers.regions_size(); ++r) {
      const v1::Region &a = found.layers.regions(r), &b = whole->layers.regions(r);
      EXPECT_NEAR(a.specular().gaussian_m(), b.specular().gaussian_m(), tolerance) << b.name();
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(a.deep().ld_mm(c), b.deep().ld_mm(c), 10 * tolerance) << b.name();
        EXPECT_NEAR(a.single().amplitude(c), b.single().amplitude(c), tolerance) << b.name();
      }
    }
  }

  inline static std::unique_ptr<testing::ScratchFolder> scratch;
  inline static std::unique_ptr<fit::LayeredFit> whole;
};

}  // namespace lamella
