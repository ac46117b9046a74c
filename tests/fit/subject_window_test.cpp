#include "fit/subject_window.h"

#include <gtest/gtest.h>

#include "io/fake_session.h"
#include "io/labels.h"

namespace lamella::fit {
namespace {

// Dark but for `lit`.
Image3 picture(cv::Size size, const cv::Rect& lit, float light = 1) {
  Image3 image(size, Vec3::all(0));
  image(lit).setTo(cv::Scalar::all(double(light)));
  return image;
}

TEST(LitArea, HoldsAllLightAndAMargin) {
  const cv::Rect lit(203, 150, 77, 201);
  const cv::Rect area = lit_area(picture({900, 700}, lit));
  EXPECT_EQ(area & lit, lit);
  EXPECT_LE(area.x, lit.x - 16);
  EXPECT_LE(area.y, lit.y - 16);
  EXPECT_GE(area.br().x, lit.br().x + 16);
  EXPECT_GE(area.br().y, lit.br().y + 16);
  EXPECT_LT(area.area(), 3 * lit.area());
}

// Failure: every step that looks at every nth pixel would look at others, and single scattering of
// small regions with them.
TEST(LitArea, MovesWithTheLightPixelByPixel) {
  const cv::Rect lit(203, 150, 77, 201);
  const cv::Rect area = lit_area(picture({900, 700}, lit));
  for (const cv::Point by : {cv::Point(1, 0), cv::Point(4, 7), cv::Point(100, 33)}) {
    EXPECT_EQ(lit_area(picture({1000, 800}, lit + by)), area + by);
  }
}

TEST(LitArea, TakesNoHotPixelsForLight) {
  const cv::Rect lit(203, 150, 77, 201);
  Image3 image = picture({900, 700}, lit, 0.25f);
  const cv::Rect area = lit_area(image);
  image(cv::Rect(8, 8, 3, 3)).setTo(cv::Scalar::all(0.9));
  EXPECT_EQ(lit_area(image), area);
}

TEST(LitArea, StaysInThePicture) {
  EXPECT_EQ(lit_area(picture({100, 70}, {90, 60, 10, 10})).br(), cv::Point(100, 70));
  EXPECT_EQ(lit_area(picture({100, 70}, {0, 0, 8, 8})).tl(), cv::Point(0, 0));
}

TEST(LitArea, IsAllOfAPictureWithoutLight) {
  EXPECT_EQ(lit_area(picture({100, 70}, {}, 0)), cv::Rect(0, 0, 100, 70));
  EXPECT_EQ(lit_area(picture({5, 3}, {0, 0, 5, 3})), cv::Rect(0, 0, 5, 3));
}

TEST(LitArea, TakesNoNoiseForLight) {
  const cv::Rect lit(160, 160, 320, 320);
  Image3 image = picture({900, 700}, lit, 0.25f);
  cv::RNG random(7);
  for (Vec3& v : image) v += Vec3::all(float(random.gaussian(0.004)));
  EXPECT_LT(lit_area(image).area(), 2 * lit.area());
}

TEST(LitArea, HoldsDarkSkinBesideAWhiteShirt) {
  Image3 image = picture({900, 700}, {200, 400, 300, 200});
  const cv::Rect dark(300, 96, 96, 160);
  image(dark).setTo(cv::Scalar::all(0.04));
  EXPECT_EQ(lit_area(image) & dark, dark);
}

class FindSubject : public ::testing::Test {
 protected:
  void SetUp() override { lamella::testing::write_fake_session(scratch_.path(), {160, 192}); }

  const lamella::testing::ScratchFolder scratch_;
};

TEST_F(FindSubject, SeesEveryPointWhereTheWholeCameraSeesIt) {
  const Session whole = read_session(scratch_.path());
  const SubjectBurst subject = find_subject(whole);
  for (const char* id : {"left", "right"}) {
    const cv::Rect area = subject.session.window(id).area;
    const Vec3d point(3, -5, 8);
    const cv::Vec2d from_corner(area.x, area.y);
    EXPECT_LT(cv::norm(subject.session.camera(id).project(point) + from_corner -
                       whole.camera(id).project(point)),
              1e-9);
    EXPECT_EQ(cv::Size(subject.session.camera(id).width, subject.session.camera(id).height),
              area.size());
  }
}

TEST_F(FindSubject, ReadsOfAPhotographTheWindowAlone) {
  const Session whole = read_session(scratch_.path());
  const SubjectBurst subject = find_subject(whole);
  const cv::Rect area = subject.session.window("left").area;
  ASSERT_LT(area.area(), 160 * 192);
  for (size_t i = 0; i < whole.frames.size(); ++i) {
    if (whole.frames[i].camera != "left") continue;
    const Photograph all = read_photograph(whole, whole.frames[i]);
    const Photograph part = read_photograph(subject.session, subject.session.frames[i]);
    EXPECT_EQ(cv::norm(part.radiance, all.radiance(area), cv::NORM_INF), 0);
  }
  const Labels labels = read_regions(subject.session);
  EXPECT_EQ(cv::norm(labels, read_regions(whole)(area), cv::NORM_INF), 0);
}

TEST_F(FindSubject, WithoutLabelsIsWhereTheLightIs) {
  Session session = read_session(scratch_.path());
  const cv::Rect area = find_subject(session).session.window("left").area;
  session.regions_file.clear();
  EXPECT_EQ(find_subject(session).session.window("left").area, area);
}

// Failure: what is labelled and lies in shadow would be given up without a word.
TEST_F(FindSubject, HoldsWhatIsLabelledThoughItIsDark) {
  Labels labels = read_labels(scratch_.path() / "regions.png");
  labels(2, 3) = 1;
  write_labels(scratch_.path() / "regions.png", labels);
  const SubjectBurst subject = find_subject(read_session(scratch_.path()));
  EXPECT_TRUE(subject.session.window("left").area.contains({3, 2}));
}

}  // namespace
}  // namespace lamella::fit
