// The forces, energy and matrices of a mesh of corotated tetrahedra at given control points, with
// edges of degree one or two.
//
// With E the map from the free control points to all of them (x_ab = (x_a + x_b) / 2 on a linear
// edge), the potential is W(E x), so that
//   force = -E^T dW,   mass = E^T M E,   matrix = E^T (c_0 M + c_1 dforce/dx + ...) E,
// and E^T adds half of the force on a linear edge's control point to each end. An element whose
// edges are all linear is the linear element (docs/tets.md), and is computed as one. Condensed
// entries are zero in vectors; vectors are 3 nodes() long and contain x_ab also for linear edges.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/bodies/tets/elements/tet_model.h"

namespace tremolo {

// Factors of the terms in TetSystem::assemble().
struct TetMatrixFactors {
  double mass = 0.0;
  TangentFactors tangent;
};

class TetSystem {
 public:
  // All edges quadratic.
  TetSystem(TetModelPointer model, RotationLaw law);

  const TetModel& model() const { return *model_; }
  RotationLaw law() const { return law_; }

  // degrees: 1 or 2 for each edge.
  void set_degrees(std::span<const std::uint8_t> degrees);
  std::span<const std::uint8_t> degrees() const { return degrees_; }
  double quadratic_share() const;  // of the edges
  // One flag per control point: neither fixed nor condensed.
  std::span<const std::uint8_t> active() const { return active_; }

  // Moves the control points of linear edges to the mean of their ends; the same for velocities.
  void follow_ends(Eigen::VectorXd& x) const;
  // E^T: halves are added to the ends; forces on fixed control points stay there.
  void fold(Eigen::VectorXd& y) const;

  // Computes all elements' rotations and strains at x, whose linear edges follow their ends; the
  // functions below refer to this x. Returns the number of elements whose rotation did not
  // converge. Does nothing if x and the degrees are those of the last call.
  std::size_t evaluate(const Eigen::VectorXd& x);
  double energy() const;                  // J
  Eigen::Matrix3d mean_rotation() const;  // nearest to the mean of the elements' by volume
  // Number of elements whose deformation gradient has no positive determinant at one of their
  // corners: flat or inverted there.
  std::size_t inverted() const;
  // f += the forces on the control points of the quadratic mesh, N. fold() condenses them; before
  // that, the rows of linear edges are the forces that their constraint balances.
  void add_force(Eigen::VectorXd& f) const;
  // The same for damping proportional to the stiffness, beta s.
  void add_damping_force(const Eigen::VectorXd& v, double beta, Eigen::VectorXd& f) const;
  // a = E^T (..) E. Rows and columns of control points that are not active are undefined.
  void assemble(const TetMatrixFactors& factors, BlockMatrix& a) const;
  // Adds the same in single precision to the matrix.
  void assemble(const TetMatrixFactors& factors, const FloatTarget& target) const;

  // Condenses weights of control points, among which are both ends of every edge: those of linear
  // edges are added half and half to their ends.
  void fold_point(std::span<const std::uint32_t> nodes, std::span<double> shares) const;

  // y <- E^T M y.
  void mass_times_folded(Eigen::VectorXd& y) const;

  // Linear and angular momentum about the origin, kg m/s, kg m^2/s.
  Eigen::Vector3d momentum(const Eigen::VectorXd& v) const;
  Eigen::Vector3d angular_momentum(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const;
  double kinetic_energy(const Eigen::VectorXd& v) const;  // J
  std::size_t bytes() const;

  // Saves or restores degrees, positions and shapes: the search for a rotation starts from the last
  // one, on which the bits of the next depend.
  void carry(StateStream& stream);

 private:
  bool straight(std::size_t element) const { return linear_[element] == kAllLinear; }
  void find_shape(std::size_t element, const Eigen::VectorXd& x);  // for one element
  NodeVectors gather(const TetModelElement& element, const Eigen::VectorXd& x, int nodes) const;
  void scatter(const TetModelElement& element, const NodeVectors& force, Eigen::VectorXd& f) const;
  TetModelPointer model_;
  RotationLaw law_;
  static constexpr std::uint8_t kAllLinear = 63;
  std::vector<std::uint8_t> degrees_, active_;
  std::vector<std::uint8_t> linear_;  // for each element a bit for each of its linear edges
  std::vector<TetShape> shapes_;
  Eigen::VectorXd evaluated_;  // the x of shapes_
  bool has_shapes_ = false;
  std::size_t lost_ = 0;
  mutable Eigen::VectorXd sum_;  // temporary vector
};

}  // namespace tremolo
