// A tetrahedral mesh with its materials, prepared for corotated elements of degree two: the
// constant data shared by all bodies of one kind.
//
// Control points are the mesh's vertices in their order, then one for each edge in the order of
// mesh_edges(): x_ab. The midpoint of the edge is at (x_a + 2 x_ab + x_b) / 4. Elements are
// straight at rest. An edge is quadratic, with a free control point, or linear, with its control
// point at the mean of its ends. Both kinds use one pattern of 3 x 3 blocks, that of the fully
// quadratic mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/elements/elasticity.h"
#include "common/mesh/edge_points.h"
#include "common/result.h"
#include "runtime/bodies/tets/elements/float_blocks.h"
#include "runtime/bodies/tets/elements/tet_element.h"
#include "runtime/math/kernels/lanes.h"
#include "runtime/math/sparse/block_matrix.h"

namespace tremolo {

inline constexpr std::size_t kLinearBlocks = 10;  // node_block() of four nodes

// An element of the model.
struct TetModelElement {
  TetElement element;
  std::uint32_t material = 0;
  // Control points, corners first, edges as kTetEdges.
  std::array<std::uint32_t, kMostNodes> nodes{};
  std::array<BlockPlace, kMostBlocks> places{};
  NodeBlocks stiffness;                                         // the blocks of K for degree two
  std::array<Eigen::Matrix3d, kLinearBlocks> linear_stiffness;  // for degree one
};

struct SmoothSpace;  // smooth_modes.h

class TetModel {
 public:
  // mesh: linear, or quadratic with straight edges; it has passed check_mesh. held: fixed vertices,
  // and with them the edges between them, in any order. Errors (kContent): no tetrahedron; an
  // element whose volume is not above zero, by its number; a fixed vertex that does not exist; a
  // material that check_material refuses.
  static Result<std::shared_ptr<const TetModel>> create(TetMesh mesh,
                                                        const MaterialTable& materials,
                                                        std::span<const VertexId> held);

  const TetMesh& mesh() const { return mesh_; }  // quadratic
  std::size_t vertices() const { return vertices_; }
  std::size_t edges() const { return mesh_.edges.size(); }
  std::size_t nodes() const { return mesh_.vertices.size(); }  // vertices and edges
  // The ends of an edge, whose control point is vertices() + edge.
  const MeshEdge& edge(std::size_t index) const { return mesh_.edges[index]; }
  double edge_length(std::size_t index) const { return lengths_[index]; }  // m, at rest

  std::span<const TetModelElement> elements() const { return elements_; }
  const Elasticity& elasticity(const TetModelElement& element) const {
    return elasticities_[element.material];
  }
  // K of an element in single precision (float_blocks.h).
  const float* float_stiffness(std::size_t element) const {
    return float_stiffness_.data() + kFloatStiffness * element;
  }
  const BlockPatternPointer& pattern() const { return pattern_; }
  // rho times the integral of B_I B_J for each block of the pattern, kg.
  std::span<const double> masses() const { return masses_; }
  std::span<const std::uint8_t> held() const { return held_; }  // one flag per control point
  double mass() const { return mass_; }                         // kg
  const Eigen::VectorXd& rest() const { return rest_; }         // 3 nodes(), m
  BoundingBox rest_box() const { return box_; }
  const std::shared_ptr<const SmoothSpace>& smooth() const { return smooth_; }
  // The memory of elements and matrices, and that of one element, bytes.
  std::size_t bytes() const;
  static constexpr std::size_t bytes_per_element() {
    return sizeof(TetModelElement) + kFloatStiffness * sizeof(float);
  }

  // y = M x of the fully quadratic mesh; both 3 nodes() long, not the same vector.
  void mass_times(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;

 private:
  Status make_elements(const MaterialTable& materials);
  Status make_pattern();
  void add_masses(const TetModelElement& element);

  TetMesh mesh_;
  std::size_t vertices_ = 0;
  std::vector<double> lengths_;
  std::vector<Elasticity> elasticities_;
  std::vector<TetModelElement> elements_;
  AlignedFloats float_stiffness_;
  BlockPatternPointer pattern_;
  std::vector<double> masses_;
  std::vector<std::uint8_t> held_;
  double mass_ = 0.0;
  Eigen::VectorXd rest_;
  BoundingBox box_;
  std::shared_ptr<const SmoothSpace> smooth_;
};

using TetModelPointer = std::shared_ptr<const TetModel>;

}  // namespace tremolo
