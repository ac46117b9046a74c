// The lit face, pass by pass: shadows of every light, light that arrives on the skin, its diffusion
// over the surface, the four layers, and the picture.
#pragma once

#include "review/face_gpu.h"
#include "review/lighting.h"
#include "review/orbit.h"

namespace lamella::review {

// Which layers are shown, and how bright each is made.
struct LayerGains {
  float specular = 1, single = 1, shallow = 1, deep = 1;
};

struct Look {
  Orbit orbit;
  LayerGains gains;
  float exposure = 1;
  float vignette = 1;
  const Texture* plain_map = nullptr;  // shown on the face instead of light
};

class Renderer {
 public:
  // Needs a current context of OpenGL 3.3.
  Renderer(const FaceMaps& face, const v1::Layers& layers);

  const FaceGpu& face() const { return face_; }

  // Shadows, irradiance and diffusion: once for each lighting, whatever the camera does.
  void light(const Lighting& lighting);

  // Linear radiance, as `render` has it, times coverage; in [3] the coverage, 0 to 1. Before any
  // exposure.
  cv::Mat4f radiance(const Look& look, cv::Size size);

  // Draws into `target` (eight bits, sRGB-encoded).
  void draw(const Look& look, const Target& target);

 private:
  void draw_shadows(const std::vector<DistantLight>& lights);
  void draw_irradiance();
  void diffuse();
  void shade(const Look& look);
  void draw_face(const Look& look);
  void set_lights(const Program& program) const;
  void fit_targets(cv::Size picture);

  FaceGpu face_;
  Program shadow_, irradiance_, diffuse_, shade_, face_program_, compose_;
  VertexArrayName no_vertices_;
  FramebufferName shadow_framebuffer_;
  Texture shadow_maps_;
  std::vector<DistantLight> lights_;
  std::vector<cv::Matx44f> shadow_from_rig_;
  Target arriving_, half_blurred_;
  std::array<Target, 4> diffused_;
  Target shaded_, many_samples_, radiance_;
};

// A camera before the side of the face that was photographed, which fills `share` of the height or
// width.
Orbit orbit_before(const FaceGpu& face, float aspect, float share);

}  // namespace lamella::review
