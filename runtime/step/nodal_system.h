// Interface between integrators and point masses that act on each other: M x'' = f(x, v). The
// masses are a cloth's particles or the nodes of a mesh.
//
// Vectors are 3n long, x y z of each node in turn; m, m/s, N.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "runtime/math/sparse/block_matrix.h"

namespace tremolo {

// Selects the forces: all, or those of one half of a method that treats stiff and soft ones
// differently.
enum class ForcePart { kAll, kStiff, kSoft };

// Work in a step of forces that have no potential.
struct StepWork {
  double damped = 0.0;  // taken by dampers, J; not negative
  double driven = 0.0;  // given by wind and similar forces, J
};

// Reactions of obstacles at the end x1 of a step, found together with it. They act at x1 alone,
// whatever weights the method gives to other forces. Vectors as above; nothing is allocated.
class NodalContact {
 public:
  virtual ~NodalContact() = default;
  // Call this before a solve.
  virtual void start() = 0;
  // Chooses the acting reactions and their positions again after a solve from x0 has ended at x1.
  // True if that changes x1: the solve then continues. share: same as for keep().
  virtual bool revise(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) = 0;
  // f += the reactions at x1.
  virtual void add_force(const Eigen::VectorXd& x1, Eigen::VectorXd& f) const = 0;
  // a += -df/dx1 of them.
  virtual void add_tangent(BlockMatrix& a) const = 0;
  // Returns the work over a step, J: share f.(x1 - x0).
  virtual double work(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) const = 0;
  // Ends a step of h, s, or a part of one, that succeeded: each reaction's impulse was share h f.
  virtual void keep(const Eigen::VectorXd& x1, double h, double share) = 0;
  // True if any reaction had an impulse in the last keep().
  virtual bool pressed() const = 0;
};

class NodalSystem {
 public:
  virtual ~NodalSystem() = default;

  virtual std::size_t size() const = 0;             // n
  virtual const Eigen::VectorXd& mass() const = 0;  // n, kg, positive
  virtual std::span<const std::uint8_t> held()
      const = 0;  // n; not 0: the node is fixed and moves only by put_held()
  virtual const BlockPatternPointer& pattern() const = 0;  // of the tangents

  // Unit of residuals, N: the length of the vector of all loads, including weight; without loads a
  // small fraction of the springs' forces. Positive.
  virtual double load_size() const = 0;

  // Sets the positions of the fixed nodes to those at a time, s; the others are unchanged.
  virtual void put_held(double time, Eigen::VectorXd& x) const = 0;

  // f(x, v), with gravity. Nothing is allocated.
  virtual void force(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
                     Eigen::VectorXd& f) const = 0;

  // a += position (-df/dx) + velocity (-df/dv), both symmetric: other terms are left out, and of
  // indefinite ones `share`, 0 to 1, is kept. With 0 it is positive semidefinite. Nothing is
  // allocated.
  virtual void add_tangent(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
                           double position, double velocity, double share,
                           BlockMatrix& a) const = 0;

  // V(x), J, with gravity.
  virtual double potential(const Eigen::VectorXd& x) const = 0;
  // Changes whenever potential() of the same x may change. Empty if that is not known: then the
  // potential is evaluated again in every step.
  virtual std::optional<std::uint64_t> potential_version() const { return std::nullopt; }

  // The power of forces without a potential at (x, v), W; damped and driven are then rates.
  virtual StepWork power(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const = 0;

  // A force over a step from x0 to x1 of h, for methods that conserve energy: f.(x1 - x0) = V(x0) -
  // V(x1) - damped + driven, to rounding, and internal forces conserve momentum and angular
  // momentum about (x0 + x1)/2. Returns its work.
  virtual StepWork step_force(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                              Eigen::VectorXd& f) const = 0;
  // a += approximately -df/dx1 of that force, in the same way.
  virtual void add_step_tangent(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                double share, BlockMatrix& a) const = 0;

  // Null without obstacles. Methods without an equation to solve do not call it.
  virtual NodalContact* contact() const { return nullptr; }
};

}  // namespace tremolo
