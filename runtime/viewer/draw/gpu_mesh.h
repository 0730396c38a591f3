// Triangles that lie with the graphics card.
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
  // triangles: three indices each. rest: where the vertices lie at rest, x y z ..., m; what is
  // drawn is by how much they have moved from there.
  GpuMesh(std::span<const std::uint32_t> triangles, std::span<const float> rest);
  explicit GpuMesh(const TriangleShape& shape);

  // Where the vertices are now and their unit normals, x y z ..., as many as at rest.
  void move(std::span<const float> positions, std::span<const float> normals);
  // One a vertex: r g b a, of which light is linear; u v.
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
