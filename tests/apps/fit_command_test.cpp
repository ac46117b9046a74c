// fit judges the photographs as check does: what check calls unusable is refused for the same
// reason, what it calls poor is fitted with a warning and exit 1.
#include <gtest/gtest.h>

#include <functional>

#include "apps/run_lamella.h"
#include "io/fake_session.h"
#include "io/session.h"

namespace lamella {
namespace {

using testing::Outcome;
using testing::run_lamella;

class FitCommand : public ::testing::Test {
 protected:
  FitCommand() { testing::write_fake_session(session(), cv::Size(96, 128)); }

  fs::path session() const { return scratch_.path() / "session"; }

  void change(Role role, int index, const std::function<void(Image3*)>& change) const {
    const Session read = read_session(session());
    const fs::path file = session() / read.find("left", role, index, Analyser::kCross)->file;
    Image3 image = read_exr_rgb(file);
    change(&image);
    write_exr_rgb(file, image);
  }

  Outcome run(const char* command) const { return run_lamella({command, session().string()}); }

  testing::ScratchFolder scratch_;
};

TEST_F(FitCommand, FitsAGoodSessionWithoutAWord) {
  const Outcome fit = run("fit");
  EXPECT_EQ(fit.exit_code, 0);
  EXPECT_EQ(fit.err, "");
}

TEST_F(FitCommand, RefusesForTheReasonOfCheckAndLeavesNothing) {
  change(Role::kStripes, 2, [](Image3* i) { i->setTo(cv::Scalar::all(0)); });
  const std::set<std::string> before = scratch_.contents();
  const Outcome check = run("check"), fit = run("fit");
  EXPECT_EQ(check.exit_code, 2);
  EXPECT_EQ(fit.exit_code, 2);
  EXPECT_EQ(fit.err, check.err);
  EXPECT_EQ(fit.complaints().size(), 1u);
  EXPECT_NE(fit.err.find("left STRIPES 2 CROSS"), std::string::npos) << fit.err;
  EXPECT_EQ(scratch_.contents(), before);
}

TEST_F(FitCommand, FitsAPoorSessionWithAWarningAndExitsWithOne) {
  change(Role::kBlack, 0, [](Image3* i) { *i *= 8; });
  const Outcome fit = run("fit");
  EXPECT_EQ(run("check").exit_code, 1);
  EXPECT_EQ(fit.exit_code, 1) << fit.err;
  EXPECT_NE(fit.err.find("warning: below the quality asked: projector black level: "),
            std::string::npos)
      << fit.err;
  EXPECT_TRUE(fs::exists(session() / "fit/layers.json"));
}

}  // namespace
}  // namespace lamella
