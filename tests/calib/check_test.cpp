#include "calib/check.h"

#include <gtest/gtest.h>

#include <functional>

#include "io/fake_session.h"
#include "io/json.h"
#include "io/session.h"
#include "io/whole_file.h"
#include "link.pb.h"

namespace lamella {
namespace {

using testing::ScratchFolder;

class Check : public ::testing::Test {
 protected:
  Check() { testing::write_fake_session(path()); }

  fs::path path() const { return scratch_.path() / "session"; }

  // Replaces a photograph of the left camera by a changed one.
  void change(Role role, int index, Analyser analyser, const std::function<void(Image3*)>& change) {
    const Session session = read_session(path());
    const fs::path file = path() / session.find("left", role, index, analyser)->file;
    Image3 image = read_exr_rgb(file);
    change(&image);
    write_exr_rgb(file, image);
  }

  Grade grade_of(const std::string& name) {
    Grade worst = Grade::kGood;
    for (const CheckLine& l : check_session(path()).lines) {
      if (l.name == name) worst = std::max(worst, l.grade);
    }
    return worst;
  }

  ScratchFolder scratch_;
};

TEST_F(Check, FindsNothingWrongWithAGoodSession) {
  const SessionCheck check = check_session(path());
  EXPECT_LT(check.worst(), Grade::kPoor);
  EXPECT_EQ(check.reason(), nullptr);
  for (const CheckLine& l : check.lines) EXPECT_NE(l.grade, Grade::kPoor) << l.name << l.text;
}

TEST_F(Check, NamesEveryPhotographThatCannotBeRead) {
  change(Role::kDots, 0, Analyser::kCross, [](Image3* i) { (*i)(2, 2)[0] = kNaN; });
  change(Role::kFront, 0, Analyser::kCross, [](Image3* i) { *i = Image3(3, 3, Vec3(0, 0, 0)); });
  int named = 0;
  for (const CheckLine& l : check_session(path()).lines) {
    if (l.name == "photographs" && l.grade == Grade::kUnusable) ++named;
  }
  EXPECT_EQ(named, 2);
}

TEST_F(Check, NoticesClippedLight) {
  change(Role::kGradientFull, 0, Analyser::kParallel, [](Image3* i) { *i *= 20; });
  EXPECT_EQ(grade_of("clipped, LEDs"), Grade::kPoor);
  EXPECT_EQ(grade_of("clipped, projector"), Grade::kGood);
}

TEST_F(Check, NoticesUnderexposure) {
  change(Role::kGradientFull, 0, Analyser::kCross, [](Image3* i) { *i *= 0.005; });
  EXPECT_EQ(grade_of("signal / noise, LEDs crossed"), Grade::kPoor);
}

TEST_F(Check, NoticesAnAnalyserThatStoodTheWrongWayRound) {
  Image3 parallel;
  change(Role::kFront, 0, Analyser::kParallel, [&](Image3* i) {
    parallel = i->clone();
    *i *= 0.8;
  });
  EXPECT_EQ(grade_of("polarization, projector"), Grade::kUnusable);
  EXPECT_EQ(grade_of("polarization, LEDs"), Grade::kGood);
}

TEST_F(Check, NoticesStripesThatDoNotAddUpToWhite) {
  change(Role::kStripes, 2, Analyser::kCross, [](Image3* i) { *i *= 0.7; });
  EXPECT_EQ(grade_of("stripes against FRONT + BLACK"), Grade::kPoor);
}

TEST_F(Check, NoticesLightThatLeaksIntoBlack) {
  change(Role::kBlack, 0, Analyser::kCross, [](Image3* i) { *i *= 10; });
  EXPECT_EQ(grade_of("projector black level"), Grade::kPoor);
}

TEST_F(Check, NoticesAFringeOutOfFocus) {
  change(Role::kFringe, 3, Analyser::kCross, [this](Image3* i) {
    const Session s = read_session(path());
    *i = read_exr_rgb(path() / s.find("left", Role::kFront, 0, Analyser::kCross)->file) * 0.5;
  });
  EXPECT_EQ(grade_of("finest fringe"), Grade::kPoor);
}

TEST_F(Check, ReadsLateEdgesOffTheTiming) {
  v1::TimingEdges timing;
  v1::TimedEdge* edge = timing.add_edges();
  edge->set_planned_us(1000);
  edge->set_actual_us(1010);
  edge->set_tolerance_us(50);
  write_json(path() / "timing.json", timing);
  EXPECT_EQ(grade_of("timing"), Grade::kGood);
  edge->set_actual_us(1100);
  write_json(path() / "timing.json", timing);
  EXPECT_EQ(grade_of("timing"), Grade::kPoor);
}

TEST_F(Check, OnlyNotesWhatItDoesNotKnow) {
  std::string text = read_text(path() / "session.json");
  write_whole_text(path() / "session.json", text.insert(1, "\"mood\": \"calm\","));
  EXPECT_EQ(grade_of("manifest"), Grade::kNote);
  EXPECT_LT(check_session(path()).worst(), Grade::kPoor);
}

}  // namespace
}  // namespace lamella
