// A small head photographed: as a session, over the socket, and wrongly lit.
#include "twin/studio.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <numeric>
#include <thread>

#include "base/error.h"
#include "io/crc32c.h"
#include "io/layer_maps.h"
#include "io/wire.h"
#include "twin/server.h"
#include "twin/session_writer.h"
#include "twin/truth_writer.h"

namespace lamella::twin {
namespace {

const Photographer& small_head() {
  static const Photographer head(
      {.subject = "head", .seed = 3, .scale = 0.12, .photons = 3000, .spacing_mm = 1.5f});
  return head;
}

LightState full_light() { return led_state(std::vector<float>(150, 1.f)); }

// Relative difference of two photographs where the subject is bright.
double difference(const Image3& a, const Image3& b) { return cv::norm(a - b) / cv::norm(a); }

TEST(Studio, DarkensALatePhotographByTheLightItLost) {
  Studio studio(small_head(), 1);
  const Image3 whole = studio.radiance({0, {{full_light(), 1.0, 0.5}}});
  const Image3 late = studio.radiance({0, {{full_light(), 0.7, 0.35}}});
  EXPECT_LT(difference(whole * 0.7, late), 1e-6);
}

TEST(Studio, ShowsTheHighlightsOnlyAsFarAsTheAnalyserIsOpen) {
  Studio studio(small_head(), 1);
  const Image3 parallel = studio.radiance({0, {{full_light(), 1.0, 0.5}}});
  const Image3 cross = studio.radiance({0, {{full_light(), 0.0, 0.5}}});
  const Image3 between = studio.radiance({0, {{full_light(), 0.25, 0.5}}});
  EXPECT_GT(difference(parallel, cross), 0.05);
  EXPECT_LT(difference(between, cross * 0.75 + parallel * 0.25), 1e-6);
}

TEST(Studio, SeesASingleFlippedBitOfTheLeds) {
  Studio studio(small_head(), 1);
  LightState flipped = full_light();
  flipped.codes[40] ^= 0x800;
  const Image3 right = studio.radiance({0, {{full_light(), 0.0, 0.5}}});
  const Image3 wrong = studio.radiance({0, {{flipped, 0.0, 0.5}}});
  EXPECT_GT(difference(right, wrong), 1e-3);
}

TEST(Studio, PutsTheProjectorsTintIntoItsPhotographs) {
  Studio studio(small_head(), 1);
  const LightState white{.codes = {}, .pattern = v1::PatternSpan::WHITE, .index = 0};
  const Image3 photograph = studio.radiance({0, {{white, 0.0, 0.5}}});
  const Radiance d = small_head().depolarized(
      small_head().receivers(Eye::kLeft),
      {std::make_unique<PatchLight>(small_head().projector_light(Image3(800, 1280, Vec3(1, 1, 1))))
           .get()})[0];
  const Receivers& r = small_head().receivers(Eye::kLeft);
  const size_t i = r.size() / 2;
  const Vec3 seen = photograph(r.pixel[i] / r.width, r.pixel[i] % r.width);
  const Vec3 in_led_colours = cv::Matx33f(small_head().rig().projector_to_led) * seen;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(in_led_colours[c], 0.5f * d[i][c], 1e-3f);
}

double mean_column(const Receivers& r) {
  double sum = 0;
  for (int pixel : r.pixel) sum += double(pixel % r.width) / double(r.size());
  return sum;
}

TEST(MovedSubject, IsSeenElsewhereByBothCameras) {
  const Photographer moved = small_head().moved({20, 0, 0});
  for (Eye eye : {Eye::kLeft, Eye::kRight}) {
    const Camera& camera = small_head().rig().left;
    const double px = camera.fx * 20 * std::cos(10 * CV_PI / 180) / camera.depth_mm({0, 0, 0});
    EXPECT_NEAR(mean_column(moved.receivers(eye)) - mean_column(small_head().receivers(eye)), px,
                0.1 * px);
  }
}

TEST(MovedSubject, LeavesTheProjectorsPatternWhereItIs) {
  const Vec3 by_mm(3, -2, 5), place(10, 20, 90);
  const Photographer moved = small_head().moved(by_mm);
  Image3 ramp(800, 1280);
  for (int y = 0; y < ramp.rows; ++y) {
    for (int x = 0; x < ramp.cols; ++x) ramp(y, x) = Vec3(float(x), float(y), 0);
  }
  const Vec3 there = moved.pattern_at(ramp, place);
  EXPECT_LT(length(there - small_head().pattern_at(ramp, place + by_mm)), 1e-2f);
  EXPECT_GT(length(there - small_head().pattern_at(ramp, place)), 5.f);
}

TEST(MovedSubject, IsAsBrightUnderTheProjectorAsItsDistanceHasIt) {
  const Vec3 place(0, 0, 90);
  const Photographer moved = small_head().moved({0, 0, 50});
  EXPECT_NEAR(moved.projector().strength(place), 1e6 / (860. * 860.), 1e-4);
}

TEST(SpreadLeds, AreOffTheirCalibrationByTheirDeviationAndOneOnAverage) {
  Photographer head = small_head().moved({0, 0, 0});
  head.set_led_spread(0.03, 5);
  const std::vector<float>& gains = head.led_gains();
  ASSERT_EQ(gains.size(), 150u);
  double sum = 0, square = 0;
  for (float gain : gains) sum += double(gain) / 150, square += std::pow(double(gain) - 1, 2) / 150;
  EXPECT_NEAR(sum, 1, 1e-5);
  EXPECT_NEAR(std::sqrt(square), 0.03, 0.006);
  EXPECT_EQ(head.moved({1, 0, 0}).led_gains(), gains);
  const Image3 spread = Studio(head, 1).radiance({0, {{full_light(), 0.0, 0.5}}});
  const Image3 even = Studio(small_head(), 1).radiance({0, {{full_light(), 0.0, 0.5}}});
  EXPECT_GT(difference(spread, even), 1e-4);
  EXPECT_LT(difference(spread, even), 0.02);
}

TEST(Head, IsASolidWithEveryRegionInSight) {
  const Receivers& r = small_head().receivers(Eye::kLeft);
  std::array<int, kRegionCount + 1> count{};
  for (uint8_t label : r.label) ++count[label];
  for (int label = 1; label <= kRegionCount; ++label) EXPECT_GT(count[size_t(label)], 10) << label;
  EXPECT_GT(r.size(), 1000u);
}

TEST(Sphere, ShowsEveryRegionFromItsFrontToItsSide) {
  const Subject sphere = make_sphere(1);
  for (int k = 0; k < kRegionCount; ++k) {
    const float a = (2 * float(k) + 1) * kPi / kRegionCount;
    for (float out : {10.f, 40.f, 80.f}) {
      const Vec3 p(out * std::cos(a), out * std::sin(a), std::sqrt(8100 - out * out));
      const RegionWeights w = sphere.regions(p);
      EXPECT_EQ(strongest_region(w), k + 1) << out;
      EXPECT_NEAR(std::accumulate(w.begin(), w.end(), 0.f), 1.f, 1e-5f);
    }
  }
}

// A session on disk for the tests that read one.
const fs::path& session_folder() {
  static const fs::path folder = [] {
    const fs::path made = fs::temp_directory_path() / ("twin_" + std::to_string(::getpid()));
    Studio studio(small_head(), 3);
    fs::create_directories(made);
    write_session(made, small_head(), &studio);
    write_truth(made / "truth", small_head());
    fs::copy_file(made / "truth" / "regions.png", made / "regions.png");
    std::atexit(
        [] { fs::remove_all(fs::temp_directory_path() / ("twin_" + std::to_string(::getpid()))); });
    return made;
  }();
  return folder;
}

TEST(Session, OfTheTwinIsWholeForThoseWhoReadSessions) {
  const Session session = read_session(session_folder());
  EXPECT_TRUE(session.warnings.empty());
  require_burst(session);
  EXPECT_EQ(session.frames.size(), 20u + 15u);
  for (const Frame& frame : session.frames) read_photograph(session, frame);
  EXPECT_EQ(session.stage.leds().size(), 150u);
  EXPECT_NO_THROW(read_regions(session));
}

TEST(Truth, AnswersForEveryLabelledPixel) {
  const LayerMaps truth = read_layer_maps(session_folder() / "truth");
  EXPECT_EQ(read_layers(session_folder() / "truth" / "layers.json").regions_size(), kRegionCount);
  int labelled = 0, separated = 0;
  for (int y = 0; y < truth.regions.rows; ++y) {
    for (int x = 0; x < truth.regions.cols; ++x) {
      if (!truth.regions(y, x)) continue;
      ++labelled;
      ASSERT_TRUE(is_finite(truth.position_mm(y, x)));
      ASSERT_NEAR(length(truth.normal_diffuse[1](y, x)), 1.f, 1e-3f);
      ASSERT_GT(truth.specular_intensity(y, x), 0.f);
      if (is_finite(truth.deep_albedo(y, x))) ++separated;
    }
  }
  EXPECT_GT(separated, 0.9 * labelled);
}

TEST(Truth, SeparatesWhatAddsUpToTheFrontPhotograph) {
  const LayerMaps truth = read_layer_maps(session_folder() / "truth");
  const Photographer& head = small_head();
  const Receivers& r = head.receivers(Eye::kLeft);
  const PatchLight white = head.projector_light(Image3(800, 1280, Vec3(1, 1, 1)));
  const Radiance d = head.depolarized(r, {&white})[0];
  for (size_t i = 0; i < r.size(); i += 7) {
    const int y = r.pixel[i] / r.width, x = r.pixel[i] % r.width;
    if (!r.label[i] || !is_finite(truth.deep_albedo(y, x))) continue;
    const Vec3 p = r.targets.position_mm[i];
    const float e =
        dot(r.shading_normal[i], head.projector().direction(p)) * head.projector().strength(p);
    const Vec3 sum = (truth.shallow_albedo(y, x) + truth.deep_albedo(y, x)) * e;
    EXPECT_NEAR(sum[0], d[i][0], 0.02f * d[i][0] + 1e-3f);
  }
}

int connect_to(const fs::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  const int fd = ::socket(AF_UNIX, SOCK_STREAM, 0);
  return ::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 ? fd : -1;
}

v1::ExposureReport nominal_report() {
  v1::ExposureReport report;
  report.set_close_us(30000);
  report.set_led_reference_us(20000);
  report.set_projector_reference_us(20000);
  v1::LedSpan* span = report.add_leds();
  span->set_on_us(5000);
  span->set_off_us(25000);
  for (int i = 0; i < 150; ++i) *span->mutable_codes() += std::string("\xff\x0f", 2);
  return report;
}

TEST(Server, SendsThePhotographThatTheSessionHas) {
  const fs::path path =
      fs::temp_directory_path() / ("twin_" + std::to_string(::getpid()) + ".sock");
  Studio studio(small_head(), 1), same(small_head(), 1);
  std::atomic<bool> stop = false;
  const LocalListener listener(path);
  std::thread server([&] { serve(listener, small_head(), &studio, [&] { return stop.load(); }); });
  {
    Socket socket(connect_to(path));
    const Deadline deadline = deadline_in(60);
    EXPECT_FALSE(socket.send(nominal_report(), deadline));
    v1::PhotographHeader header;
    EXPECT_FALSE(socket.receive(&header, deadline));
    EXPECT_EQ(header.error(), "");
    std::vector<uint8_t> bytes(header.size_bytes());
    EXPECT_FALSE(socket.receive_bytes(bytes.data(), bytes.size(), deadline));
    EXPECT_EQ(crc32c(bytes.data(), bytes.size()), header.crc32c());
    const RawImage raw = unpack_rgb12p(bytes.data(), bytes.size(),
                                       cv::Size(int(header.width()), int(header.height())));
    const RawPhotograph direct = same.take({0, {{full_light(), 0.0, 0.5}}}, 0);
    EXPECT_EQ(cv::norm(raw, direct.raw, cv::NORM_INF), 0);
    v1::ExposureReport nonsense = nominal_report();
    nonsense.set_close_us(std::nan(""));
    EXPECT_FALSE(socket.send(nonsense, deadline));
    EXPECT_FALSE(socket.receive(&header, deadline));
    EXPECT_NE(header.error().find("ExposureReport."), std::string::npos);
  }
  stop = true;
  server.join();
}

TEST(Server, RefusesAPathThatIsTaken) {
  const fs::path path = fs::temp_directory_path() / ("taken_" + std::to_string(::getpid()));
  std::ofstream(path) << "something else";
  EXPECT_THROW(LocalListener listener(path), Error);
  fs::remove(path);
}

}  // namespace
}  // namespace lamella::twin
