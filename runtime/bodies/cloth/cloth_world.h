// A scene of cloths and rigid balls that moves in time.
//
// In each step integrators advance the cloths, balls fall, and contact is projected. A particle
// inside a shape (less its thickness) is moved to the surface. Restitution reverses its velocity
// along the normal, friction reduces that along the surface, and a ball gets the opposite impulse
// (docs/cloth.md). There is no contact of a cloth with itself or with another cloth.
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
#include "runtime/bodies/cloth/cloth_scene.h"
#include "runtime/contact/collider.h"

namespace tremolo {

class ClothModel;

// Energy balance, J. The work terms add up to the change of kinetic + elastic + gravity, except for
// `numerical` and contact.
struct ClothEnergy {
  double kinetic = 0.0, elastic = 0.0, gravity = 0.0;  // present values
  // Sums since the start. damped: taken by dampers. wind, pins: work. contact: taken (negative) or
  // added by projection. numerical: added by the method itself.
  double damped = 0.0, wind = 0.0, pins = 0.0, contact = 0.0, numerical = 0.0;
  double total() const { return kinetic + elastic + gravity; }
};

class ClothWorld {
 public:
  // Errors: same as for check_scene(); kContent for a mesh with zero-length springs, isolated
  // vertices or an edge with more than two triangles, or for a ball or collider that a particle
  // penetrates at the start deeper than the cloth's thickness; kUsage for a step beyond the
  // method's stability ("the limit is 1.3 ms"); kSystem for files that cannot be read.
  static Result<ClothWorld> create(const ClothScene& scene);
  ClothWorld(ClothWorld&&) noexcept;
  ClothWorld& operator=(ClothWorld&&) noexcept;
  ~ClothWorld();

  const ClothScene& scene() const;
  double time() const;
  std::int64_t steps() const;

  // Sets another method and step, s, from now on; the time becomes the nearest multiple of the
  // step. Errors, with nothing changed: those of stability_limit_of(); kSystem.
  Status set_method(std::string_view integrator, double step);
  // The largest stable step of a method, s, at rest and in the cloths' present state; infinity for
  // methods that have no limit. Errors (kUsage): an unknown name, a `step` that is not positive and
  // finite, or one beyond the limit.
  Result<double> stability_limit_of(std::string_view integrator, double step) const;

  // Takes a step. Error: the reason why the step failed; nothing was moved then.
  Status step();

  std::size_t cloths() const;
  std::size_t particles(std::size_t cloth) const;
  // 3n, x y z ..., m and m/s.
  const Eigen::VectorXd& positions(std::size_t cloth) const;
  const Eigen::VectorXd& velocities(std::size_t cloth) const;
  const std::vector<Triangle>& triangles(std::size_t cloth) const;
  // Replaces the state of a cloth. Error kUsage: other sizes or a value that is not finite.
  Status set_state(std::size_t cloth, const Eigen::VectorXd& x, const Eigen::VectorXd& v);
  const ClothModel& model(std::size_t cloth) const;
  // Grabs a particle and holds it at a point from the next step on; let_go() releases it.
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
  Eigen::Vector3d angular_momentum() const;  // about the origin, N m s
  double stability_limit() const;            // s; infinity for methods without a limit
  // Largest of all particles at the ends of steps since the start, m.
  double penetration_max() const;
  std::int64_t iterations() const;
  std::int64_t cut_steps() const;  // steps that were taken in parts

 private:
  struct Inside;
  explicit ClothWorld(std::unique_ptr<Inside> inside);
  std::unique_ptr<Inside> inside_;
};

}  // namespace tremolo
