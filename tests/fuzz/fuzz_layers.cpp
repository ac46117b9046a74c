// Any text as layers.json beside sound maps: a fit that can be drawn, or one line that says why
// not.
#include <fstream>

#include "fuzz_input.h"
#include "io/fit_folder.h"

namespace {

using namespace lamella;
namespace fs = std::filesystem;

LayerMaps sound_maps() {
  const cv::Size size(4, 3);
  const Image3 grey(size, cv::Vec3f(0.2f, 0.2f, 0.2f)), normal(size, cv::Vec3f(0, 0, 1));
  LayerMaps maps;
  maps.position_mm = Image3(size, cv::Vec3f(1, 2, 3));
  maps.normal_specular = normal;
  maps.normal_diffuse = {normal, normal, normal};
  maps.specular_intensity = Image1(size, 0.1f);
  maps.single_albedo = maps.total_albedo = maps.shallow_albedo = maps.deep_albedo = grey;
  maps.deep_alpha = maps.deep_ld_mm = grey;
  maps.regions = Labels(size, uint8_t(1));
  return maps;
}

struct Fit {
  std::string path = "/tmp/lamella-fuzz-XXXXXX";

  Fit() {
    if (!mkdtemp(path.data())) std::abort();
    write_layer_maps(path, sound_maps());
  }
  ~Fit() { fs::remove_all(path); }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  static const Fit fit;
  std::ofstream(fs::path(fit.path) / "layers.json", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes), std::streamsize(size));
  fuzz::expect_error_or_nothing([&] { read_fit_folder(fit.path); });
  return 0;
}
