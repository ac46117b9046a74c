#include "review/gl_objects.h"

#include <vector>

#include "base/error.h"

namespace lamella::review {

void delete_texture(GLuint id) { glDeleteTextures(1, &id); }
void delete_framebuffer(GLuint id) { glDeleteFramebuffers(1, &id); }
void delete_buffer(GLuint id) { glDeleteBuffers(1, &id); }
void delete_vertex_array(GLuint id) { glDeleteVertexArrays(1, &id); }
void delete_program(GLuint id) { glDeleteProgram(id); }

namespace {

GLuint new_texture() {
  GLuint id = 0;
  glGenTextures(1, &id);
  return id;
}

bool is_array_1d(GLenum target) { return target == GL_TEXTURE_1D_ARRAY; }

GLuint compiled(const char* name, GLenum stage, const std::initializer_list<const char*>& pieces) {
  std::vector<const char*> text{"#version 330 core\n"};
  text.insert(text.end(), pieces.begin(), pieces.end());
  const GLuint shader = glCreateShader(stage);
  glShaderSource(shader, GLsizei(text.size()), text.data(), nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (!ok) {
    char log[400] = {};
    glGetShaderInfoLog(shader, sizeof(log), nullptr, log);
    throw_bad_input(std::string("OpenGL shader ") + name, log, "update the graphics driver");
  }
  return shader;
}

}  // namespace

Texture make_texture(const TextureFormat& format, const cv::Vec3i& size, const void* pixels) {
  Texture texture{TextureName(new_texture()), format.target, size[0], size[1]};
  const GLenum target = format.target;
  glBindTexture(target, texture.name.id());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (target == GL_TEXTURE_2D_ARRAY) {
    glTexImage3D(target, 0, format.internal, size[0], size[1], size[2], 0, format.channels,
                 format.type, pixels);
  } else {
    glTexImage2D(target, 0, format.internal, size[0], size[1], 0, format.channels, format.type,
                 pixels);
  }
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  if (!is_array_1d(target)) glTexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

namespace {

Texture with_mipmaps(Texture texture) {
  glGenerateMipmap(texture.target);
  glTexParameteri(texture.target, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  return texture;
}

}  // namespace

Texture map_texture(const Image3& map) {
  const Image3 whole = map.isContinuous() ? map : Image3(map.clone());
  return with_mipmaps(
      make_texture({GL_TEXTURE_2D, GL_RGB32F, GL_RGB}, {whole.cols, whole.rows, 1}, whole.data));
}

Texture map_texture(const Image1& map) {
  const Image1 whole = map.isContinuous() ? map : Image1(map.clone());
  return with_mipmaps(
      make_texture({GL_TEXTURE_2D, GL_R32F, GL_RED}, {whole.cols, whole.rows, 1}, whole.data));
}

Texture picture_texture(const cv::Mat3b& bgr) {
  const cv::Mat3b whole = bgr.isContinuous() ? bgr : cv::Mat3b(bgr.clone());
  return with_mipmaps(make_texture({GL_TEXTURE_2D, GL_RGB8, GL_BGR, GL_UNSIGNED_BYTE},
                                   {whole.cols, whole.rows, 1}, whole.data));
}

Program::Program(const char* name, std::initializer_list<const char*> vertex,
                 std::initializer_list<const char*> fragment)
    : name_(glCreateProgram()) {
  const GLuint shaders[] = {compiled(name, GL_VERTEX_SHADER, vertex),
                            compiled(name, GL_FRAGMENT_SHADER, fragment)};
  for (GLuint s : shaders) glAttachShader(name_.id(), s);
  glLinkProgram(name_.id());
  for (GLuint s : shaders) glDeleteShader(s);
  GLint ok = 0;
  glGetProgramiv(name_.id(), GL_LINK_STATUS, &ok);
  if (!ok) {
    char log[400] = {};
    glGetProgramInfoLog(name_.id(), sizeof(log), nullptr, log);
    throw_bad_input(std::string("OpenGL program ") + name, log, "update the graphics driver");
  }
}

void Program::set(const char* uniform, int value) const {
  use();
  glUniform1i(at(uniform), value);
}

void Program::set(const char* uniform, float value) const {
  use();
  glUniform1f(at(uniform), value);
}

void Program::set(const char* uniform, Vec2 value) const {
  use();
  glUniform2fv(at(uniform), 1, value.val);
}

void Program::set(const char* uniform, const Vec3& value) const {
  use();
  glUniform3fv(at(uniform), 1, value.val);
}

void Program::set(const char* uniform, const cv::Vec4f& value) const {
  use();
  glUniform4fv(at(uniform), 1, value.val);
}

void Program::set(const char* uniform, const cv::Matx44f& row_major) const {
  use();
  glUniformMatrix4fv(at(uniform), 1, GL_TRUE, row_major.val);
}

void Program::bind(const char* sampler, int unit, const Texture& texture) const {
  set(sampler, unit);
  glActiveTexture(GLenum(GL_TEXTURE0 + unit));
  glBindTexture(texture.target, texture.name.id());
}

Target make_target(int width, int height, GLint internal_format, bool with_depth, int samples) {
  Target t;
  t.width = width;
  t.height = height;
  GLuint id = 0;
  glGenFramebuffers(1, &id);
  t.framebuffer = FramebufferName(id);
  glBindFramebuffer(GL_FRAMEBUFFER, id);
  const GLenum target = samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
  if (samples > 1) {
    t.colour = {TextureName(new_texture()), target, width, height};
    glBindTexture(target, t.colour.name.id());
    glTexImage2DMultisample(target, samples, GLenum(internal_format), width, height, GL_TRUE);
  } else {
    t.colour = make_texture({target, internal_format, GL_RGBA}, {width, height, 1}, nullptr);
  }
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, target, t.colour.name.id(), 0);
  if (with_depth) {
    t.depth = TextureName(new_texture());
    glBindTexture(target, t.depth.id());
    if (samples > 1) {
      glTexImage2DMultisample(target, samples, GL_DEPTH_COMPONENT24, width, height, GL_TRUE);
    } else {
      glTexImage2D(target, 0, GL_DEPTH_COMPONENT24, width, height, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                   nullptr);
    }
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, target, t.depth.id(), 0);
  }
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw_bad_input("OpenGL", "cannot draw to a picture of floats", "update the graphics driver");
  }
  return t;
}

void draw_to(const Target& target) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.id());
  glViewport(0, 0, target.width, target.height);
}

void resolve(const Target& from, const Target& to) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, from.framebuffer.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to.framebuffer.id());
  glBlitFramebuffer(0, 0, from.width, from.height, 0, 0, to.width, to.height, GL_COLOR_BUFFER_BIT,
                    GL_NEAREST);
}

}  // namespace lamella::review
