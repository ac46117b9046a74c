#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>

#include "review/panels.h"
#include "review/review.h"
#include "review/window.h"

namespace lamella::review {

namespace {

constexpr float kTextPx = 16.f;
constexpr float kRadPerPixel = 0.006f;

// Left button: the camera; right button: the key light; wheel: nearer and further.
void follow_mouse(const FaceGpu& face, Look* look, LightState* light) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantCaptureMouse) return;
  Orbit& o = look->orbit;
  if (ImGui::IsMouseDragging(ImGuiMouseButton_Left, 0.f)) {
    o.azimuth_rad -= kRadPerPixel * io.MouseDelta.x;
    o.elevation_rad = std::clamp(o.elevation_rad + kRadPerPixel * io.MouseDelta.y, -1.4f, 1.4f);
  }
  const bool is_moved = io.MouseDelta.x != 0 || io.MouseDelta.y != 0;
  if (ImGui::IsMouseDragging(ImGuiMouseButton_Right, 0.f) && is_moved) {
    light->turn_key(kRadPerPixel * io.MouseDelta.x, -kRadPerPixel * io.MouseDelta.y);
  }
  o.distance_mm = std::clamp(o.distance_mm * std::exp(-0.1f * io.MouseWheel), 1.2f * face.radius_mm,
                             20.f * face.radius_mm);
}

// 1 to 4 switch specular, single, shallow and deep.
void follow_keys(LayerGains* gains) {
  if (ImGui::GetIO().WantCaptureKeyboard) return;
  float* const layer[] = {&gains->specular, &gains->single, &gains->shallow, &gains->deep};
  for (int i = 0; i < 4; ++i) {
    if (ImGui::IsKeyPressed(GLFW_KEY_1 + i, false)) *layer[i] = *layer[i] > 0 ? 0.f : 1.f;
  }
}

void present(const Target& picture, GLFWwindow* window) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, picture.framebuffer.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glBlitFramebuffer(0, 0, picture.width, picture.height, 0, 0, width, height, GL_COLOR_BUFFER_BIT,
                    GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, width, height);
}

Look first_look(const ReviewRequest& request, const FaceGpu& face) {
  Look look;
  look.orbit = orbit_before(face, float(request.size.width) / float(request.size.height), 0.85f);
  look.orbit.azimuth_rad += request.azimuth_rad;
  look.orbit.elevation_rad = request.elevation_rad;
  look.gains = request.gains;
  look.exposure = request.exposure;
  return look;
}

}  // namespace

void show_window(const ReviewRequest& request) {
  const FaceMaps face = face_from_maps(request.maps, request.fit.string());
  const Window window("lamella: " + request.subject, request.size.width, request.size.height, true,
                      kTextPx);
  Renderer renderer(face, request.layers);
  Panels panels(request, face);
  Look look = first_look(request, renderer.face());
  LightState light{request.lighting, true};
  Target picture;
  while (!glfwWindowShouldClose(window.glfw())) {
    glfwWaitEventsTimeout(0.05);  // idle when nobody moves anything
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    follow_mouse(renderer.face(), &look, &light);
    follow_keys(&look.gains);
    panels.draw(&look, &light);
    ImGui::Render();

    if (std::exchange(light.is_changed, false)) renderer.light(light.lighting);
    int width = 0, height = 0;
    glfwGetFramebufferSize(window.glfw(), &width, &height);
    if (width == 0 || height == 0) continue;  // minimised
    if (picture.width != width || picture.height != height) {
      picture = make_target(width, height, GL_RGBA8, false);
    }
    renderer.draw(look, picture);
    present(picture, window.glfw());
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(window.glfw());
  }
}

}  // namespace lamella::review
