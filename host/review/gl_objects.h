// OpenGL names with owners. All need a current context, to the last of them.
#pragma once

#include <epoxy/gl.h>

#include <initializer_list>
#include <string>
#include <utility>

#include "base/vec.h"

namespace lamella::review {

// A name that its owner deletes.
template <void (*Delete)(GLuint)>
class Name {
 public:
  Name() = default;
  explicit Name(GLuint id) : id_(id) {}
  ~Name() { reset(); }
  Name(Name&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Name& operator=(Name&& other) noexcept {
    reset();
    id_ = std::exchange(other.id_, 0);
    return *this;
  }
  GLuint id() const { return id_; }

 private:
  void reset() {
    if (id_ != 0) Delete(std::exchange(id_, 0));
  }
  GLuint id_ = 0;
};

void delete_texture(GLuint id);
void delete_framebuffer(GLuint id);
void delete_buffer(GLuint id);
void delete_vertex_array(GLuint id);
void delete_program(GLuint id);

using TextureName = Name<delete_texture>;
using FramebufferName = Name<delete_framebuffer>;
using BufferName = Name<delete_buffer>;
using VertexArrayName = Name<delete_vertex_array>;
using ProgramName = Name<delete_program>;

struct Texture {
  TextureName name;
  GLenum target = GL_TEXTURE_2D;
  int width = 0, height = 0;
};

struct TextureFormat {
  GLenum target;
  GLint internal;   // GL_RGB16F, ...
  GLenum channels;  // of the pixels given: GL_RGB, ...
  GLenum type = GL_FLOAT;
};

// `size`: width, height, depth; the target says how many of them count. `pixels` may be null.
// Linear filters, clamped to the edge.
Texture make_texture(const TextureFormat& format, const cv::Vec3i& size, const void* pixels);

// A map of floats, filtered linearly, with mipmaps.
Texture map_texture(const Image3& map);
Texture map_texture(const Image1& map);

// Eight bits a channel, in OpenCV's order b g r.
Texture picture_texture(const cv::Mat3b& bgr);

class Program {
 public:
  Program() = default;
  // The pieces are joined after a #version line. Throws Error with the compiler's words.
  Program(const char* name, std::initializer_list<const char*> vertex,
          std::initializer_list<const char*> fragment);

  void use() const { glUseProgram(name_.id()); }
  GLint at(const char* uniform) const { return glGetUniformLocation(name_.id(), uniform); }

  // Each makes the program current first.
  void set(const char* uniform, int value) const;
  void set(const char* uniform, float value) const;
  void set(const char* uniform, Vec2 value) const;
  void set(const char* uniform, const Vec3& value) const;
  void set(const char* uniform, const cv::Vec4f& value) const;
  void set(const char* uniform, const cv::Matx44f& row_major) const;
  void bind(const char* sampler, int unit, const Texture& texture) const;

 private:
  ProgramName name_;
};

// A colour target, with depth where asked for; `samples` over 1 is resolved by `resolve_to`.
struct Target {
  FramebufferName framebuffer;
  Texture colour;
  TextureName depth;
  int width = 0, height = 0;
};

Target make_target(int width, int height, GLint internal_format, bool with_depth, int samples = 1);

// Makes it the target of what is drawn next, its whole area.
void draw_to(const Target& target);

void resolve(const Target& from, const Target& to);

}  // namespace lamella::review
