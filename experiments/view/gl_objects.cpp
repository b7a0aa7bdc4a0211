#include "experiments/view/gl_objects.hpp"

#include <stdexcept>
#include <string>

namespace mss::view {

namespace {

GlObject compile(GLenum kind, const char* source) {
  GlObject shader(glCreateShader(kind), [](GLuint name) { glDeleteShader(name); });
  glShaderSource(shader.name(), 1, &source, nullptr);
  glCompileShader(shader.name());
  GLint compiled = 0;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
  if (compiled != 0) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader.name(), GLsizei(log.size()), &length, log.data());
  log.resize(std::size_t(length));
  throw std::runtime_error("a shader does not compile: " + log);
}

template <class Make>
GLuint made(Make make) {
  GLuint name = 0;
  make(1, &name);
  return name;
}

}  // namespace

GlObject make_buffer() {
  return {made(glGenBuffers), [](GLuint name) { glDeleteBuffers(1, &name); }};
}
GlObject make_vertex_array() {
  return {made(glGenVertexArrays), [](GLuint name) { glDeleteVertexArrays(1, &name); }};
}
GlObject make_texture() {
  return {made(glGenTextures), [](GLuint name) { glDeleteTextures(1, &name); }};
}
GlObject make_framebuffer() {
  return {made(glGenFramebuffers), [](GLuint name) { glDeleteFramebuffers(1, &name); }};
}
GlObject make_renderbuffer() {
  return {made(glGenRenderbuffers), [](GLuint name) { glDeleteRenderbuffers(1, &name); }};
}

GlObject make_program(const char* vertex_shader, const char* fragment_shader) {
  const GlObject vertex = compile(GL_VERTEX_SHADER, vertex_shader);
  const GlObject fragment = compile(GL_FRAGMENT_SHADER, fragment_shader);
  GlObject program(glCreateProgram(), [](GLuint name) { glDeleteProgram(name); });
  glAttachShader(program.name(), vertex.name());
  glAttachShader(program.name(), fragment.name());
  glLinkProgram(program.name());
  GLint linked = 0;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
  if (linked == 0) throw std::runtime_error("a program of shaders does not link");
  return program;
}

}  // namespace mss::view
