// Wind forces on triangles.
//
// For the triangle a, b, c let N = (x_b - x_a) x (x_c - x_a), whose length is twice the area, and w
// = W - (v_a + v_b + v_c)/3, the wind relative to it. The force is 1/2 rho A |n.w| (n.w) n = rho/4
// |N.w| (N.w) N/|N|^2, a third of it on each corner.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/tet_mesh.h"
#include "runtime/math/sparse/block_matrix.h"
#include "runtime/step/nodal_system.h"

namespace tremolo {

class WindDrag {
 public:
  WindDrag() = default;
  // drag: rho, kg/m^3. With 0 there is no force.
  WindDrag(const std::vector<Triangle>& triangles, double drag);

  // Finds the blocks in a pattern that has all edges.
  void find_places(const BlockPattern& pattern);

  bool blows() const { return !corners_.empty(); }

  // wind: W, m/s. f += the forces. This and the following functions allocate nothing.
  void add_force(const Eigen::Vector3d& wind, const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                 Eigen::VectorXd& f) const;
  // a += velocity (-df/dv) of these forces.
  void add_tangent(const Eigen::Vector3d& wind, const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                   double velocity, BlockMatrix& a) const;
  // W: power damped by the motion relative to the wind, and power supplied by the wind's own
  // motion.
  StepWork power(const Eigen::Vector3d& wind, const Eigen::VectorXd& x,
                 const Eigen::VectorXd& v) const;
  // f += the force on the triangles halfway between x0 and x1, at the velocity (x1 - x0)/h; returns
  // its work.
  StepWork add_step_force(const Eigen::Vector3d& wind, const Eigen::VectorXd& x0,
                          const Eigen::VectorXd& x1, double h, Eigen::VectorXd& f) const;
  void add_step_tangent(const Eigen::Vector3d& wind, const Eigen::VectorXd& x0,
                        const Eigen::VectorXd& x1, double h, BlockMatrix& a) const;

 private:
  // The blocks of its corners, and of the pairs a b, b c and c a.
  struct Places {
    std::array<std::uint32_t, 3> corner{}, edge{};
  };

  void add_blocks(std::size_t triangle, const Eigen::Matrix3d& block, BlockMatrix& a) const;

  double drag_ = 0.0;
  std::vector<std::array<std::uint32_t, 3>> corners_;
  std::vector<Places> places_;
};

}  // namespace tremolo
