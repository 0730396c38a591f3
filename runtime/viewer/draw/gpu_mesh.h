// Triangles in the graphics card's memory.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "runtime/viewer/draw/gl_handle.h"
#include "runtime/viewer/shape/triangle_shape.h"

namespace tremolo {

// A context must be current in every call, the same one.
class GpuMesh {
 public:
  GpuMesh() = default;
  // triangles: three indices each. rest: positions of the vertices at rest, x y z ..., m;
  // Paint::kMoved shows the distance from them.
  GpuMesh(std::span<const std::uint32_t> triangles, std::span<const float> rest);
  explicit GpuMesh(const TriangleShape& shape);

  // positions: of all vertices now, x y z ..., m; normals: their unit normals.
  void move(std::span<const float> positions, std::span<const float> normals);
  // colours: r g b a of each vertex, linear light. uvs: u v of each vertex.
  void paint(std::span<const float> colours);
  void unfold(std::span<const float> uvs);

  void draw() const;
  // Draws a part of the triangles; first and count in triangles.
  void draw(std::size_t first, std::size_t count) const;
  std::size_t triangles() const { return triangles_; }

 private:
  void attribute(GLuint location, GlHandle& buffer, int numbers, std::span<const float> values,
                 GLenum use);

  GlHandle array_, indices_, positions_, normals_, rest_, colours_, uvs_;
  std::size_t triangles_ = 0;
};

}  // namespace tremolo
