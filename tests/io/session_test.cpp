#include "io/session.h"

#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "io/expect_error.h"
#include "io/fake_session.h"
#include "io/json.h"
#include "io/labels.h"
#include "io/rig_message.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;
using testing::ScratchFolder;

Camera camera_of_fake(int i) {
  return camera_from_message(testing::fake_calibration(testing::kFakeSize).rig().cameras(i), "");
}

class SessionFolder : public ::testing::Test {
 protected:
  SessionFolder() { testing::write_fake_session(path()); }

  fs::path path() const { return scratch_.path() / "session"; }

  // What reading says after `spoil` has changed the manifest.
  std::string after(const std::function<void(v1::Session*)>& spoil) {
    v1::Session manifest;
    read_json(path() / "session.json", &manifest);
    spoil(&manifest);
    write_json(path() / "session.json", manifest);
    return complaint([&] { require_burst(read_session(path())); });
  }

  ScratchFolder scratch_;
};

TEST_F(SessionFolder, ReadsAsItWasWritten) {
  const Session s = read_session(path());
  EXPECT_EQ(s.subject, "fake");
  EXPECT_EQ(s.frames.size(), 40u);
  EXPECT_EQ(s.region_names, (std::vector<std::string>{"background", "skin", "lips"}));
  EXPECT_EQ(s.left.cam_from_rig, camera_of_fake(0).cam_from_rig);
  EXPECT_EQ(s.right->translation_mm, camera_of_fake(1).translation_mm);
  EXPECT_EQ(s.stage.leds().size(), 24u);
  EXPECT_EQ(s.projector.width, 1280);
  EXPECT_NO_THROW(require_burst(s));
  EXPECT_EQ(read_regions(s).size(), testing::kFakeSize);
}

TEST_F(SessionFolder, NeedsFringesOnlyWhereNoMeshIsGiven) {
  testing::leave_out(path(), [](const v1::Frame& f) { return f.role() == v1::Frame::FRINGE; });
  EXPECT_TRUE(
      names(after([](v1::Session*) {}), {"session.json", "no FRINGE 0 CROSS", "fit --mesh FILE"}));
  EXPECT_NO_THROW(require_burst(read_session(path()), ShapeFrom::kMesh));
}

TEST_F(SessionFolder, ScalesRadianceAndMarksClippedPixels) {
  v1::Session manifest;
  read_json(path() / "session.json", &manifest);
  Image3 stored(32, 24, Vec3(0.5f, 0.5f, 0.5f));
  stored(3, 4) = Vec3(0.1f, 2.f, 0.1f);  // the fake camera saturates at 2
  write_exr_rgb(path() / manifest.frames(0).file(), stored);
  for (double s : {2.0, 1.0, 0.5}) manifest.mutable_frames(0)->add_radiance_scale(s);
  write_json(path() / "session.json", manifest);
  const Session session = read_session(path());
  const Photograph p = read_photograph(session, session.frames[0]);
  EXPECT_EQ(p.radiance(0, 0), Vec3(1.f, 0.5f, 0.25f));
  EXPECT_EQ(cv::countNonZero(p.clipped), 1);
  EXPECT_EQ(p.clipped(3, 4), 255);
  EXPECT_TRUE(read_photograph(session, session.frames[1]).clipped.empty());
}

TEST_F(SessionFolder, LetsTheRightCameraTakeTheSameLightTwice) {
  EXPECT_EQ(after([](v1::Session* m) {
              *m->add_frames() = m->frames(39);
              m->mutable_frames(40)->set_step(77);
            }),
            "");
}

TEST_F(SessionFolder, NamesTheFrameThatIsThereTwice) {
  EXPECT_TRUE(names(after([](v1::Session* m) { *m->add_frames() = m->frames(2); }),
                    {"session.json", "frames[40].role"}));
}

TEST_F(SessionFolder, NamesTheRoleThatIsMissing) {
  EXPECT_TRUE(names(after([](v1::Session* m) { m->mutable_frames()->DeleteSubrange(17, 1); }),
                    {"session.json: frames", "STRIPES 1 CROSS"}));
}

