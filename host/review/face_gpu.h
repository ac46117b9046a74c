// A fitted face in the graphics card's memory.
#pragma once

#include "review/gl_objects.h"
#include "review/layer_tables.h"

namespace lamella::review {

struct FaceGpu {
  VertexArrayName vertex_array;
  BufferName vertices, indices;
  int index_count = 0;
  Vec3 centre_mm{0, 0, 0};
  float radius_mm = 0;
  float height_mm = 0, width_mm = 0;
  float azimuth_rad = 0;  // of the mean normal: the side that was photographed

  Texture position_mm, normal, inside_px;
  Texture single_specular;  // rgb: alpha of eq. 3; a: c of eq. 1
  Texture shallow_albedo, deep_albedo, deep_ld_mm;
  Texture lobes, transmittance, region_weights, kernel_weights;
  int region_count = 0;
  Vec3 g{0.65f, 0.65f, 0.65f};
};

FaceGpu upload_face(const FaceMaps& face, const v1::Layers& layers);

void draw_mesh(const FaceGpu& face);

}  // namespace lamella::review
