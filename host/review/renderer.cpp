#include "review/renderer.h"

#include <algorithm>

#include "review/shader_sources.h"

namespace lamella::review {

namespace {

constexpr int kShadowSidePx = 640;
constexpr int kIrradianceSidePx = 640;
constexpr int kSamples = 4;

void draw_full_screen(const VertexArrayName& no_vertices) {
  glDisable(GL_DEPTH_TEST);
  glBindVertexArray(no_vertices.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace

Renderer::Renderer(const FaceMaps& face, const v1::Layers& layers)
    : face_(upload_face(face, layers)),
      shadow_("shadow", {kShadowVert}, {kEmptyFrag}),
      irradiance_("irradiance", {kFullScreenVert}, {kLightsGlsl, kIrradianceFrag}),
      diffuse_("diffuse", {kFullScreenVert}, {kDiffuseFrag}),
      shade_("shade", {kFullScreenVert}, {kLightsGlsl, kLobeGlsl, kShadeFrag}),
      face_program_("face", {kFaceVert}, {kFaceFrag}),
      compose_("compose", {kFullScreenVert}, {kComposeFrag}) {
  GLuint id = 0;
  glGenVertexArrays(1, &id);
  no_vertices_ = VertexArrayName(id);
  glGenFramebuffers(1, &id);
  shadow_framebuffer_ = FramebufferName(id);
  shadow_maps_ = make_texture({GL_TEXTURE_2D_ARRAY, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT},
                              {kShadowSidePx, kShadowSidePx, kMostLights}, nullptr);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);

  const cv::Size map = face.maps.position_mm.size();
  const double scale = std::min(1.0, double(kIrradianceSidePx) / std::max(map.width, map.height));
  const int width = int(map.width * scale), height = int(map.height * scale);
  arriving_ = make_target(width, height, GL_RGBA16F, false);
  half_blurred_ = make_target(width, height, GL_RGBA16F, false);
  for (Target& t : diffused_) t = make_target(width, height, GL_RGBA16F, false);
}

void Renderer::light(const Lighting& lighting) {
  lights_ = lights_of(lighting);
  draw_shadows(lights_);
  draw_irradiance();
  diffuse();
}

void Renderer::draw_shadows(const std::vector<DistantLight>& lights) {
  const float r = face_.radius_mm;
  shadow_from_rig_.clear();
  glBindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer_.id());
  glViewport(0, 0, kShadowSidePx, kShadowSidePx);
  glDrawBuffer(GL_NONE);
  glEnable(GL_DEPTH_TEST);
  for (size_t i = 0; i < lights.size(); ++i) {
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, shadow_maps_.name.id(), 0,
                              GLint(i));
    glClear(GL_DEPTH_BUFFER_BIT);
    const Vec3 eye = face_.centre_mm + lights[i].direction * (2.f * r);
    const cv::Matx44f clip =
        orthographic(1.02f * r, 0.5f * r, 3.5f * r) * look_at(eye, face_.centre_mm);
    shadow_.set("clip_from_rig", clip);
    draw_mesh(face_);
    const cv::Matx44f unit_cube(0.5f, 0, 0, 0.5f, 0, 0.5f, 0, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1);
    shadow_from_rig_.push_back(unit_cube * clip);
  }
}

void Renderer::set_lights(const Program& program) const {
  program.set("light_count", int(lights_.size()));
  for (size_t i = 0; i < lights_.size(); ++i) {
    const std::string index = "[" + std::to_string(i) + "]";
    program.set(("light_direction" + index).c_str(), lights_[i].direction);
    program.set(("light_colour" + index).c_str(), lights_[i].colour);
    program.set(("shadow_from_rig" + index).c_str(), shadow_from_rig_[i]);
  }
  program.set("shadow_taps", lights_.size() < 4 ? 4 : 1);
  program.set("shadow_texel_mm", 2.04f * face_.radius_mm / float(kShadowSidePx));
}

void Renderer::draw_irradiance() {
  draw_to(arriving_);
  set_lights(irradiance_);
  irradiance_.bind("shadows", 0, shadow_maps_);
  irradiance_.bind("position_mm", 1, face_.position_mm);
  irradiance_.bind("normal", 2, face_.normal);
  irradiance_.bind("inside_px", 3, face_.inside_px);
  draw_full_screen(no_vertices_);
}

void Renderer::diffuse() {
  const Target* source = &arriving_;
  float reached_mm = 0;
  for (size_t k = 0; k < diffused_.size(); ++k) {
    const float sigma = kGaussianSigmaMm[k];
    diffuse_.set("sigma_mm", std::sqrt(sigma * sigma - reached_mm * reached_mm));
    diffuse_.bind("position_mm", 1, face_.position_mm);
    diffuse_.set("axis", Vec2(1, 0));
    diffuse_.bind("source", 0, source->colour);
    draw_to(half_blurred_);
    draw_full_screen(no_vertices_);
    diffuse_.set("axis", Vec2(0, 1));
    diffuse_.bind("source", 0, half_blurred_.colour);
    draw_to(diffused_[k]);
    draw_full_screen(no_vertices_);
    source = &diffused_[k];
    reached_mm = sigma;
  }
}

void Renderer::fit_targets(cv::Size picture) {
  if (radiance_.width == picture.width && radiance_.height == picture.height) return;
  many_samples_ = make_target(picture.width, picture.height, GL_RGBA16F, true, kSamples);
  radiance_ = make_target(picture.width, picture.height, GL_RGBA16F, false);
  // About a texel a pixel: more would be filtered away, and costs a processor that stands in for a
  // graphics card.
  const Texture& map = face_.position_mm;
  const double scale = std::min(1.0, double(picture.height) / map.height);
  shaded_ = make_target(int(map.width * scale), int(map.height * scale), GL_RGBA16F, false);
  glBindTexture(GL_TEXTURE_2D, shaded_.colour.name.id());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
}

void Renderer::shade(const Look& look) {
  const Program& p = shade_;
  set_lights(p);
  p.set("eye_mm", look.orbit.eye_mm());
  p.set("g", face_.g);
  p.set("gains",
        cv::Vec4f(look.gains.specular, look.gains.single, look.gains.shallow, look.gains.deep));
  p.set("largest_ld_mm", kLargestLdMm);
  p.set("region_count", face_.region_count);
  const std::pair<const char*, const Texture*> textures[] = {
      {"shadows", &shadow_maps_},
      {"position_mm", &face_.position_mm},
      {"normal", &face_.normal},
      {"inside_px", &face_.inside_px},
      {"single_specular", &face_.single_specular},
      {"shallow_albedo", &face_.shallow_albedo},
      {"deep_albedo", &face_.deep_albedo},
      {"deep_ld_mm", &face_.deep_ld_mm},
      {"diffused0", &diffused_[0].colour},
      {"diffused1", &diffused_[1].colour},
      {"diffused2", &diffused_[2].colour},
      {"diffused3", &diffused_[3].colour},
      {"kernel_weights", &face_.kernel_weights},
      {"lobes", &face_.lobes},
      {"transmittance", &face_.transmittance},
      {"region_weights", &face_.region_weights},
  };
  int unit = 0;
  for (const auto& [name, texture] : textures) p.bind(name, unit++, *texture);
  draw_to(shaded_);
  draw_full_screen(no_vertices_);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, shaded_.colour.name.id());
  glGenerateMipmap(GL_TEXTURE_2D);
}

