#include "experiments/view/renderer.hpp"

#include <cstddef>

namespace mss::view {

namespace {

constexpr int samples = 4;
constexpr int map_size = 256;
constexpr float point_size = 5;  // [pixels]
constexpr Colour panel_colour{0.97F, 0.975F, 0.98F}, sky_colour{0.92F, 0.935F, 0.95F};

// The light comes over the eye's left shoulder, and much of it from everywhere: shading shows the shape and
// leaves colours close to those of the bar. A little of it is reflected white, or dark colours would show no
// shape. Computed per vertex: where a processor draws, that is a few thousand times a frame instead of half a
// million.
constexpr const char* surface_vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float value;
layout(location = 3) in vec2 cells;
uniform mat4 view;
uniform mat4 projection;
uniform vec2 range;  // low, high
uniform float size;  // of the colour map
out vec3 place;      // on the colour map; light on the outside; light on the inside
out vec2 cell;
void main() {
  cell = cells;
  gl_Position = projection * view * vec4(position, 1);
  float share = clamp((value - range.x) / (range.y - range.x), 0.0, 1.0);
  float lit = dot(mat3(view) * normal, normalize(vec3(-0.4, 0.6, 0.7)));
  place = vec3(share * (size - 1.0) + 0.5, max(lit, 0.0), max(-lit, 0.0));
})";

// Back faces belong to a body turned inside out, and are grey.
// Edges of cells are where `cell` is near a whole number, within a pixel; where cells are hardly wider than
// that, there are none. Drawn as lines they would take a processor longer than the whole surface.
constexpr const char* surface_fragment_shader = R"(#version 330 core
in vec3 place;
in vec2 cell;
uniform sampler1D colours;
uniform float edges;  // how dark
out vec4 colour;
void main() {
  vec3 own = texelFetch(colours, int(place.x), 0).rgb;
  float lit = place.y;
  if (!gl_FrontFacing) {
    own = mix(own, vec3(0.35), 0.6);
    lit = place.z;
  }
  vec2 pixel = max(fwidth(cell), 1e-6);  // a true surface has none
  vec2 near = (1.0 - abs(fract(cell - 0.5) - 0.5) / pixel) * clamp(2.0 - 5.0 * pixel, 0.0, 1.0);
  float edge = edges * clamp(max(near.x, near.y), 0.0, 1.0);
  colour = vec4((own * (0.72 + 0.25 * lit) + 0.11 * lit) * (1.0 - edge), 1);
})";

constexpr const char* mark_vertex_shader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 colour;
uniform mat4 transform;
uniform float size;
out vec4 own;
void main() {
  gl_Position = transform * vec4(position, 1);
  gl_PointSize = size;
  own = colour;
})";

constexpr const char* mark_fragment_shader = R"(#version 330 core
in vec4 own;
uniform bool round;
out vec4 colour;
void main() {
  if (round && length(gl_PointCoord - 0.5) > 0.5) discard;
  colour = own;
})";

void wipe(const Colour& colour) {
  glClearColor(colour[0], colour[1], colour[2], 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

// NOLINTNEXTLINE(performance-no-int-to-ptr): OpenGL takes offsets as pointers
const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

template <class Item>
void fill(GLenum target, const GlObject& buffer, const std::vector<Item>& items, GLenum usage) {
  glBindBuffer(target, buffer.name());
  glBufferData(target, GLsizeiptr(items.size() * sizeof(Item)), items.data(), usage);
}

void attribute(GLuint location, int numbers, std::size_t stride, std::size_t at) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, numbers, GL_FLOAT, GL_FALSE, GLsizei(stride), offset(at));
}

void set(const GlObject& program, const char* uniform, const Eigen::Matrix4f& matrix) {
  glUniformMatrix4fv(glGetUniformLocation(program.name(), uniform), 1, GL_FALSE, matrix.data());
}

void make_colour_texture(const GlObject& texture) {
  std::vector<Colour> colours;
  colours.reserve(map_size);
  for (int i = 0; i < map_size; ++i) colours.push_back(map_colour(double(i) / (map_size - 1)));
  glBindTexture(GL_TEXTURE_1D, texture.name());
  glTexImage1D(GL_TEXTURE_1D, 0, GL_RGB8, map_size, 0, GL_RGB, GL_FLOAT, colours.data());
  glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_1D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
}

}  // namespace

Renderer::Renderer()
    : surface_program_(make_program(surface_vertex_shader, surface_fragment_shader)),
      mark_program_(make_program(mark_vertex_shader, mark_fragment_shader)),
      colours_(make_texture()),
      vertices_(make_buffer()),
      triangles_(make_buffer()),
      marks_(make_buffer()),
      surface_array_(make_vertex_array()),
      mark_array_(make_vertex_array()) {
  make_colour_texture(colours_);
  glBindVertexArray(surface_array_.name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles_.name());
  glBindVertexArray(mark_array_.name());
  glBindBuffer(GL_ARRAY_BUFFER, marks_.name());
  attribute(0, 3, sizeof(Mark), offsetof(Mark, position));
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(1, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(Mark), offset(offsetof(Mark, colour)));
  glBindVertexArray(0);
}

void Renderer::draw(const Picture& picture, const Camera& camera, const Viewport& view, int width,
                    int height) {
  const GLint left = GLint(view.x), bottom = GLint(height - view.y - view.height);
  const auto across = GLsizei(view.width), up = GLsizei(view.height);
  glViewport(0, 0, width, height);
  wipe(panel_colour);
  glEnable(GL_SCISSOR_TEST);
  glScissor(left, bottom, across, up);
  wipe(sky_colour);
  glDisable(GL_SCISSOR_TEST);
  glViewport(left, bottom, across, up);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glEnable(GL_PROGRAM_POINT_SIZE);
  const Eigen::Matrix4f to_eye = camera.view_matrix().cast<float>();
  const Eigen::Matrix4f projection = camera.projection(view).cast<float>();
  upload(picture);
  if (picture.surface) draw_surface(picture, to_eye, projection);
  draw_marks(picture, (camera.projection(view) * camera.view_matrix()).cast<float>());
  glBindVertexArray(0);
  glDisable(GL_DEPTH_TEST);
}

