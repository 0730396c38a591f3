// One corotated tetrahedron, linear or quadratic (docs/tets.md).
//
// x: control points in space, F = sum_I x_I (grad B_I)^T the deformation gradient, R a rotation of
// the element, S = R^T F the deformation in the rotated frame, e = sym S - 1, sigma = C e, b =
// ax(mean of S), m = mu_c V. The element's energy is that of linear elasticity in the rotated frame
// plus a couple that ties R to the mean deformation,
//   W(x, R) = integral 1/2 e : C e  +  m/2 |b|^2,         W(x) = min over R,
// so that with the R of the minimum
//   f = dW/dx = R (K (R^T x - X) + couple)                (R's own change costs nothing there)
// is a gradient, and its torque, the derivative of W along rotations of x, is zero. At rest the
// minimum over R removes the couple: the tangent is K exactly, for any mu_c. Without the couple W
// would not determine R at rest, because K does not depend on rotations.
//
// For linear elements of isotropic material R is the polar factor of F at any mu_c, and the couple
// is zero: this is the usual corotated element. mu_c = half the largest row sum of |C| (3/2 lambda
// + mu) makes the polar factor a minimum at every uniform stretch.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "common/elements/elasticity.h"
#include "common/elements/element.h"
#include "common/state_stream.h"

namespace tremolo {

// Definition of an element's rotation. kLeastEnergy: W above. kCorners: the polar factor of the
// corners' deformation alone, without a couple, and the force leaves out dR/dx, as in the published
// method. For quadratic elements that force is not a gradient and has a torque.
enum class RotationLaw { kLeastEnergy, kCorners };

// Derivative of the force. kFrozen: R K R^T, symmetric and never negative. kExact: with dR/dx;
// symmetric, and indefinite where an element is compressed enough. For kCorners both are R K R^T.
enum class TangentKind { kFrozen, kExact };

// Coordinates of an element's control points, or forces on them: 3 x 4 or 3 x 10, one column per
// node.
using NodeVectors = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMostNodes>;

// Constants of an element.
struct TetElement {
  ElementGeometry geometry;
  double couple = 0.0;  // m = mu_c V, J
  double mass = 0.0;    // rho V, kg
};
TetElement make_tet_element(const std::array<Eigen::Vector3d, 4>& corners,
                            const Elasticity& elasticity, double density);

// An element at given control points.
struct TetShape {
  int order = 1;
  int samples = 1;  // number of strain samples, 1 or 4
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  std::array<Eigen::Matrix3d, 4> seen;               // S at each sample
  std::array<Eigen::Matrix3d, 4> stress;             // sigma at each sample, Pa
  Eigen::Matrix3d mean;                              // of S
  Eigen::Vector3d couple = Eigen::Vector3d::Zero();  // m b, J; zero for kCorners
  // R makes the energy stationary to rounding, so that force and energy are consistent.
  bool converged = true;
  bool has_turn = false;            // hessian and turned are set
  Eigen::Matrix3d hessian, turned;  // of turn_derivatives() (element_turn.h)
};

// Saves or restores a shape that was found.
inline void carry(StateStream& stream, TetShape& shape) {
  stream(shape.order, shape.samples, shape.rotation, shape.mean, shape.couple, shape.converged,
         shape.has_turn);
  stream.require(shape.samples == 1 || shape.samples == 4);
  for (std::size_t s = 0; stream.good() && s < static_cast<std::size_t>(shape.samples); ++s)
    stream(shape.seen[s], shape.stress[s]);
  if (shape.has_turn) stream(shape.hessian, shape.turned);
}

// x: finite. Never NaN, also for flat and inverted elements. Allocates nothing.
TetShape tet_shape(const TetElement& element, const Elasticity& elasticity, RotationLaw law,
                   const NodeVectors& x);

double tet_energy(const TetElement& element, const TetShape& shape);  // J

// dW/dx, N, one column per node; the force on the nodes is its negative.
NodeVectors tet_force(const TetElement& element, const TetShape& shape);

// The force of stiffness-proportional damping divided by its factor beta: the derivative by v of
//   1/2 zdot : K' zdot,   zdot = R^T (v - w x x),
// with the w that minimises it, K' = K + couple: a rigid motion of the present shape is not damped,
// and force and torque add up to zero. v: m/s. For kCorners it is R K R^T v.
NodeVectors tet_damping_force(const TetElement& element, const Elasticity& elasticity,
                              RotationLaw law, const TetShape& shape, const NodeVectors& v);

// Blocks of a symmetric element matrix: (i, j) with j <= i, row by row, as node_block() numbers
// them.
inline constexpr std::size_t kMostBlocks = kMostNodes * (kMostNodes + 1) / 2;
using NodeBlocks = std::array<Eigen::Matrix3d, kMostBlocks>;
constexpr std::size_t node_block(std::size_t i, std::size_t j) {
  return i * (i + 1) / 2 + j;
}
// The blocks of K, rest_stiffness of an element: 10 of a linear one, 55 of a quadratic one.
std::size_t pack_stiffness(const ElementStiffness& stiffness, std::span<Eigen::Matrix3d> blocks);

// Factors in tet_tangent(): position times dforce/dx plus velocity times ddamping/dv.
struct TangentFactors {
  double position = 1.0;
  double velocity = 0.0;
  TangentKind kind = TangentKind::kFrozen;
};

// The parts of the exact tangent in addition to both multiples of K, in the element's frame:
//   A_IJ = (position + velocity) (K_IJ + couple [g_I]^T [g_J])
//        - position slopes_I of_slopes slopes_J^T - velocity turned_I of_turned turned_J^T.
// gradients: g, of the polynomials' means, 1/m, one column per node. slopes_I consists of node I of
// the three columns. of_slopes and of_turned include their factors; couple includes both.
struct TangentParts {
  std::array<NodeVectors, 3> slopes, turned;
  Eigen::Matrix3d of_slopes, of_turned;
  NodeVectors gradients;
  double couple = 0.0;
};
TangentParts tangent_parts(const TetElement& element, const Elasticity& elasticity,
                           const TetShape& shape, const TangentFactors& factors);

// stiffness: the blocks of K.
void tet_tangent(const TetElement& element, const Elasticity& elasticity, RotationLaw law,
                 const TetShape& shape, std::span<const Eigen::Matrix3d> stiffness,
                 const TangentFactors& factors, NodeBlocks& out);

// Computes shapes of several quadratic elements at once, one in each lane of a register. It finds
// the same minimum over rotations as tet_shape(), by Newton's method from each element's previous
// rotation.
//
// Near rest there is one minimum within reach from any start. The following elements are left to
// tet_shape(): those strained by more than half of their size, those that rotate by more than
// Newton's method allows or meet a stiffness that is not positive, and those of anisotropic
// materials.

inline constexpr std::size_t kElementLanes = 8;

// One element of a group.
struct LaneElement {
  const TetElement* element = nullptr;
  const Elasticity* elasticity = nullptr;
  std::array<const double*, kMostNodes> nodes{};  // its ten control points, m, three numbers each
  // In: its rotation is the start of the search. Out: the shape, if it was found.
  TetShape* shape = nullptr;
};

// group: quadratic and isotropic elements, at most kElementLanes. Returns a bit for each element
// whose shape was not found and is unchanged. Allocates nothing.
unsigned shapes_in_lanes(const LaneElement* group, std::size_t count);

}  // namespace tremolo
