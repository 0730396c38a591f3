// Where a ray meets a surface that has bent: a tree of boxes over the rest surface, each of which
// follows the coordinates without looking at its vertices.
//
// A node's vertices are at X + U q. With c, 3 x r, in the middle of their rows of U,
//
//     |(U - c) q| <= sum_i |q_i| e_i,   e_i the longest of |U_i - c_i| among them,
//
// so that the rest box, moved by c q and widened by that sum, holds them all: bent or not, in 4r
// products. Only nodes that the ray enters are looked at, and only their triangles are evaluated.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "formats/basis/basis_data.h"

namespace tremolo {

// What is drawn (Model::drawn), or the solid's boundary (Model::surface).
enum class SurfaceKind { kDrawn, kBoundary };

// In a triangle of a surface, at the mean of its corners by weights that sum to one.
struct SurfacePlace {
  SurfaceKind surface = SurfaceKind::kDrawn;
  std::size_t triangle = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::UnitX();
};

// vertex: of the mesh, the one to push, at (or, of a render surface, near) the corner that weighs
// most. distance: from the ray's origin, m. point: m, world.
struct SurfaceHit {
  SurfacePlace place;
  VertexId vertex = 0;
  double distance = 0.0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

class SurfaceTree {
 public:
  // All must live on and stay as they are. rows: of U, 3 a vertex. Takes about a fifth of the
  // memory of `rows` of a closed surface with many triangles, and time in proportion to it.
  SurfaceTree(const std::vector<Eigen::Vector3d>& rest, const BasisRows& rows,
              const std::vector<Triangle>& triangles);

  struct Hit {
    std::size_t triangle = 0;
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
    double distance = 0.0;
  };
  // The nearest, from either side; nullopt if there is none. Of triangles that are equally near,
  // one. origin, direction: along the surface's axes, the latter of length one; q: r. What is not
  // finite meets nothing. Nothing is allocated for r up to kMostModes; safe from several threads.
  std::optional<Hit> nearest(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                             const Eigen::VectorXd& q) const;
  static constexpr std::size_t kMostModes = 256;

  std::size_t nodes() const { return nodes_.size(); }

  // Whether the ray meets one triangle, and where, nearer than `most`: as nearest() finds it.
  std::optional<Hit> meet(std::size_t triangle, const Eigen::Vector3d& origin,
                          const Eigen::Vector3d& direction, const Eigen::VectorXd& q,
                          double most) const;

 private:
  static constexpr std::size_t kLeaf = 8;  // triangles at most

  // count: of triangles from `first` on, of a leaf; 0: the children are the next node and `first`.
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

}  // namespace tremolo
