// A body that moves by its points, of a world or of a scene of its own: the part of the engine
// that tremolo.NodalBody shows, whatever the kind.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "runtime/math/state.h"

namespace tremolo {
class ClothWorld;
class MixedGuests;
class TetGroup;
struct TetsKind;
}  // namespace tremolo

namespace tremolo::python {

// Energies now, J. contact: known in worlds alone.
struct NodalEnergy {
  double kinetic = 0.0, potential = 0.0, gravity = 0.0;
  std::optional<double> contact;
};

// Only a body among those of other kinds has a balance with them.
struct NodalAccount {
  NodalEnergy now;
  // Given since the start, J.
  double contact_given = 0.0, restitution = 0.0, friction = 0.0;
  double work = 0.0;  // of contact, with what it stores, of hands, joints and loads, J
  double hand = 0.0, joint = 0.0, load = 0.0;  // given since the start, J
};

class NodalSource {
 public:
  virtual ~NodalSource() = default;

  virtual const std::string& name() const = 0;
  virtual const char* kind() const = 0;  // "tets" or "cloth"
  virtual double mass() const = 0;       // kg
  virtual double size() const = 0;       // longest side of the box at rest, m
  virtual bool asleep() const { return false; }
  virtual bool failed() const { return false; }

  // Control points or particles, 3 n, m, with their velocities, m/s; a flag for each one that is
  // held.
  virtual const Eigen::VectorXd& points() const = 0;
  virtual const Eigen::VectorXd& velocities() const = 0;
  virtual std::span<const std::uint8_t> held() const = 0;
  virtual Status set_state(const Eigen::VectorXd& x, const Eigen::VectorXd& v) = 0;

  // The drawn surface. place(): the values at its vertices of positions or velocities of all
  // points.
  virtual std::size_t drawn() const = 0;
  virtual const std::vector<Triangle>& triangles() const = 0;
  virtual std::span<const Eigen::Vector3d> place(const Eigen::VectorXd& of_points) = 0;

  virtual NodalEnergy energy() = 0;
  virtual Momenta momenta() const = 0;

  // Grabs a drawn vertex where it is; returns the number that names the grab. Without a stiffness
  // or damping those are taken that suit the place.
  virtual Result<std::size_t> grab(std::size_t vertex, std::optional<double> stiffness,
                                   std::optional<double> damping) = 0;
  virtual Status move_grab(std::size_t number, const Eigen::Vector3d& position) = 0;
  virtual Status release(std::size_t number) = 0;
  // A force on a drawn vertex, N, constant over the next `steps` steps. kUsage: it is in a scene of
  // its own kind alone.
  virtual Status apply_force(std::size_t vertex, const Eigen::Vector3d& force, int steps) {
    (void)vertex;
    (void)force;
    (void)steps;
    return usage_error("body '" + name() + "': forces act on it in a tremolo.world()");
  }
  // Grabs and states that the user has set put energy in: the bound of the energy is then unknown.
  bool driven = false;
  // Called before each step.
  virtual Status begin_step() { return Success{}; }

  // Of a body among those of other kinds; empty: it is in a scene of its own kind alone.
  virtual std::optional<NodalAccount> account() { return std::nullopt; }
  virtual std::int64_t contacts() const { return 0; }
  virtual double penetration_max() const { return 0.0; }  // m
};

using NodalSources = std::vector<std::unique_ptr<NodalSource>>;

// The sources refer to what they are made of, which must outlive them. kind_of: of a body of
// tetrahedra, by its number.
using KindOf = std::function<const TetsKind&(std::size_t)>;
// kind: null: a cloth.
std::unique_ptr<NodalSource> source_of(MixedGuests& guests, std::size_t i, const TetsKind* kind);
NodalSources sources_of(TetGroup& group, const std::vector<std::string>& names,
                        const KindOf& kind_of);
NodalSources sources_of(ClothWorld& world);

}  // namespace tremolo::python
