// A surface of triangles with sharp edges (common/mesh/creases.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/creases.h"
#include "common/mesh/tet_mesh.h"
#include "runtime/apps/view/shape/collider_shape.h"

namespace tremolo {

// The surface with sharp edges; its first vertices are the given ones. A vertex has the mean
// normal, by area, of its triangles. rest: vertices, m.
TriangleShape creased_shape(const std::vector<Eigen::Vector3d>& rest,
                            std::span<const Triangle> triangles);

// A surface that deforms. Edges that are sharp at rest are drawn sharp: both sides have vertices
// and normals of their own.
class CreasedSheet {
 public:
  CreasedSheet() = default;
  // group_of: as for split_at_creases().
  CreasedSheet(const std::vector<Eigen::Vector3d>& rest, std::span<const Triangle> triangles,
               std::span<const std::uint32_t> group_of = {});
  // A surface whose author made the normals: no edge is sharp but where vertices are split already.
  static CreasedSheet as_given(std::size_t vertices, std::span<const Triangle> triangles);

  // Its own vertices, of which the given ones are the first, and its triangles, in the given order.
  std::size_t vertices() const { return made_.vertex_of.size(); }
  const std::vector<Triangle>& triangles() const { return made_.triangles; }

  // Values of the given vertices, `numbers` each, for its own.
  std::vector<float> spread(std::span<const float> values, std::size_t numbers) const;
  // positions, m, and normals of the given vertices, x y z ... A vertex at a sharp edge has the
  // mean normal, by area, of the triangles on its side; the others keep theirs.
  void pose(std::span<const float> positions, std::span<const float> normals);
  const std::vector<float>& positions() const { return positions_; }
  const std::vector<float>& normals() const { return normals_; }

 private:
  CreasedSurface made_;
  std::vector<Triangle> at_edges_;          // the triangles with a vertex at a sharp edge
  std::vector<Eigen::Vector3f> normal_of_;  // of each side
  std::vector<float> positions_, normals_;
};

}  // namespace tremolo
