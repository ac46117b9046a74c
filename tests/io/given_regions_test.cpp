#include "io/given_regions.h"

#include <gtest/gtest.h>

#include <fstream>

#include "io/expect_error.h"
#include "io/fake_session.h"
#include "io/labels.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;

class GivenRegions : public ::testing::Test {
 protected:
  GivenRegions() { testing::write_fake_session(scratch_.path() / "session"); }

  fs::path png() const { return scratch_.path() / "painted.png"; }

  static Labels painted() {
    Labels labels(testing::kFakeSize, uchar(0));
    labels.rowRange(4, 16).setTo(50);
    labels.rowRange(16, 30).setTo(200);
    return labels;
  }

  void write_names(const std::string& json) const {
    std::ofstream(scratch_.path() / "painted.json") << json;
  }

  Session given(const Labels& labels) const {
    write_labels(png(), labels);
    Session session = read_session(scratch_.path() / "session");
    give_regions(png(), &session);
    return session;
  }

  testing::ScratchFolder scratch_;
};

TEST_F(GivenRegions, WithoutNamesAreTheGreysThatWerePainted) {
  const Session session = given(painted());
  EXPECT_EQ(session.region_names,
            (std::vector<std::string>{"background", "region 50", "region 200"}));
  const Labels labels = read_regions(session);
  EXPECT_EQ(labels(3, 5), 0);
  EXPECT_EQ(labels(4, 5), 1);
  EXPECT_EQ(labels(20, 5), 2);
}

TEST_F(GivenRegions, AreNamedByTheFileBesideThem) {
  write_names(R"({"file": "regions.png", "names": ["background", "brow", "chin"]})");
  Labels labels = painted();
  labels.setTo(1, labels == 50);
  labels.setTo(2, labels == 200);
  const Session session = given(labels);
  EXPECT_EQ(session.region_names, (std::vector<std::string>{"background", "brow", "chin"}));
  EXPECT_EQ(cv::countNonZero(read_regions(session) != labels), 0);
}

TEST_F(GivenRegions, SayWhichLabelHasNoNameAndWhereToNameIt) {
  write_names(R"({"names": ["background", "brow"]})");
  EXPECT_TRUE(names(complaint([&] { given(painted()); }),
                    {png().string(), "label 50 has no name", "painted.json"}));
}

TEST_F(GivenRegions, RefuseNamesThatDoNotTellRegionsApart) {
  write_names(R"({"names": ["background", "brow", "brow"]})");
  EXPECT_TRUE(
      names(complaint([&] { given(painted()); }), {"painted.json: names[2]", "named twice"}));
}

TEST_F(GivenRegions, RefuseAnImageOfAnotherSizeAndOneOfBackgroundAlone) {
  EXPECT_TRUE(names(complaint([&] { given(Labels(30, 24, uchar(1))); }),
                    {"painted.png", "24x30", "24x32"}));
  EXPECT_TRUE(names(complaint([&] { given(Labels(testing::kFakeSize, uchar(0))); }),
                    {"painted.png", "nothing but background"}));
}

// Failure: a region of its own for every shade of an edge.
TEST_F(GivenRegions, RefuseTheEdgesOfASoftBrush) {
  Labels soft(testing::kFakeSize);
  for (int i = 0; i < int(soft.total()); ++i) soft(i / soft.cols, i % soft.cols) = uchar(i % 100);
  EXPECT_TRUE(names(complaint([&] { given(soft); }), {"99 grey values", "hard brush"}));
}

}  // namespace
}  // namespace lamella
