#include "io/view.h"

#include "io/expect_error.h"
#include "io/fake_session.h"
#include "io/rig_message.h"
#include "io/whole_file.h"

namespace lamella {
namespace {

using testing::complaint;
using testing::names;
using testing::ScratchFolder;

View four_lights(const fs::path& folder) {
  write_exr_rgb(folder / "studio.exr", Image3(4, 8, Vec3(1, 1, 1)));
  View view;
  view.camera = camera_from_message(testing::fake_calibration({80, 100}).rig().cameras(0), "");
  view.lights.push_back({Light::Kind::kPoint, {700, 200, 700}, {1, 0.5f, 0.25f}, {}, {}});
  view.lights.push_back({Light::Kind::kLeds, {}, {1, 1, 1}, {0.f, 0.5f, 1.f}, {}});
  view.lights.push_back({Light::Kind::kProjector, {}, {1, 1, 1}, {}, {}});
  view.lights.push_back({Light::Kind::kEnvironment, {}, {1, 1, 1}, {}, folder / "studio.exr"});
  return view;
}

TEST(View, ReadsEveryKindOfLightAsItWasWritten) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "view.json";
  write_view(file, four_lights(scratch.path()));
  const View view = read_view(file, 3);
  ASSERT_EQ(view.lights.size(), 4u);
  EXPECT_EQ(view.lights[0].position_mm, Vec3(700, 200, 700));
  EXPECT_EQ(view.lights[0].radiance_at_origin, Vec3(1, 0.5f, 0.25f));
  EXPECT_EQ(view.lights[1].weights, (std::vector<float>{0.f, 0.5f, 1.f}));
  EXPECT_EQ(view.lights[2].kind, Light::Kind::kProjector);
  EXPECT_EQ(view.lights[3].file, scratch.path() / "studio.exr");
  EXPECT_EQ(view.camera.width, 80);
}

TEST(View, NamesTheLightThatIsWrong) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "view.json";
  const auto after = [&](const std::function<void(View*)>& spoil) {
    View view = four_lights(scratch.path());
    spoil(&view);
    write_view(file, view);
    return complaint([&] { read_view(file, 3); });
  };
  EXPECT_TRUE(names(after([](View* v) { v->lights[1].weights.push_back(1); }),
                    {"view.json: lights[1].weights", "4 numbers", "3 LEDs"}));
  EXPECT_TRUE(names(after([](View* v) { v->lights[3].file = "gone.exr"; }),
                    {"view.json: lights[3].file", "gone.exr"}));
  EXPECT_TRUE(names(after([](View* v) { v->lights[0].radiance_at_origin[1] = -1; }),
                    {"lights[0].radiance_at_origin"}));
  EXPECT_TRUE(names(after([](View* v) { v->lights.clear(); }), {"view.json: lights", "missing"}));
  EXPECT_TRUE(names(after([](View* v) { v->camera.fx = 0; }), {"view.json: camera.fx"}));
}

TEST(View, ListsWhatItDoesNotKnow) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "view.json";
  write_view(file, four_lights(scratch.path()));
  std::string text = read_text(file);
  write_whole_text(file, text.insert(1, "\"lens\": 50,"));
  const View view = read_view(file, 3);
  ASSERT_EQ(view.warnings.size(), 1u);
  EXPECT_TRUE(names(view.warnings[0], {"view.json", "lens"}));
}

}  // namespace
}  // namespace lamella
