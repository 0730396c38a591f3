// Intersection of a ray with a deformed surface: a tree of boxes over the rest surface, each of
// which follows the coordinates without reading its vertices.
//
// A node's vertices are at X + U q. With c, 3 x r, in the middle of their rows of U,
//
//     |(U - c) q| <= sum_i |q_i| e_i,   e_i the longest of |U_i - c_i| among them,
//
// so that the rest box, moved by c q and widened by that sum, contains the deformed vertices, at a
// cost of 4r products. Only nodes that the ray enters are visited, and only their triangles are
// evaluated.
//
// Points on several bones are elsewhere: for such a surface every triangle is tested.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// The drawn surface (Model::drawn) or the solid's boundary (Model::surface).
enum class SurfaceKind { kDrawn, kBoundary };

// A point of a surface: in a triangle, the mean of the corners with weights that sum to one.
struct SurfacePlace {
  SurfaceKind surface = SurfaceKind::kDrawn;
  std::size_t triangle = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::UnitX();
};

// A point hit by a ray.
struct SurfaceHit {
  SurfacePlace place;
  VertexId vertex =
      0;  // of the mesh: at, or for a render surface near, the corner of largest weight
  double distance = 0.0;                            // from the ray's origin, m
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // m, world
};

class SurfaceTree {
 public:
  // All arguments must outlive this object unchanged. rows: of U, 3 per vertex. For a closed
  // surface with many triangles the tree takes about a fifth of the memory of `rows`; the time is
  // proportional to it.
  SurfaceTree(const std::vector<Eigen::Vector3d>& rest, const BasisRows& rows,
              const std::vector<Triangle>& triangles);

  struct Hit {
    std::size_t triangle = 0;
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
    double distance = 0.0;
  };
  // The nearest hit, from either side; nullopt if there is none. Of triangles at equal distance,
  // any one. origin, direction: along the surface's axes, the latter of unit length; q: r. Values
  // that are not finite hit nothing. Allocates nothing for r up to kMostModes; may be called from
  // several threads.
  std::optional<Hit> nearest(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                             const Eigen::VectorXd& q) const;
  static constexpr std::size_t kMostModes = 256;

  std::size_t nodes() const { return nodes_.size(); }

  // The hit of one triangle if it is nearer than `most`, in the same form as nearest().
  std::optional<Hit> meet(std::size_t triangle, const Eigen::Vector3d& origin,
                          const Eigen::Vector3d& direction, const Eigen::VectorXd& q,
                          double most) const;

 private:
  static constexpr std::size_t kLeaf = 8;  // triangles at most

  // count: number of triangles of a leaf, from `first` on; 0: the children are the next node and
  // `first`.
  struct Node {
    std::array<float, 3> low, high;  // of the rest shape, rounded outwards
    std::uint32_t first = 0, count = 0;
  };
  struct Box {
    Eigen::Vector3d low, high;
  };

  std::size_t build(std::size_t first, std::size_t count);
  void bound_leaf(std::size_t node);
  void bound_parent(std::size_t node, std::size_t left, std::size_t right);
  void round_up(std::size_t node, const Eigen::VectorXd& spread);
  Box bent_box(std::size_t node, const float* q, const float* size) const;
  float* bounds(std::size_t node) { return bounds_.data() + node * 4 * modes_; }
  const float* bounds(std::size_t node) const { return bounds_.data() + node * 4 * modes_; }

  const std::vector<Eigen::Vector3d>& rest_;
  const BasisRows& rows_;
  const std::vector<Triangle>& triangles_;
  std::size_t modes_;
  std::vector<Node> nodes_;               // the root first
  std::vector<std::uint32_t> order_;      // triangles, those of a leaf side by side
  std::vector<Eigen::Vector3d> middles_;  // of triangles, while the tree is built
  std::vector<float> bounds_;             // a node: the three rows of c, then e; r each
};

// SurfaceTree::nearest() for a surface that no coordinates describe: places are the positions of
// its vertices, x y z x y z ..., m. Tests every triangle and allocates nothing.
std::optional<SurfaceTree::Hit> nearest_of_all(const std::vector<Triangle>& triangles,
                                               std::span<const double> places,
                                               const Eigen::Vector3d& origin,
                                               const Eigen::Vector3d& direction);

}  // namespace tremolo
