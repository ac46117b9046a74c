// The floor of an error: the law that tells noise from the model, the noise that is added, and
// that a step is given everything but what it estimates.
#include "apps/bench_floor.h"

#include <gtest/gtest.h>

#include "apps/bench_chart.h"
#include "apps/bench_floor_steps.h"
#include "apps/bench_noise.h"
#include "apps/run_lamella.h"
#include "base/error.h"
#include "calib/photographs.h"
#include "fit/report.h"
#include "io/fake_session.h"
#include "io/json.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using apps::Floor;
using apps::KnownScene;
using testing::Outcome;
using testing::run_lamella;
using v1::BenchFloor;

// Errors of model `model` and noise `noise` at the levels that the bench takes.
Floor floor_of(double fit_error, double model, double noise) {
  Floor floor{0, "", fit_error, {}};
  for (const double level : {1.0, M_SQRT2, 2.0}) {
    floor.levels.push_back({level, {std::hypot(model, level * noise)}});
  }
  return floor;
}

TEST(Floor, TellsNoiseFromModelByHowTheSquareOfTheErrorGrows) {
  const apps::NoiseLaw law = apps::noise_law(floor_of(1, 0.3, 0.4).levels);
  EXPECT_NEAR(law.model, 0.3, 1e-9);
  EXPECT_NEAR(law.due_to_noise, 0.4, 1e-9);
  EXPECT_NEAR(law.noise_share(), 0.64, 1e-9);
}

TEST(Floor, ThatFallsWithTheNoiseIsReachedWithinAFactorOfOnePointTwo) {
  EXPECT_EQ(floor_of(0.59, 0.3, 0.4).verdict(), BenchFloor::REACHED);
  EXPECT_EQ(floor_of(0.61, 0.3, 0.4).verdict(), BenchFloor::NOT_REACHED);
}

TEST(Floor, ThatDoesNotFallWithTheNoiseIsTheModelsErrorHoweverNearTheFitIs) {
  EXPECT_EQ(floor_of(0.5, 0.4, 0.3).verdict(), BenchFloor::MODEL_ERROR);
}

TEST(Floor, OfAnErrorThatShrinksUnderNoiseHasNoPartOfNoise) {
  Floor floor = floor_of(1, 1, 0);
  floor.levels[2].errors = {0.5};
  EXPECT_EQ(apps::noise_law(floor.levels).due_to_noise, 0);
}

TEST(Floor, StandsBelowItsErrorOnThePageUnderTheNameOfWhatMakesIt) {
  const apps::Bench bench{{2}, std::vector<double>(apps::bench_figures().size(), 0.59), {}, {}, {}};
  Floor noise = floor_of(0.59, 0.3, 0.4), model = floor_of(0.59, 0.4, 0.3);
  noise.figure = 8;
  model.figure = 10;
  const std::string page = apps::bench_chart(bench, {}, {noise, model}, "head");
  EXPECT_NE(page.find(">floor 50 %: reached<"), std::string::npos) << page;
  EXPECT_NE(page.find(">model's 50 %<"), std::string::npos);
}

TEST(Floor, OfAFigureThatIsNotThereIsNotKnown) {
  Floor floor = floor_of(1, 0.3, 0.4);
  floor.levels[1].errors = {std::numeric_limits<double>::quiet_NaN()};
  EXPECT_EQ(floor.verdict(), BenchFloor::NOT_KNOWN);
  EXPECT_EQ(apps::floor_csv({floor}).find("nan"), std::string::npos);
  EXPECT_EQ(apps::floor_table({floor}).find("nan"), std::string::npos);
}

TEST(Floor, IsTakenByNameByLabelOrByLabelUpToItsComma) {
  EXPECT_EQ(apps::figures_named({"ld_rel_error", "l_d"}), std::vector<size_t>{8});
  EXPECT_EQ(apps::figures_named({"position"}), (std::vector<size_t>{0, 1}));
  EXPECT_EQ(apps::figures_named({"all"}).size(), apps::bench_figures().size());
  EXPECT_THROW(apps::figures_named({"beauty"}), Error);
}

TEST(Floor, OfEveryFigureHasAStepThatMakesIt) {
  size_t made = 0;
  for (const apps::FloorStep& step : apps::floor_steps()) made += step.figures.size();
  EXPECT_EQ(made, apps::bench_figures().size());
}

class FloorBench : public ::testing::Test {
 protected:
  fs::path folder() const { return scratch_.path() / "session"; }