void Renderer::draw_face(const Look& look) {
  draw_to(many_samples_);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  const LayerGains& g = look.gains;
  const bool is_shown = look.plain_map || g.specular + g.single + g.shallow + g.deep > 0.f;
  glEnable(GL_DEPTH_TEST);
  const float aspect = float(many_samples_.width) / float(many_samples_.height);
  face_program_.set("clip_from_rig", look.orbit.clip_from_rig(aspect));
  face_program_.bind("shaded", 0, look.plain_map ? *look.plain_map : shaded_.colour);
  if (is_shown) draw_mesh(face_);
  resolve(many_samples_, radiance_);
}

cv::Mat4f Renderer::radiance(const Look& look, cv::Size size) {
  fit_targets(size);
  if (!look.plain_map) shade(look);
  draw_face(look);
  cv::Mat4f rgba(size);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, radiance_.framebuffer.id());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, size.width, size.height, GL_RGBA, GL_FLOAT, rgba.data);
  cv::flip(rgba, rgba, 0);  // OpenGL's rows go up
  return rgba;
}

void Renderer::draw(const Look& look, const Target& target) {
  fit_targets({target.width, target.height});
  if (!look.plain_map) shade(look);
  draw_face(look);
  draw_to(target);
  compose_.set("exposure", look.exposure);
  compose_.set("vignette", look.vignette);
  compose_.bind("radiance", 0, radiance_.colour);
  draw_full_screen(no_vertices_);
}

Orbit orbit_before(const FaceGpu& face, float aspect, float share) {
  Orbit orbit;
  orbit.target_mm = face.centre_mm;
  orbit.azimuth_rad = face.azimuth_rad;
  const float half = std::max(face.height_mm, face.width_mm / aspect) / (2.f * share);
  orbit.distance_mm = half / std::tan(orbit.field_rad / 2) + face.radius_mm * 0.6f;
  return orbit;
}

}  // namespace lamella::review
