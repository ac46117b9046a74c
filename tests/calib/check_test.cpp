#include "calib/check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "calib/check_rig.h"
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

  void change_rig(const std::function<void(v1::Rig*)>& change) {
    v1::Session manifest;
    read_json(path() / "session.json", &manifest);
    change(manifest.mutable_rig());
    if (manifest.rig().cameras_size() < 2) {
      auto* frames = manifest.mutable_frames();
      frames->erase(std::remove_if(frames->begin(), frames->end(),
                                   [](const v1::Frame& f) { return f.camera() == "right"; }),
                    frames->end());
    }
    write_json(path() / "session.json", manifest);
  }

  Grade grade_of(const std::string& name) {
    Grade worst = Grade::kGood;
    for (const CheckLine& l : check_session(path()).lines) {
      if (l.name == name) worst = std::max(worst, l.grade);
    }
    return worst;
  }

  std::string text_of(const std::string& name) {
    for (const CheckLine& l : check_session(path()).lines) {
      if (l.name == name) return l.text;
    }
    return "";
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
  change(Role::kGradientFull, 0, Analyser::kParallel,
         [](Image3* i) { (*i)(cv::Rect(8, 8, 8, 8)).setTo(cv::Scalar::all(20)); });
  EXPECT_EQ(grade_of("clipped, LEDs"), Grade::kPoor);
  EXPECT_EQ(grade_of("clipped, projector"), Grade::kGood);
}

TEST_F(Check, NoticesClippedLightInWhateverFrameItIsAndNamesTheFrame) {
  struct Case {
    Role role;
    int index;
    Analyser analyser;
    const char *line, *frame;
  };
  const Case cases[] = {
      {Role::kDots, 0, Analyser::kCross, "clipped, projector", "left DOTS CROSS"},
      {Role::kBlack, 0, Analyser::kCross, "clipped, projector", "left BLACK CROSS"},
      {Role::kFringe, 0, Analyser::kCross, "clipped, projector", "left FRINGE 0 CROSS"},
      {Role::kGradientY, 0, Analyser::kParallel, "clipped, LEDs", "left GRADIENT_Y PARALLEL"}};
  for (const Case& c : cases) {
    testing::write_fake_session(path());
    change(c.role, c.index, c.analyser,
           [](Image3* i) { (*i)(cv::Rect(8, 8, 8, 8)).setTo(cv::Scalar::all(20)); });
    EXPECT_EQ(grade_of(c.line), Grade::kPoor) << c.frame;
    EXPECT_NE(text_of(c.line).find(std::string("most in ") + c.frame), std::string::npos)
        << text_of(c.line);
  }
}

TEST_F(Check, TellsNoiseThatClipsFromLightThatDoes) {
  const auto clip = [](Image3* i) { (*i)(cv::Rect(8, 8, 8, 8)).setTo(cv::Scalar::all(20)); };
  change(Role::kGradientFull, 0, Analyser::kCross, clip);
  EXPECT_NE(text_of("clipped, LEDs").find("expose it less"), std::string::npos);
  change_rig([](v1::Rig* rig) { rig->mutable_cameras(0)->set_full_well_electrons(3); });
  EXPECT_NE(text_of("clipped, LEDs").find("that is noise"), std::string::npos)
      << text_of("clipped, LEDs");
}

TEST_F(Check, NoticesClippedLightOfTheRightCamera) {
  const Session session = read_session(path());
  const fs::path file = path() / session.find("right", Role::kFringe, 1, Analyser::kCross)->file;
  Image3 image = read_exr_rgb(file);
  image(cv::Rect(8, 8, 8, 8)).setTo(cv::Scalar::all(20));
  write_exr_rgb(file, image);
  EXPECT_EQ(grade_of("clipped, right camera"), Grade::kPoor);
  EXPECT_EQ(grade_of("clipped, projector"), Grade::kGood);
}