  // What stands in place of a truth is the default's own fit.
  void make_session_with_truth(cv::Size size) const {
    testing::write_fake_session(folder(), size);
    run_lamella({"fit", folder().string(), "--out", (folder() / "truth").string()});
  }

  testing::ScratchFolder scratch_;
};

double variance_of(const Image3& a, const Image3& b) {
  double sum = 0, square = 0, count = 0;
  for (int y = 0; y < a.rows; ++y) {
    for (int x = 0; x < a.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double d = double(a(y, x)[c]) - double(b(y, x)[c]);
        sum += d, square += d * d, count += 1;
      }
    }
  }
  return square / count - sum * sum / (count * count);
}

// What the camera's figures say that `times` as much noise adds to a photograph, on average.
double added_variance(const Session& session, const Image3& stored, double times) {
  const Camera& camera = session.left;
  const cv::Scalar sum = cv::sum(cv::max(cv::Mat(stored).reshape(1), 0.0));
  const double level = sum[0] / double(stored.total() * 3);
  return (times * times - 1) * (camera.read_noise * camera.read_noise +
                                level * camera.saturation / camera.full_well_electrons);
}

TEST_F(FloorBench, AddsAsMuchNoiseAsTheCameraStatesAndSaysSo) {
  testing::write_fake_session(folder(), {48, 64});
  const Session session = read_session(folder());
  fs::create_directory(scratch_.path() / "noisier");
  const Session noisier = apps::noisier_session(session, 2, 7, scratch_.path() / "noisier");
  const Image3 before = read_exr_rgb(session.path / session.frames[0].file);
  const Image3 after = read_exr_rgb(noisier.path / noisier.frames[0].file);
  EXPECT_NEAR(variance_of(after, before) / added_variance(session, before, 2), 1, 0.06);
  EXPECT_DOUBLE_EQ(noisier.left.read_noise, 2 * session.left.read_noise);
  EXPECT_DOUBLE_EQ(apps::noise_against(noisier, session), 2);
  const Session again = apps::noisier_session(session, 2, 7, scratch_.path() / "noisier");
  EXPECT_EQ(variance_of(after, read_exr_rgb(again.path / again.frames[0].file)), 0);
  const Session other = apps::noisier_session(session, 2, 8, scratch_.path() / "noisier");
  EXPECT_GT(variance_of(after, read_exr_rgb(other.path / other.frames[0].file)), 0);
  fit::linearise(noisier);  // it is a session like any other
}

TEST_F(FloorBench, LeavesClippedWhatWasAndRefusesACameraThatStatesNoNoise) {
  testing::write_fake_session(folder(), {48, 64});
  Session session = read_session(folder());
  const Frame& frame = session.frames[0];
  Image3 stored = read_exr_rgb(session.path / frame.file);
  stored(5, 7) = Vec3(2, 2, 2);
  write_exr_rgb(session.path / frame.file, stored);
  fs::create_directory(scratch_.path() / "noisier");
  const Session noisier = apps::noisier_session(session, 2, 7, scratch_.path() / "noisier");
  EXPECT_EQ(read_exr_rgb(noisier.path / noisier.frames[0].file)(5, 7), Vec3(2, 2, 2));
  session.left.read_noise = session.left.full_well_electrons = 0;
  EXPECT_THROW(apps::require_noise(session), Error);
}

// All that a step has found, as text.
std::string found_by(const apps::FloorStep& step, const KnownScene& scene) {
  fit::LayeredFit fit;
  fit::start_report(scene.burst, &fit);
  step.run(scene, &fit);
  std::string text = nlohmann::json::parse(to_json(fit.layers)).dump();  // keys sorted
  for (const auto& [name, map] : named_maps(fit.maps)) {
    text.append(reinterpret_cast<const char*>(map.data), map.total() * map.elemSize());
  }
  return text;
}

// Scenes share their maps: a new one, not the same turned.
void turn(Image3* normal) {
  *normal = normal->clone();
  for (Vec3& n : *normal) n = unit(n + Vec3(0.3f, 0.1f, 0));
}

template <class Map>
void scale(float factor, Map* map) {
  *map = *map * factor;
}

using Spoil = void (*)(KnownScene*);

struct StepCase {
  const char* figure;
  Spoil own;    // the truth of what the step estimates
  Spoil given;  // of what it is given
};

