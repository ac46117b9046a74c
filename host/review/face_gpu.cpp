#include "review/face_gpu.h"

#include <algorithm>

#include "base/error.h"

namespace lamella::review {

namespace {

constexpr int kTriangles = 60000;  // fine enough for silhouettes and shadows; normals are a map

struct Vertex {
  Vec3 position_mm;
  Vec2 uv;
};

void attribute(GLuint slot, int floats, size_t offset) {
  glEnableVertexAttribArray(slot);
  glVertexAttribPointer(slot, floats, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                        reinterpret_cast<const void*>(offset));
}

BufferName filled_buffer(GLenum target, size_t bytes, const void* data) {
  GLuint id = 0;
  glGenBuffers(1, &id);
  glBindBuffer(target, id);
  glBufferData(target, GLsizeiptr(bytes), data, GL_STATIC_DRAW);
  return BufferName(id);
}

void upload_mesh(const FaceMesh& mesh, cv::Size map_size, FaceGpu* gpu) {
  std::vector<Vertex> vertices;
  for (size_t i = 0; i < mesh.pixel.size(); ++i) {
    const Vec2 uv((mesh.pixel[i][0] + 0.5f) / float(map_size.width),
                  (mesh.pixel[i][1] + 0.5f) / float(map_size.height));
    vertices.push_back({mesh.vertices_mm[i], uv});
  }
  GLuint id = 0;
  glGenVertexArrays(1, &id);
  gpu->vertex_array = VertexArrayName(id);
  glBindVertexArray(id);
  gpu->vertices = filled_buffer(GL_ARRAY_BUFFER, vertices.size() * sizeof(Vertex), vertices.data());
  gpu->indices = filled_buffer(GL_ELEMENT_ARRAY_BUFFER, mesh.triangles.size() * sizeof(cv::Vec3i),
                               mesh.triangles.data());
  attribute(0, 3, offsetof(Vertex, position_mm));
  attribute(1, 2, offsetof(Vertex, uv));
  gpu->index_count = int(mesh.triangles.size()) * 3;
}

void measure(const FaceMesh& mesh, FaceGpu* gpu) {
  Vec3 low(1e9f, 1e9f, 1e9f), high = -low;
  for (const Vec3& p : mesh.vertices_mm) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  gpu->centre_mm = (low + high) * 0.5f;
  gpu->width_mm = high[0] - low[0];
  gpu->height_mm = high[1] - low[1];
  for (const Vec3& p : mesh.vertices_mm) {
    gpu->radius_mm = std::max(gpu->radius_mm, length(p - gpu->centre_mm));
  }
}

// A layer a region, `cells` samples each.
template <class Sample>
Texture table_texture(size_t regions, int cells, const Sample& sample) {
  Image1 table(int(regions), cells);
  for (int r = 0; r < table.rows; ++r) {
    for (int i = 0; i < cells; ++i) table(r, i) = sample(size_t(r), i);
  }
  return make_texture({GL_TEXTURE_1D_ARRAY, GL_R32F, GL_RED}, {cells, table.rows, 1}, table.data);
}

void upload_tables(const FaceMaps& face, const v1::Layers& layers, FaceGpu* gpu) {
  const RegionTables tables = region_tables(face, layers);
  gpu->region_count = int(tables.lobes.size());
  gpu->lobes = table_texture(tables.lobes.size(), model::LobeTable::kCells + 1,
                             [&](size_t r, int i) { return tables.lobes[r].cells()[size_t(i)]; });
  constexpr int kCosines = 65;
  gpu->transmittance = table_texture(tables.lobes.size(), kCosines, [&](size_t r, int i) {
    return tables.transmittance[r](float(i) / float(kCosines - 1));
  });
  const cv::Mat4f kernels = kernel_table(typical_alpha(face), layers);
  gpu->kernel_weights = make_texture({GL_TEXTURE_2D, GL_RGBA32F, GL_RGBA},
                                     {kernels.cols, kernels.rows, 1}, kernels.data);
}

void upload_regions(const FaceMaps& face, FaceGpu* gpu) {
  const std::vector<Image1> planes = region_weights(face.maps.regions, gpu->region_count);
  const int layers = (gpu->region_count + 3) / 4;
  const cv::Size size = planes[0].size();
  std::vector<float> packed(size_t(size.area() * layers * 4), 0.f);
  for (size_t r = 0; r < planes.size(); ++r) {
    for (int i = 0; i < size.area(); ++i) {
      packed[(r / 4 * size_t(size.area()) + size_t(i)) * 4 + r % 4] =
          planes[r](i / size.width, i % size.width);
    }
  }
  gpu->region_weights = make_texture({GL_TEXTURE_2D_ARRAY, GL_RGBA16F, GL_RGBA},
                                     {size.width, size.height, layers}, packed.data());
}

Image3 or_zero(const Image3& map, cv::Size size) {
  return map.empty() ? Image3(size, Vec3(0, 0, 0)) : map;
}

// In one texture: cards need not take more than sixteen.
Texture single_and_specular(const LayerMaps& m) {
  cv::Mat4f both(m.position_mm.size(), cv::Vec4f(0, 0, 0, 0));
  for (int y = 0; y < both.rows; ++y) {
    for (int x = 0; x < both.cols; ++x) {
      cv::Vec4f& v = both(y, x);
      if (!m.single_albedo.empty()) {
        for (int c = 0; c < 3; ++c) v[c] = m.single_albedo(y, x)[c];
      }
      if (!m.specular_intensity.empty()) v[3] = m.specular_intensity(y, x);
    }
  }
  return make_texture({GL_TEXTURE_2D, GL_RGBA32F, GL_RGBA}, {both.cols, both.rows, 1}, both.data);
}

void upload_maps(const FaceMaps& face, FaceGpu* gpu) {
  const LayerMaps& m = face.maps;
  const cv::Size size = m.position_mm.size();
  gpu->position_mm = map_texture(m.position_mm);
  gpu->normal = map_texture(m.normal_specular);
  gpu->inside_px = map_texture(face.outline.inside_px);
  gpu->single_specular = single_and_specular(m);
  gpu->shallow_albedo = map_texture(or_zero(m.shallow_albedo, size));
  // A fit without the stripes' separation is one diffuse layer, all of it deep.
  gpu->deep_albedo =
      map_texture(or_zero(m.deep_albedo.empty() ? m.total_albedo : m.deep_albedo, size));
  gpu->deep_ld_mm = map_texture(or_zero(m.deep_ld_mm, size));
}

}  // namespace

FaceGpu upload_face(const FaceMaps& face, const v1::Layers& layers) {
  const double pixels = cv::countNonZero(face.outline.inside_px > 0.f);
  const int step = std::max(1, int(std::lround(std::sqrt(2.0 * pixels / kTriangles))));
  const FaceMesh mesh = mesh_face(face.maps.position_mm, face.outline.inside_px, step);
  if (mesh.triangles.empty())
    throw_bad_input("position.exr", "no surface to show", "run fit again");
  FaceGpu gpu;
  upload_mesh(mesh, face.maps.position_mm.size(), &gpu);
  measure(mesh, &gpu);
  const cv::Scalar n = cv::mean(face.maps.normal_specular, face.outline.inside_px > 0.f);
  gpu.azimuth_rad = float(std::atan2(n[0], n[2]));
  upload_maps(face, &gpu);
  upload_tables(face, layers, &gpu);
  upload_regions(face, &gpu);
  if (layers.single().g_size() == 3) {
    for (int c = 0; c < 3; ++c) gpu.g[c] = float(layers.single().g(c));
  }
  return gpu;
}

void draw_mesh(const FaceGpu& face) {
  glBindVertexArray(face.vertex_array.id());
  glDrawElements(GL_TRIANGLES, face.index_count, GL_UNSIGNED_INT, nullptr);
}

}  // namespace lamella::review