TEST_F(Check, NamesAColourThatAPhotographLacks) {
  const auto without_green = [](Image3* i) {
    for (Vec3& v : *i) v[1] = 0;
  };
  change(Role::kDots, 0, Analyser::kCross, without_green);
  ASSERT_NE(check_session(path()).reason(), nullptr);
  EXPECT_EQ(text_of("light"), "no green light in left DOTS CROSS; take the burst again");
  const Session session = read_session(path());
  for (const Frame& frame : session.frames) {
    if (frame.camera == "left") change(frame.role, frame.index, frame.analyser, without_green);
  }
  EXPECT_EQ(text_of("light"),
            "no green light in any photograph of the left camera; take the burst again");
}

TEST_F(Check, NoticesUnderexposure) {
  change(Role::kGradientFull, 0, Analyser::kCross, [](Image3* i) { *i *= 0.005; });
  EXPECT_EQ(grade_of("signal / noise, LEDs crossed"), Grade::kPoor);
}

TEST_F(Check, NamesEveryPhotographWithoutLight) {
  const auto blank = [](Image3* i) { i->setTo(cv::Scalar::all(0)); };
  change(Role::kDots, 0, Analyser::kCross, blank);
  change(Role::kStripes, 3, Analyser::kCross, blank);
  const SessionCheck check = check_session(path());
  ASSERT_NE(check.reason(), nullptr);
  EXPECT_EQ(check.reason()->text,
            "no light in left DOTS CROSS, left STRIPES 3 CROSS; take the burst again");
}

TEST_F(Check, NamesThePhotographThatTheOthersAreMeasuredBy) {
  change(Role::kGradientFull, 0, Analyser::kCross, [](Image3* i) { i->setTo(cv::Scalar::all(0)); });
  const SessionCheck check = check_session(path());
  ASSERT_NE(check.reason(), nullptr);
  EXPECT_EQ(check.reason()->text, "no light in left GRADIENT_FULL CROSS; take the burst again");
}

TEST_F(Check, LooksAtTheRightCameraToo) {
  const Session session = read_session(path());
  const Frame* fringe = session.find("right", Role::kFringe, 1, Analyser::kCross);
  write_exr_rgb(path() / fringe->file, Image3(testing::kFakeSize, Vec3(0, 0, 0)));
  EXPECT_EQ(grade_of("light"), Grade::kUnusable);
}

TEST_F(Check, OnlyNotesAPhotographThatNoFitNeeds) {
  const Session session = read_session(path());
  const Frame* stripes = session.find("right", Role::kStripes, 1, Analyser::kCross);
  write_whole_text(path() / stripes->file, "not an image");
  EXPECT_EQ(grade_of("photographs"), Grade::kNote);
  EXPECT_EQ(check_session(path()).reason(), nullptr);
}

TEST_F(Check, FindsCamerasThatStandAtTheSamePlace) {
  change_rig([](v1::Rig* rig) {
    const v1::Camera left = rig->cameras(0);
    *rig->mutable_cameras(1) = left;
    rig->mutable_cameras(1)->set_id("right");
  });
  EXPECT_EQ(grade_of("baseline"), Grade::kUnusable);
}

TEST_F(Check, FindsAProjectorAtThePlaceOfTheOnlyCamera) {
  change_rig([](v1::Rig* rig) {
    rig->mutable_cameras()->DeleteSubrange(1, 1);
    *rig->mutable_projector()->mutable_rotation() = rig->cameras(0).rotation();
    *rig->mutable_projector()->mutable_translation_mm() = rig->cameras(0).translation_mm();
  });
  EXPECT_EQ(grade_of("baseline"), Grade::kUnusable);
}

TEST_F(Check, FindsPatternsThatThePixelsAreTooCoarseFor) {
  EXPECT_EQ(grade_of("period of the stripes"), Grade::kGood);
  EXPECT_EQ(grade_of("diameter of the dots"), Grade::kGood);
  change_rig([](v1::Rig* rig) {
    rig->mutable_projector()->set_fx(1.5 * rig->projector().fx());
    rig->mutable_projector()->set_fy(1.5 * rig->projector().fy());
  });
  EXPECT_EQ(grade_of("period of the stripes"), Grade::kPoor);
  EXPECT_EQ(grade_of("diameter of the dots"), Grade::kPoor);
}

