// A scene of cloths and rigid balls that goes.
//
// Each step: integrators take the cloths on, balls fall, then contact is projected: a particle
// inside a shape (less its thickness) is put on its surface, its velocity along the normal comes
// back by restitution, that along the surface is reduced by friction, and a ball gets the opposite
// impulse (docs/cloth.md). Cloths do not touch themselves nor each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/mesh/surface_mesh.h"
#include "common/result.h"
#include "runtime/cloth/cloth_scene.h"
#include "runtime/contact/collider.h"

namespace tremolo {

class ClothModel;

// J, since the start but for the first three, which are now. What is told makes up the change of
// kinetic + elastic + gravity, but for `numerical`, which is what the method itself added, and
// contact, what projection took (negative) or gave.
struct ClothEnergy {
  double kinetic = 0.0, elastic = 0.0, gravity = 0.0;
  double damped = 0.0, wind = 0.0, pins = 0.0, contact = 0.0, numerical = 0.0;
  double total() const { return kinetic + elastic + gravity; }
};

class ClothWorld {
 public:
  // Errors: as check_scene; kContent for a mesh with zero-length springs, isolated vertices or an
  // edge with more than two triangles, a ball or collider in which a particle begins deeper than
  // the cloth's thickness; kUsage for a step beyond the method's stability ("the limit is 1.3 ms");
  // kSystem for files that cannot be read.
  static Result<ClothWorld> create(const ClothScene& scene);
  ClothWorld(ClothWorld&&) noexcept;
  ClothWorld& operator=(ClothWorld&&) noexcept;
  ~ClothWorld();

  const ClothScene& scene() const;
  double time() const;
  std::int64_t steps() const;

  // Another method and another step, s, from now on; the time goes to the nearest multiple of it.
  // Errors, and nothing is changed: those below; kSystem.
  Status set_method(std::string_view integrator, double step);
  // The step, s, up to which a method is stable, at rest and as the cloths lie now; infinity for
  // methods that have no limit. Errors (kUsage): a name that is none, a `step` that is not positive
  // and finite, or beyond the limit.
  Result<double> stability_limit_of(std::string_view integrator, double step) const;

  // Why a step was not made; nothing was moved then.
  Status step();

  std::size_t cloths() const;
  std::size_t particles(std::size_t cloth) const;
  // 3n, x y z ..., m and m/s.
  const Eigen::VectorXd& positions(std::size_t cloth) const;
  const Eigen::VectorXd& velocities(std::size_t cloth) const;
  const std::vector<Triangle>& triangles(std::size_t cloth) const;
  // Replaces the state of a cloth; kUsage for other sizes or what is not finite.
  Status set_state(std::size_t cloth, const Eigen::VectorXd& x, const Eigen::VectorXd& v);
  const ClothModel& model(std::size_t cloth) const;
  // Holds a particle at a point from the next step on (a hand); let_go() frees it.
  Status hold(std::size_t cloth, std::size_t particle, const Eigen::Vector3d& at);
  Status let_go(std::size_t cloth, std::size_t particle);

  struct Ball {
    Eigen::Vector3d position, velocity, spin;
    Eigen::Quaterniond rotation;
  };
  std::span<const Ball> balls() const;
  Pose collider_pose(std::size_t collider) const;

  ClothEnergy energy() const;                // of all cloths and balls
  Eigen::Vector3d linear_momentum() const;   // of all cloths and balls that move
  Eigen::Vector3d angular_momentum() const;  // about the origin
  double stability_limit() const;            // s; infinity for methods that have none
  double penetration_max() const;  // m, of particles at the ends of steps, since the start
  std::int64_t iterations() const;
  std::int64_t cut_steps() const;  // steps that were taken in parts

 private:
  struct Inside;
  explicit ClothWorld(std::unique_ptr<Inside> inside);
  std::unique_ptr<Inside> inside_;
};

}  // namespace tremolo
