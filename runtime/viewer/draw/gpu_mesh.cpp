#include "runtime/viewer/draw/gpu_mesh.h"

#include <vector>

namespace tremolo {
namespace {

std::span<const float> numbers_in(const std::vector<Eigen::Vector3f>& vectors) {
  return {vectors.empty() ? nullptr : vectors.front().data(), 3 * vectors.size()};
}

}  // namespace

GpuMesh::GpuMesh(std::span<const std::uint32_t> triangles, std::span<const float> rest)
    : array_(GlHandle::make(GlKind::kVertexArray)), triangles_(triangles.size() / 3) {
  glBindVertexArray(array_.name());
  indices_ = GlHandle::make(GlKind::kBuffer);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(triangles.size_bytes()),
               triangles.data(), GL_STATIC_DRAW);
  attribute(2, rest_, 3, rest, GL_STATIC_DRAW);
}

GpuMesh::GpuMesh(const TriangleShape& shape)
    : GpuMesh(shape.triangles, numbers_in(shape.positions)) {
  move(numbers_in(shape.positions), numbers_in(shape.normals));
}

void GpuMesh::attribute(GLuint location, GlHandle& buffer, int numbers,
                        std::span<const float> values, GLenum use) {
  glBindVertexArray(array_.name());
  const bool fresh = buffer.name() == 0;
  if (fresh) buffer = GlHandle::make(GlKind::kBuffer);
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(values.size_bytes()), values.data(), use);
  if (!fresh) return;
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, numbers, GL_FLOAT, GL_FALSE, 0, nullptr);
}

void GpuMesh::move(std::span<const float> positions, std::span<const float> normals) {
  attribute(0, positions_, 3, positions, GL_STREAM_DRAW);
  attribute(1, normals_, 3, normals, GL_STREAM_DRAW);
}

void GpuMesh::paint(std::span<const float> colours) {
  attribute(3, colours_, 4, colours, GL_STATIC_DRAW);
}

void GpuMesh::unfold(std::span<const float> uvs) {
  attribute(4, uvs_, 2, uvs, GL_STATIC_DRAW);
}

void GpuMesh::draw() const {
  draw(0, triangles_);
}

void GpuMesh::draw(std::size_t first, std::size_t count) const {
  if (array_.name() == 0 || count == 0) return;
  glBindVertexArray(array_.name());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * count), GL_UNSIGNED_INT,
                 // OpenGL takes the offset into the bound buffer as a pointer.
                 reinterpret_cast<const void*>(12 * first));
}

}  // namespace tremolo
