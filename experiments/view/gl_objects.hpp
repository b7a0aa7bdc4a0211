#pragma once

// epoxy before any other header of OpenGL.
#include <epoxy/gl.h>

#include <utility>

namespace mss::view {

/// The name of an OpenGL object, which the destructor frees. Needs the context it was made in.
class GlObject {
 public:
  using Free = void (*)(GLuint name);

  GlObject() = default;
  GlObject(GLuint name, Free free) : name_(name), free_(free) {}
  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)), free_(other.free_) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    std::swap(free_, other.free_);
    return *this;
  }
  ~GlObject() {
    if (name_ != 0) free_(name_);
  }

  GLuint name() const { return name_; }

 private:
  GLuint name_ = 0;
  Free free_ = nullptr;
};

GlObject make_buffer();
GlObject make_vertex_array();
GlObject make_texture();
GlObject make_framebuffer();
GlObject make_renderbuffer();

/// A program of a vertex and a fragment shader (GLSL 3.30). Throws std::runtime_error with the compiler's
/// log.
GlObject make_program(const char* vertex_shader, const char* fragment_shader);

}  // namespace mss::view