const StepCase kStepCases[] = {
    {"position_rms_mm", [](KnownScene* s) { scale(1.1f, &s->geometry.position_mm); },
     [](KnownScene* s) { turn(&s->normals.diffuse[1]); }},
    {"specular_normal_median_deg", [](KnownScene* s) { turn(&s->normals.specular); },
     [](KnownScene* s) { turn(&s->normals.diffuse[2]); }},
    {"diffuse_normal_median_deg", [](KnownScene* s) { turn(&s->normals.diffuse[1]); }, nullptr},
    {"c_rel_rmse", [](KnownScene* s) { scale(2, &s->truth.maps.specular_intensity); },
     [](KnownScene* s) { turn(&s->normals.specular); }},
    {"p_l1",
     [](KnownScene* s) {
       for (v1::Region& region : *s->truth.layers.mutable_regions()) {
         for (double& p : *region.mutable_specular()->mutable_p()) p *= p;
         for (double& a : *region.mutable_single()->mutable_amplitude()) a = 2;
       }
     },
     [](KnownScene* s) { scale(2, &s->truth.maps.specular_intensity); }},
    {"ld_rel_error", [](KnownScene* s) { scale(2, &s->truth.maps.deep_ld_mm); },
     [](KnownScene* s) { scale(0.5f, &s->truth.maps.shallow_albedo); }},
    {"deep_albedo_rel_rmse", [](KnownScene* s) { scale(2, &s->truth.maps.deep_albedo); },
     [](KnownScene* s) { turn(&s->normals.specular); }}};

TEST_F(FloorBench, GivesAStepTheTruthOfAllButWhatItEstimates) {
  make_session_with_truth({96, 128});
  const Session session = read_session(folder());
  const KnownScene scene = apps::know_scene(session, folder() / "truth");
  for (const StepCase& step_case : kStepCases) {
    SCOPED_TRACE(step_case.figure);
    const apps::FloorStep& step = apps::step_of_figure(step_case.figure);
    const std::string found = found_by(step, scene);
    const auto found_with = [&](Spoil spoil) {
      KnownScene spoilt = scene;
      spoil(&spoilt);
      return found_by(step, spoilt);
    };
    EXPECT_TRUE(found == found_with(step_case.own));
    if (step_case.given) {
      EXPECT_FALSE(found == found_with(step_case.given));
    }
  }
}

TEST_F(FloorBench, WritesTheFloorBesideTheFitAtEveryLevelOfNoiseOrPrintsItAlone) {
  make_session_with_truth({48, 64});
  const fs::path out = scratch_.path() / "bench";
  const Outcome outcome = run_lamella({"bench", folder().string(), "--floor", "p", "--floor",
                                       "specular normal", "--rounds", "2", "--out", out.string()});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  v1::Bench report;
  read_json(out / "bench.json", &report);
  ASSERT_EQ(report.floors_size(), 2);
  EXPECT_EQ(report.floors(0).figure(), "specular_normal_median_deg");
  EXPECT_LT(report.floors(0).error(), 0.1);  // the truth is the fit itself
  ASSERT_EQ(report.floors(0).levels_size(), 3);
  EXPECT_NE(report.floors(1).levels(0).errors(0), report.floors(1).levels(2).errors(0));
  EXPECT_NE(read_text(out / "floor.csv").find("\np_l1,,"), std::string::npos);
  EXPECT_FALSE(fs::exists(out / "floor"));
  const std::set<std::string> before = scratch_.contents();
  setenv("TMPDIR", scratch_.path().c_str(), 1);
  const Outcome printed =
      run_lamella({"bench", folder().string(), "--floor", "specular normal", "--rounds", "1"});
  unsetenv("TMPDIR");
  EXPECT_NE(printed.out.find("specular normal, median"), std::string::npos) << printed.err;
  EXPECT_EQ(scratch_.contents(), before);
}

TEST_F(FloorBench, RefusesWhatItCannotMeasureAndLeavesNothing) {
  testing::write_fake_session(folder());
  const auto refused = [&](std::vector<std::string> arguments, const std::string& named) {
    arguments.insert(arguments.begin(), {"bench", folder().string()});
    const std::set<std::string> before = scratch_.contents();
    const Outcome outcome = run_lamella(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    ASSERT_EQ(outcome.complaints().size(), 1u) << outcome.err;
    EXPECT_NE(outcome.err.find(named), std::string::npos) << outcome.err;
    EXPECT_EQ(scratch_.contents(), before);
  };
  refused({"--floor", "l_d"}, "no truth");
  refused({"--floor", "beauty"}, "one of all, position_median_mm");
  refused({}, "--out: is needed");
  refused({"--out", (scratch_.path() / "b").string(), "--quieter", folder().string()},
          "is of --floor");
  refused({"--floor", "l_d", "--quieter", folder().string()}, "its camera is not quieter");
}

}  // namespace
}  // namespace lamella