TEST_F(Check, AsksForNoBaselineWhereAMeshTellsTheShape) {
  const std::vector<CheckLine> lines = check_rig(read_session(path()), ShapeFrom::kMesh);
  EXPECT_FALSE(lines.empty());
  for (const CheckLine& line : lines) EXPECT_NE(line.name, "baseline");
}

TEST_F(Check, FindsACameraThatCannotSeeTheSubject) {
  using Spoil = std::function<void(v1::Camera*)>;
  const Spoil cases[] = {
      [](v1::Camera* c) { c->set_fx(1e-3); },
      [](v1::Camera* c) { c->set_cx(1e8); },
      [](v1::Camera* c) { c->set_translation_mm(2, 1e9); },
      [](v1::Camera* c) { c->set_translation_mm(2, -1000); },
      [](v1::Camera* c) { c->set_distortion(0, -1e6); },
  };
  const v1::Camera good = testing::fake_calibration(testing::kFakeSize).rig().cameras(0);
  EXPECT_EQ(grade_of("views"), Grade::kGood);
  for (const Spoil& spoil : cases) {
    change_rig([&](v1::Rig* rig) {
      *rig->mutable_cameras(0) = good;
      spoil(rig->mutable_cameras(0));
    });
    EXPECT_EQ(grade_of("views"), Grade::kUnusable);
  }
}

TEST_F(Check, GivesUpWhereMostOfTheSubjectIsClipped) {
  change_rig([](v1::Rig* rig) { rig->mutable_cameras(0)->set_saturation(1e-6); });
  EXPECT_EQ(grade_of("clipped, LEDs"), Grade::kUnusable);
}

TEST_F(Check, FindsTooFewLeds) {
  change_rig([](v1::Rig* rig) { rig->mutable_leds()->DeleteSubrange(3, rig->leds_size() - 3); });
  EXPECT_EQ(grade_of("LEDs"), Grade::kUnusable);
}

TEST_F(Check, FindsLedsThatLieInAPlane) {
  change_rig([](v1::Rig* rig) {
    for (v1::Led& led : *rig->mutable_leds()) {
      const double length = std::hypot(led.direction(0), led.direction(2));
      led.set_direction(0, led.direction(0) / length);
      led.set_direction(1, 0);
      led.set_direction(2, led.direction(2) / length);
    }
  });
  EXPECT_EQ(grade_of("LEDs"), Grade::kUnusable);
}

TEST_F(Check, FindsLedsThatAreAllBehindTheSubject) {
  change_rig([](v1::Rig* rig) {
    for (v1::Led& led : *rig->mutable_leds()) led.set_direction(2, -std::abs(led.direction(2)));
  });
  EXPECT_EQ(grade_of("LEDs"), Grade::kUnusable);
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
  edge->set_actual_us(900);
  write_json(path() / "timing.json", timing);
  EXPECT_EQ(grade_of("timing"), Grade::kPoor);
  edge->set_line("ARRIVED");  // an analyser that is there early waits
  write_json(path() / "timing.json", timing);
  EXPECT_EQ(grade_of("timing"), Grade::kGood);
  edge->set_actual_us(1100);
  write_json(path() / "timing.json", timing);
  EXPECT_EQ(grade_of("timing"), Grade::kPoor);
  edge->set_replaced(true);  // its photograph was taken again
  write_json(path() / "timing.json", timing);
  EXPECT_EQ(grade_of("timing"), Grade::kGood);
}

TEST_F(Check, OnlyNotesWhatItDoesNotKnow) {
  std::string text = read_text(path() / "session.json");
  write_whole_text(path() / "session.json", text.insert(1, "\"mood\": \"calm\","));
  EXPECT_EQ(grade_of("manifest"), Grade::kNote);
  EXPECT_LT(check_session(path()).worst(), Grade::kPoor);
}

}  // namespace
}  // namespace lamella
