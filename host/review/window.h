// A GLFW window with an OpenGL 3.3 context and Dear ImGui, or the same without being seen.
#pragma once

#include <memory>
#include <string>

struct GLFWwindow;
struct ImFont;

namespace lamella::review {

struct Fonts {
  ImFont* text = nullptr;
  ImFont* title = nullptr;
};

class Window {
 public:
  // Throws Error where there is no display or no OpenGL 3.3. `text_px`: height of the text.
  Window(const std::string& title, int width, int height, bool is_visible, float text_px);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  GLFWwindow* glfw() const { return window_; }
  const Fonts& fonts() const { return fonts_; }

 private:
  GLFWwindow* window_ = nullptr;
  Fonts fonts_;
};

}  // namespace lamella::review
