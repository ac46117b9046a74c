#include "review/window.h"

#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "base/error.h"
#include "io/whole_file.h"

namespace lamella::review {

namespace {

// The first that is installed; without any, ImGui's own bitmap font.
constexpr const char* kFontFiles[] = {
    "/usr/share/fonts/truetype/open-sans/OpenSans-Regular.ttf",
    "/usr/share/fonts/truetype/lato/Lato-Regular.ttf",
    "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
};

Fonts load_fonts(float text_px) {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  // Latin, Greek (alpha, lambda) and the multiplication sign.
  static const ImWchar kRanges[] = {0x20, 0xff, 0x370, 0x3ff, 0x2010, 0x2030, 0};
  for (const char* file : kFontFiles) {
    if (!fs::exists(file)) continue;
    ImFontConfig config;
    config.OversampleH = config.OversampleV = 2;
    return {atlas.AddFontFromFileTTF(file, text_px, &config, kRanges),
            atlas.AddFontFromFileTTF(file, 1.5f * text_px, &config, kRanges)};
  }
  ImFont* font = atlas.AddFontDefault();
  return {font, font};
}

void style() {
  ImGui::StyleColorsDark();
  ImGuiStyle& s = ImGui::GetStyle();
  s.WindowRounding = s.FrameRounding = s.GrabRounding = 4.f;
  s.WindowBorderSize = 0.f;
  s.Colors[ImGuiCol_WindowBg] = ImVec4(0.075f, 0.077f, 0.082f, 0.94f);
  s.Colors[ImGuiCol_TitleBgActive] = ImVec4(0.12f, 0.12f, 0.13f, 1.f);
}

}  // namespace

Window::Window(const std::string& title, int width, int height, bool is_visible, float text_px) {
  if (!glfwInit()) {
    throw_bad_input("DISPLAY", "no window system answers",
                    "run on a desktop, or with --screenshot");
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_VISIBLE, is_visible ? GLFW_TRUE : GLFW_FALSE);
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window_) {
    glfwTerminate();
    throw_bad_input("OpenGL", "no context of version 3.3", "install Mesa (libgl1-mesa-dri)");
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind
  style();
  fonts_ = load_fonts(text_px);
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

}  // namespace lamella::review
