#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "common/mesh/edge_points.h"
#include "common/packed_index.h"
#include "runtime/bodies/reduced/bones/bone_weights.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kMostMissing = 1e-3;  // of the integrals; a compact file misses 1e-4

// Weights of an element's mass by pairs of its nodes, of the nodal shape functions: l_a for order
// 1, l_a (2 l_a - 1) and 4 l_a l_b for order 2, whose integrals of products are these parts of 420.
double nodal_mass(int count, int i, int j) {
  if (count == 4) return i == j ? 0.1 : 0.05;
  const auto ends = [](int node) {
    return node < 4 ? std::array{node, node} : kTetEdges[node - 4];
  };
  const auto [a, b] = ends(i);
  const auto [c, d] = ends(j);
  const bool meet = a == c || a == d || b == c || b == d;
  if (i < 4 && j < 4) return (i == j ? 6.0 : 1.0) / 420.0;
  if (i < 4 || j < 4) return (meet ? -4.0 : -6.0) / 420.0;
  return (i == j ? 32.0 : meet ? 16.0 : 8.0) / 420.0;
}

// All vertices by the number of their row here: those of the surface, then the others.
class Vertices {
 public:
  explicit Vertices(const WeighedSolid& solid)
      : solid_(solid), first_inside_(std::ssize(solid.surface.vertex_ids)) {
    for (const auto* block : {&solid.surface, &solid.interior})
      for (const VertexId id : block->vertex_ids) row_of_[id] = static_cast<Index>(row_of_.size());
    for (const MeshEdge& edge : solid.edges) point_of_[{edge.a, edge.b}] = edge.point;
  }

  Index count() const { return static_cast<Index>(row_of_.size()); }
  const Eigen::Vector3d& rest(Index row) const {
    const bool outside = row < first_inside_;
    return (outside ? solid_.surface : solid_.interior).rest[outside ? row : row - first_inside_];
  }
  auto weights(Index row, const BoneWeights& surface, const BoneWeights& interior) const {
    return row < first_inside_ ? surface.row(row) : interior.row(row - first_inside_);
  }

  // Rows of the nodes of an element; empty if one does not exist.
  std::vector<Index> nodes(const Tetrahedron& corners) const {
    std::vector<Index> rows;
    const auto add = [&](VertexId id) {
      if (const auto found = row_of_.find(id); found != row_of_.end())
        rows.push_back(found->second);
    };
    for (const VertexId corner : corners) add(corner);
    for (const auto& [a, b] : kTetEdges) {
      if (point_of_.empty()) break;
      const VertexId p = corners[a];
      const VertexId q = corners[b];
      if (const auto found = point_of_.find({std::min(p, q), std::max(p, q)});
          found != point_of_.end())
        add(found->second);
    }
    if (rows.size() != (point_of_.empty() ? 4U : 10U)) rows.clear();
    return rows;
  }

  // One row per vertex: 1, X, and phi_i for all i by x, then y, then z.
  BasisRows fields() const {
    const Index r = solid_.whole.linear.cols();
    BasisRows fields(count(), 4 + 3 * r);
    fields.col(0).setOnes();
    for (Index v = 0; v < count(); ++v) {
      const bool outside = v < first_inside_;
      const BasisRows& rows = (outside ? solid_.surface : solid_.interior).rows;
      fields.block<1, 3>(v, 1) = rest(v).transpose();
      for (Index k = 0; k < 3; ++k)
        fields.block(v, 4 + k * r, 1, r) = rows.row(3 * (outside ? v : v - first_inside_) + k);
    }
    return fields;
  }

 private:
  const WeighedSolid& solid_;
  Index first_inside_;
  std::map<VertexId, Index> row_of_;
  std::map<std::pair<VertexId, VertexId>, VertexId> point_of_;
};

