#pragma once

#include <string>

#include "experiments/view/camera.hpp"
#include "experiments/view/gl_objects.hpp"
#include "experiments/view/picture.hpp"

namespace mss::view {

/// What is to be drawn.
struct Picture {
  const DrawnSurface& mesh;
  unsigned vertices = 0;  ///< of the mesh, in a buffer of the context; 0: those that the mesh has
  ValueRange range{};     ///< of the mesh's values
  bool surface = true;
  bool edges = true;  ///< of cells, on their faces
  Marks faces{};      ///< three marks each
  Marks lines{};      ///< two marks each
  Marks points{};
};

/// Everything that OpenGL draws of a body; needs a current context of 3.3 or later.
class Renderer {
 public:
  /// Throws std::runtime_error if the shaders do not compile.
  Renderer();

  /// Draws on the current framebuffer, `height` pixels high; wipes all of it first.
  void draw(const Picture& picture, const Camera& camera, const Viewport& view, int width, int height);

 private:
  void upload(const Picture& picture);
  void draw_surface(const Picture& picture, const Eigen::Matrix4f& view, const Eigen::Matrix4f& projection);
  void draw_marks(const Picture& picture, const Eigen::Matrix4f& transform);

  GlObject surface_program_, mark_program_;
  GlObject colours_;  ///< the colour map, as a texture
  GlObject vertices_, triangles_, marks_;
  GlObject surface_array_, mark_array_;
  const DrawnSurface* uploaded_ = nullptr;  ///< its triangles are on the graphics card
};

/// A picture that no window shows.
class Canvas {
 public:
  Canvas(int width, int height);

  /// From now on drawing goes here.
  void bind() const;
  /// What was drawn: rows from top to bottom, red, green and blue of each pixel.
  std::vector<std::uint8_t> read() const;

 private:
  int width_, height_;
  GlObject smooth_colour_, smooth_depth_, plain_colour_;
  GlObject smooth_, plain_;  ///< four samples a pixel; one
};

}  // namespace mss::view
