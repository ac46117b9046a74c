// Any bytes as a mesh: one that a ray tracer can take, or one line.
#include "fuzz_input.h"
#include "io/mesh_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size) {
  using namespace lamella;
  const fuzz::MemoryFile file(bytes, size);
  fuzz::expect_error_or_nothing([&] {
    const TriangleMesh mesh = read_mesh(file.path());
    if (mesh.triangles.empty()) std::abort();
    for (const Vec3& v : mesh.vertices_mm) {
      if (!is_finite(v)) std::abort();
    }
    for (const cv::Vec3i& triangle : mesh.triangles) {
      for (const int corner : triangle.val) {
        if (corner < 0 || size_t(corner) >= mesh.vertices_mm.size()) std::abort();
      }
    }
  });
  return 0;
}
