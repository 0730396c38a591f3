// The signed distance to a surface on a regular grid of nodes, and between them by a spline.
//
// The spline is the triquadratic B-spline that takes the node values, s(x) = sum_i c_i B(u - i)
// with u = (x - origin) / spacing and B the centred quadratic B-spline along each axis. Its value
// and first derivatives are continuous, which is what a contact force needs, its gradient is exact
// for the value, and 27 coefficients suffice. It reproduces quadratic polynomials: the error of a
// smooth distance is of third order in the spacing, that of its gradient of second. At an edge of
// the surface, and on the middle surface inside, the distance itself has a kink, and the error
// there is of first order.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "common/result.h"

namespace tremolo {

// Positions of the nodes: (i, j, k) is at origin + spacing (i, j, k), numbered i + counts[0] (j +
// counts[1] k). origin, spacing: m.
struct GridNodes {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double spacing = 0;
  std::array<std::uint32_t, 3> counts{};

  std::size_t size() const { return std::size_t{counts[0]} * counts[1] * counts[2]; }
  Eigen::Vector3d at(std::size_t i, std::size_t j, std::size_t k) const {
    return origin + spacing * Eigen::Vector3d(static_cast<double>(i), static_cast<double>(j),
                                              static_cast<double>(k));
  }
};

inline constexpr std::uint32_t kLeastGridNodes = 4;                    // along an axis
inline constexpr std::uint32_t kMostGridNodes = 4096;                  // along an axis
inline constexpr std::size_t kMostNodesOfGrid = std::size_t{1} << 26;  // 256 MB

// Errors (kContent): counts outside the limits above; origin or spacing that is not finite, or so
// extreme that neighbours coincide.
Status check(const GridNodes& nodes);

// Immutable; safe to use from several threads. Memory: four bytes a node.
class DistanceGrid {
 public:
  // values: one per node, m, negative inside. Errors (kContent): those of check(); another number
  // of values than nodes; a value that is not finite or exceeds the grid's diagonal; neighbours
  // that differ by more than their distance, which is impossible for distances; a value on the
  // border that is not positive: the surface needs a margin.
  static Result<DistanceGrid> create(const GridNodes& nodes, std::span<const float> values);

  // distance: m. gradient: of `distance` exactly; its length is 1 up to the grid's error.
  struct Sample {
    double distance = 0;
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  };
  // Outside of the grid's box the distance to the box is added to the value at its nearest point:
  // continuous, and up to the grid's error no less than the distance to the surface. x: finite.
  // Allocates nothing.
  Sample at(const Eigen::Vector3d& x) const;

  const GridNodes& nodes() const { return nodes_; }
  // From the first node to the last.
  BoundingBox box() const { return box_; }
  // Contains the solid, with a margin of two cells at most.
  BoundingBox solid_box() const { return solid_box_; }
  std::size_t bytes() const { return coefficients_.size() * sizeof(float); }
  // The hash covers all that at() depends on.
  std::uint64_t content_hash() const;

 private:
  explicit DistanceGrid(const GridNodes& nodes) : nodes_(nodes) {}
  void find_boxes(std::span<const float> values);
  void filter();

  GridNodes nodes_;
  BoundingBox box_;
  BoundingBox solid_box_;
  std::vector<float> coefficients_;
};

}  // namespace tremolo