// From F^T M F with F as fields() has it.
InertiaIntegrals integrals_of(const MatrixXd& sums, Index r) {
  InertiaIntegrals inertia;
  inertia.mass = sums(0, 0);
  inertia.first_moment = sums.block<3, 1>(1, 0);
  inertia.second_moment = sums.block<3, 3>(1, 1);
  inertia.linear.resize(12, r);
  inertia.B.resize(9, pair_count(static_cast<std::size_t>(r)));
  for (Index l = 0; l < 3; ++l) {
    inertia.linear.row(l) = sums.block(0, 4 + l * r, 1, r);
    for (Index k = 0; k < 3; ++k) {
      inertia.linear.row(3 + 3 * k + l) = sums.block(1 + k, 4 + l * r, 1, r);
      for (Index j = 0; j < r; ++j)
        for (Index i = 0; i <= j; ++i)
          inertia.B(3 * k + l, static_cast<Index>(pair_index(static_cast<std::size_t>(i),
                                                             static_cast<std::size_t>(j)))) =
              sums(4 + k * r + i, 4 + l * r + j);
    }
  }
  return inertia;
}

// Adds `factor` times b to a.
void add_times(double factor, const InertiaIntegrals& b, InertiaIntegrals& a) {
  a.mass += factor * b.mass;
  a.first_moment += factor * b.first_moment;
  a.second_moment += factor * b.second_moment;
  a.linear += factor * b.linear;
  a.B += factor * b.B;
}

// `whole` less the sum of the shares, which must be small.
Result<InertiaIntegrals> missing_inertia(const std::vector<InertiaIntegrals>& shares,
                                         const InertiaIntegrals& whole) {
  InertiaIntegrals rest = whole;
  for (const InertiaIntegrals& share : shares) add_times(-1.0, share, rest);
  const bool little =
      std::abs(rest.mass) <= kMostMissing * whole.mass &&
      rest.linear.topRows<3>().norm() <= kMostMissing * whole.linear.topRows<3>().norm() &&
      rest.linear.bottomRows<9>().norm() <= kMostMissing * whole.linear.bottomRows<9>().norm() &&
      rest.B.norm() <= kMostMissing * whole.B.norm();
  if (!little)
    return content_error(
        "the tetrahedra do not make up the body's inertia: bones carry no point masses, and no "
        "lumped mass matrix");
  return rest;
}

}  // namespace

Result<std::vector<InertiaIntegrals>> share_inertia(const WeighedSolid& solid,
                                                    const BoneWeights& surface,
                                                    const BoneWeights& interior) {
  const Vertices vertices(solid);
  const BasisRows fields = vertices.fields();
  const Index bones = surface.cols(), r = solid.whole.linear.cols();
  std::vector<std::vector<Index>> nodes;
  for (std::size_t e = 0; e < solid.elements.corners.size(); ++e) {
    nodes.push_back(vertices.nodes(solid.elements.corners[e]));
    if (nodes.back().empty())
      return content_error("tetrahedron " + std::to_string(e) +
                           " has a corner or an edge that the model does not have");
  }
  std::vector<InertiaIntegrals> shares;
  BasisRows weighed(fields.rows(), fields.cols());
  for (Index bone = 0; bone < bones; ++bone) {
    weighed.setZero();
    for (std::size_t e = 0; e < nodes.size(); ++e) {
      double weight = 0.0;
      for (std::size_t a = 0; a < 4; ++a)
        weight += 0.25 * vertices.weights(nodes[e][a], surface, interior)[bone];
      if (weight == 0.0) continue;
      const auto count = static_cast<int>(nodes[e].size());
      for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b)
          weighed.row(nodes[e][a]) +=
              (weight * solid.elements.masses[e] * nodal_mass(count, a, b)) *
              fields.row(nodes[e][b]);
    }
    shares.push_back(integrals_of(fields.transpose() * weighed, r));
  }
  const Result<InertiaIntegrals> rest = missing_inertia(shares, solid.whole);
  if (!rest) return rest.error();
  for (InertiaIntegrals& share : shares) add_times(share.mass / solid.whole.mass, *rest, share);
  return shares;
}

}  // namespace tremolo