TEST_F(SessionFolder, NamesTheFieldThatIsMissing) {
  EXPECT_TRUE(names(after([](v1::Session* m) { m->mutable_rig()->mutable_cameras(1)->clear_fx(); }),
                    {"session.json: rig.cameras[1].fx", "missing"}));
  EXPECT_TRUE(names(after([](v1::Session* m) { m->mutable_rig()->clear_projector(); }),
                    {"rig.cameras[1].fx"}));  // the first complaint comes first
}

TEST_F(SessionFolder, KeepsFilesWithinTheSession) {
  for (const char* file : {"../../etc/passwd", "/etc/passwd", "frames/../../x.exr"}) {
    EXPECT_TRUE(names(after([&](v1::Session* m) { m->mutable_frames(4)->set_file(file); }),
                      {"frames[4].file", "outside the session"}));
    EXPECT_TRUE(names(after([&](v1::Session* m) {
                        m->mutable_frames(4)->set_file(m->frames(5).file());
                        m->mutable_regions()->set_file(file);
                      }),
                      {"regions.file", "outside the session"}));
  }
}

TEST_F(SessionFolder, NamesAFileThatIsNotThere) {
  EXPECT_TRUE(
      names(after([](v1::Session* m) { m->mutable_frames(4)->set_file("frames/none.exr"); }),
            {"frames[4].file", "frames/none.exr"}));
  EXPECT_TRUE(names(after([](v1::Session* m) { m->mutable_frames(4)->set_file("frames/left"); }),
                    {"frames[4].file", "no such file"}));
}

TEST_F(SessionFolder, RefusesAbsurdNumbers) {
  using Spoil = std::function<void(v1::Camera*)>;
  const std::pair<const char*, Spoil> cases[] = {
      {".width", [](v1::Camera* c) { c->set_width(1000000000); }},
      {".width", [](v1::Camera* c) { c->set_width(30000), c->set_height(30000); }},
      {".height", [](v1::Camera* c) { c->set_width(24), c->set_height(0); }},
      {".fx", [](v1::Camera* c) { c->set_height(32), c->set_fx(-1); }},
      {".cx", [](v1::Camera* c) { c->set_fx(1), c->set_cx(1e300); }},
      {".rotation", [](v1::Camera* c) { c->set_cx(1), c->set_rotation(0, 2); }},
  };
  for (const auto& [field, spoil] : cases) {
    const std::string line =
        after([&spoil = spoil](v1::Session* m) { spoil(m->mutable_rig()->mutable_cameras(0)); });
    EXPECT_TRUE(names(line, {std::string("rig.cameras[0]") + field}));
  }
}

TEST_F(SessionFolder, RefusesPatternsThatNoProjectorCanDraw) {
  using Spoil = std::function<void(v1::Patterns*)>;
  const std::pair<const char*, Spoil> cases[] = {
      {"fringe.periods", [](v1::Patterns* p) { p->mutable_fringe()->set_periods(2, 4); }},
      {"fringe.periods", [](v1::Patterns* p) { p->mutable_fringe()->set_periods(2, 2); }},
      {"fringe.periods", [](v1::Patterns* p) { p->mutable_fringe()->set_periods(3, 1000); }},
      {"stripes.period_px", [](v1::Patterns* p) { p->mutable_stripes()->set_period_px(1e-9); }},
      {"stripes.period_px", [](v1::Patterns* p) { p->mutable_stripes()->set_period_px(1e9); }},
      {"stripes.shift_px", [](v1::Patterns* p) { p->mutable_stripes()->set_shift_px(9); }},
      {"stripes.shift_px", [](v1::Patterns* p) { p->mutable_stripes()->set_shift_px(0); }},
      {"dots.pitch_px", [](v1::Patterns* p) { p->mutable_dots()->set_pitch_px(1e-9); }},
      {"dots.diameter_px", [](v1::Patterns* p) { p->mutable_dots()->set_diameter_px(60); }},
      {"dots.diameter_px", [](v1::Patterns* p) { p->mutable_dots()->set_diameter_px(-1); }},
      {"dots.offset_px[1]", [](v1::Patterns* p) { p->mutable_dots()->set_offset_px(1, 1e300); }},
  };
  const v1::Patterns good = testing::fake_calibration(testing::kFakeSize).patterns();
  for (const auto& [field, spoil] : cases) {
    const std::string line = after([&good, &spoil = spoil](v1::Session* m) {
      *m->mutable_patterns() = good;
      spoil(m->mutable_patterns());
    });
    EXPECT_TRUE(names(line, {std::string("session.json: patterns.") + field}));
  }
}

