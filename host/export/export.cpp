#include "export/export.h"

#include "base/error.h"
#include "base/progress.h"
#include "export/glb.h"
#include "export/reduce.h"

namespace lamella::exporting {

namespace {

// Only what a .glb carries: the other maps would be cropped and filled for nothing.
LayerMaps carried(const LayerMaps& maps) {
  LayerMaps part;
  part.position_mm = maps.position_mm;
  part.normal_specular = maps.normal_specular;
  part.total_albedo = maps.total_albedo;
  part.specular_intensity = maps.specular_intensity;
  part.regions = maps.regions;
  if (maps.total_albedo.empty()) {
    part.deep_albedo = maps.deep_albedo;
    part.shallow_albedo = maps.shallow_albedo;
  }
  return part;
}

}  // namespace

ExportReport export_face(const LayerMaps& maps, const v1::Layers& layers,
                         const std::string& subject, const fs::path& file,
                         const ExportOptions& options) {
  const Stopwatch stopwatch;
  const LayerMaps all = carried(maps);
  const FaceMaps face = face_from_maps(reduced(all, block_of(all, options)), subject);
  GlbContent content;
  content.subject = subject;
  content.layers = layers;
  content.mesh = engine_mesh(face, options.triangles);
  if (content.mesh.indices.empty())
    throw_bad_input(subject, "no surface to export", "run fit again");
  content.textures = face_textures(face, layers, content.mesh, options.texture_side_px);
  write_glb(file, content);
  return {content.mesh.vertices.size(), content.mesh.indices.size() / 3, fs::file_size(file),
          stopwatch.seconds()};
}

}  // namespace lamella::exporting
