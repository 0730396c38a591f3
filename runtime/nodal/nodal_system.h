// What integrators see of masses in space that pull on each other: M x'' = f(x, v), a cloth's
// particles or the nodes of a mesh.
//
// Vectors are 3n long, x y z of each node behind each other; m, m/s, N.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "runtime/sparse/block_matrix.h"

namespace tremolo {

// Which forces: all, or those of one half of a method that takes stiff and soft ones differently.
enum class ForcePart { kAll, kStiff, kSoft };

// What forces that have no potential did in a step, J: damped is not negative, what the dampers
// took; driven: what wind and the like gave.
struct StepWork {
  double damped = 0.0;
  double driven = 0.0;
};

// What stands in the way of nodes: reactions at the end x1 of a step, which are found together with
// it. However the method weighs other forces, these act at x1 alone. Vectors as above; nothing is
// allocated.
class NodalContact {
 public:
  virtual ~NodalContact() = default;
  // Before a solve.
  virtual void start() = 0;
  // Told where a solve from x0 has ended: chooses anew what presses and where. True if that moves
  // x1: the solve then goes on. share: as of keep().
  virtual bool revise(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) = 0;
  // f += the reactions at x1.
  virtual void add_force(const Eigen::VectorXd& x1, Eigen::VectorXd& f) const = 0;
  // a += -df/dx1 of them.
  virtual void add_tangent(BlockMatrix& a) const = 0;
  // J, over a step: share f.(x1 - x0).
  virtual double work(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) const = 0;
  // Told that a step of h, s, or a part of one, was made: each reaction's impulse was share h f.
  virtual void keep(const Eigen::VectorXd& x1, double h, double share) = 0;
  // Whether any reaction had an impulse then.
  virtual bool pressed() const = 0;
};

class NodalSystem {
 public:
  virtual ~NodalSystem() = default;

  virtual std::size_t size() const = 0;             // n
  virtual const Eigen::VectorXd& mass() const = 0;  // n, kg, positive
  virtual std::span<const std::uint8_t> held()
      const = 0;  // n; not 0: the node goes where it is put
  virtual const BlockPatternPointer& pattern() const = 0;  // of the tangents

  // What residuals are a share of, N: the length of the vector of all loads, weight among them; a
  // small part of the springs' forces where there is none. Positive.
  virtual double load_size() const = 0;

  // Sets the places of the nodes that are held to those of a moment, s; the others stay.
  virtual void put_held(double time, Eigen::VectorXd& x) const = 0;

  // f(x, v), with gravity. Nothing is allocated.
  virtual void force(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
                     Eigen::VectorXd& f) const = 0;

  // a += position (-df/dx) + velocity (-df/dv), both symmetric and positive semidefinite: what
  // makes them otherwise is left out. Nothing is allocated.
  virtual void add_tangent(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
                           double position, double velocity, BlockMatrix& a) const = 0;

  // V(x), J, with gravity.
  virtual double potential(const Eigen::VectorXd& x) const = 0;
  // Another number whenever potential() of the same x may be another one than before; nothing where
  // that is not known: then it is evaluated anew in every step.
  virtual std::optional<std::uint64_t> potential_version() const { return std::nullopt; }

  // The power of what has no potential at (x, v), W: damped and driven are then rates.
  virtual StepWork power(const Eigen::VectorXd& x, const Eigen::VectorXd& v) const = 0;

  // A force over a step from x0 to x1 of h, for methods that keep the energy: f.(x1 - x0) = V(x0) -
  // V(x1) - damped + driven, to rounding, and internal forces keep momentum and angular momentum
  // about (x0 + x1)/2. Returns what it did.
  virtual StepWork step_force(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                              Eigen::VectorXd& f) const = 0;
  // a += -df/dx1 of it, nearly.
  virtual void add_step_tangent(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                BlockMatrix& a) const = 0;

  // The same with what makes them indefinite, for steps that are tried first; they are symmetric.
  virtual void add_full_tangent(const Eigen::VectorXd& x, const Eigen::VectorXd& v, ForcePart part,
                                double position, double velocity, BlockMatrix& a) const {
    add_tangent(x, v, part, position, velocity, a);
  }
  virtual void add_full_step_tangent(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double h,
                                     BlockMatrix& a) const {
    add_step_tangent(x0, x1, h, a);
  }

  // None where nothing stands in the way. Methods that solve nothing do not ask.
  virtual NodalContact* contact() const { return nullptr; }
};

}  // namespace tremolo