TEST_F(SessionFolder, RefusesColoursThatCannotBeTurnedBack) {
  const double none[9] = {}, one_row[9] = {1, 0, 0, 1, 0, 0, 1, 0, 0},
               negative[9] = {-1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (const double* matrix : {none, one_row, negative}) {
    EXPECT_TRUE(names(after([&](v1::Session* m) {
                        m->mutable_rig()->mutable_projector_to_led()->Clear();
                        m->mutable_rig()->mutable_projector_to_led()->Add(matrix, matrix + 9);
                      }),
                      {"session.json: rig.projector_to_led"}));
  }
}

TEST_F(SessionFolder, NamesThePhotographOfAnotherSize) {
  const Session s = read_session(path());
  write_exr_rgb(path() / s.frames[6].file, Image3(33, 24, Vec3(0, 0, 0)));
  EXPECT_TRUE(names(complaint([&] { read_photograph(s, s.frames[6]); }),
                    {s.frames[6].file, "24x33", "rig.cameras", "24x32"}));
}

TEST_F(SessionFolder, NamesThePixelThatIsNotANumber) {
  const Session s = read_session(path());
  Image3 image(32, 24, Vec3(0, 0, 0));
  image(5, 9)[1] = kNaN;
  write_exr_rgb(path() / s.frames[6].file, image);
  EXPECT_TRUE(names(complaint([&] { read_photograph(s, s.frames[6]); }),
                    {s.frames[6].file, "pixel (9, 5)"}));
}

TEST_F(SessionFolder, NamesTheRegionThatIsEmptyOrHasNoName) {
  const Session s = read_session(path());
  Labels labels(32, 24, uchar(1));
  write_labels(path() / "regions.png", labels);
  EXPECT_TRUE(names(complaint([&] { read_regions(s); }), {"regions.png", "\"lips\"", "empty"}));
  labels(1, 1) = 2;
  labels(2, 2) = 9;
  write_labels(path() / "regions.png", labels);
  EXPECT_TRUE(names(complaint([&] { read_regions(s); }), {"regions.png", "label 9", "no name"}));
}

TEST_F(SessionFolder, RefusesALabelImageThatIsCutOrOfAnotherKind) {
  const Session s = read_session(path());
  const fs::path file = path() / "regions.png";
  fs::resize_file(file, fs::file_size(file) - 20);
  EXPECT_TRUE(names(complaint([&] { read_regions(s); }), {"regions.png", "not a whole PNG"}));
  cv::imwrite(file.string(), cv::Mat(32, 24, CV_8UC3, cv::Scalar(1, 1, 1)));
  EXPECT_TRUE(names(complaint([&] { read_regions(s); }), {"regions.png", "8-bit grey"}));
  cv::imwrite(file.string(), cv::Mat(30, 24, CV_8UC1, cv::Scalar(1)));
  EXPECT_TRUE(names(complaint([&] { read_regions(s); }), {"regions.png", "24x30", "24x32"}));
}

TEST_F(SessionFolder, RefusesRegionNamesThatDoNotTellRegionsApart) {
  EXPECT_TRUE(names(after([](v1::Session* m) { m->mutable_regions()->set_names(2, "skin"); }),
                    {"regions.names[2]", "twice"}));
  EXPECT_TRUE(names(after([](v1::Session* m) { m->mutable_regions()->set_names(2, ""); }),
                    {"regions.names[2]", "empty"}));
}

TEST_F(SessionFolder, WarnsOfAnUnknownFieldAndReadsOn) {
  std::string text = to_json(testing::fake_calibration(testing::kFakeSize));
  text.insert(1, "\"mood\": \"calm\",");
  v1::Session parsed;
  EXPECT_EQ(parse_json(text, "session.json", &parsed), std::vector<std::string>{"mood"});
}

}  // namespace
}  // namespace lamella