void Renderer::upload(const Picture& picture) {
  glBindVertexArray(surface_array_.name());
  if (picture.vertices == 0) {
    fill(GL_ARRAY_BUFFER, vertices_, picture.mesh.vertices(), GL_STREAM_DRAW);
  } else {
    glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);  // shaders have written them
    glBindBuffer(GL_ARRAY_BUFFER, picture.vertices);
  }
  attribute(0, 3, sizeof(SurfaceVertex), offsetof(SurfaceVertex, position));
  attribute(1, 3, sizeof(SurfaceVertex), offsetof(SurfaceVertex, normal));
  attribute(2, 1, sizeof(SurfaceVertex), offsetof(SurfaceVertex, value));
  attribute(3, 2, sizeof(SurfaceVertex), offsetof(SurfaceVertex, cells));
  if (uploaded_ == &picture.mesh) return;
  uploaded_ = &picture.mesh;
  fill(GL_ELEMENT_ARRAY_BUFFER, triangles_, picture.mesh.triangles(), GL_STATIC_DRAW);
}

void Renderer::draw_surface(const Picture& picture, const Eigen::Matrix4f& view,
                            const Eigen::Matrix4f& projection) {
  glUseProgram(surface_program_.name());
  set(surface_program_, "view", view);
  set(surface_program_, "projection", projection);
  glUniform2f(glGetUniformLocation(surface_program_.name(), "range"), float(picture.range.low),
              float(picture.range.high));
  glUniform1f(glGetUniformLocation(surface_program_.name(), "size"), map_size);
  glUniform1f(glGetUniformLocation(surface_program_.name(), "edges"), picture.edges ? 0.35F : 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_1D, colours_.name());
  glEnable(GL_POLYGON_OFFSET_FILL);  // lines on the surface stay in front of it
  glPolygonOffset(1, 1);
  glBindVertexArray(surface_array_.name());
  glDisable(GL_BLEND);
  glEnable(GL_CULL_FACE);
  for (const GLenum left_out : {GL_BACK, GL_FRONT}) {  // what the outside hides need not be shaded
    glCullFace(left_out);
    glDrawElements(GL_TRIANGLES, GLsizei(picture.mesh.triangles().size()), GL_UNSIGNED_INT, nullptr);
  }
  glDisable(GL_CULL_FACE);
  glEnable(GL_BLEND);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

void Renderer::draw_marks(const Picture& picture, const Eigen::Matrix4f& transform) {
  const GLuint program = mark_program_.name();
  glUseProgram(program);
  set(mark_program_, "transform", transform);
  glUniform1f(glGetUniformLocation(program, "size"), point_size);
  glUniform1i(glGetUniformLocation(program, "round"), 0);
  glBindVertexArray(mark_array_.name());
  glEnable(GL_POLYGON_OFFSET_FILL);  // lines along their edges stay in front of them
  glPolygonOffset(1, 1);
  fill(GL_ARRAY_BUFFER, marks_, picture.faces, GL_STREAM_DRAW);
  glDrawArrays(GL_TRIANGLES, 0, GLsizei(picture.faces.size()));
  glDisable(GL_POLYGON_OFFSET_FILL);
  fill(GL_ARRAY_BUFFER, marks_, picture.lines, GL_STREAM_DRAW);
  glDrawArrays(GL_LINES, 0, GLsizei(picture.lines.size()));
  glUniform1i(glGetUniformLocation(program, "round"), 1);
  fill(GL_ARRAY_BUFFER, marks_, picture.points, GL_STREAM_DRAW);
  glDrawArrays(GL_POINTS, 0, GLsizei(picture.points.size()));
}

Canvas::Canvas(int width, int height)
    : width_(width),
      height_(height),
      smooth_colour_(make_renderbuffer()),
      smooth_depth_(make_renderbuffer()),
      plain_colour_(make_renderbuffer()),
      smooth_(make_framebuffer()),
      plain_(make_framebuffer()) {
  const auto attach = [&](GLenum place, const GlObject& buffer, GLenum format, int per_pixel) {
    glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, per_pixel, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, place, GL_RENDERBUFFER, buffer.name());
  };
  glBindFramebuffer(GL_FRAMEBUFFER, plain_.name());
  attach(GL_COLOR_ATTACHMENT0, plain_colour_, GL_RGB8, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, smooth_.name());
  attach(GL_COLOR_ATTACHMENT0, smooth_colour_, GL_RGB8, samples);
  attach(GL_DEPTH_ATTACHMENT, smooth_depth_, GL_DEPTH_COMPONENT24, samples);
}

void Canvas::bind() const { glBindFramebuffer(GL_FRAMEBUFFER, smooth_.name()); }

std::vector<std::uint8_t> Canvas::read() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, smooth_.name());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, plain_.name());
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, plain_.name());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  const std::size_t row = 3 * std::size_t(width_);
  std::vector<std::uint8_t> pixels(row * std::size_t(height_));
  for (int y = 0; y < height_; ++y)  // OpenGL's rows go upward
    glReadPixels(0, height_ - 1 - y, width_, 1, GL_RGB, GL_UNSIGNED_BYTE,
                 pixels.data() + row * std::size_t(y));
  return pixels;
}

}  // namespace mss::view
