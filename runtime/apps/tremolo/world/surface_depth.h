// Measurements that contact between points does not give: the depth of a body's drawn surface
// behind colliders and the shapes of other bodies, and the speed ratio of a rebound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/world/near_balls.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// Which bodies are so near that they may touch, of a world after a step.
class NearBodies {
 public:
  // The others that have a shape and feel contact, ascending; valid until the next call.
  std::span<const std::size_t> of(const SceneWorld& world, std::size_t body);

 private:
  NearBalls balls_;
  std::int64_t steps_ = -1;  // of the world when the balls were where they are
};

// Measures the vertices of the drawn surface of one body.
class SurfaceDepth {
 public:
  // The depth of the deepest vertex, m; 0 if none is inside anything. Ignores bodies that do not
  // feel contact and pairs that a joint lets pass. near: a cache for the world's present state,
  // shared by all bodies.
  double measure(const SceneWorld& world, std::size_t body, NearBodies& near);
  double measure(const SceneWorld& world, std::size_t body) {
    NearBodies near;
    return measure(world, body, near);
  }

 private:
  double behind_body(const ContactBody& other, const PresentPlace& place, const Eigen::Vector3d& x);

  std::vector<double> positions_;
  Eigen::VectorXd displacement_;  // of the contact points of the other body
};

// The ratio of the normal speeds, relative to the collider, with which the centre of mass of a free
// body leaves the first collider that it meets and arrived there. The normal is the collider's at
// the centre of mass in the first step of contact; the speed of arrival is that at the end of the
// step before; that of departure is the largest until the body approaches again.
class Rebound {
 public:
  // After every step, and at the start.
  void observe(const SceneWorld& world, std::size_t body);
  // Nullopt: no collider was met, or not by approaching it.
  std::optional<double> ratio() const;

 private:
  double speed_away(const SceneWorld& world, std::size_t body) const;

  enum class Phase { kBefore, kTouching, kLeaving, kOver } phase_ = Phase::kBefore;
  std::size_t collider_ = 0;
  Eigen::Vector3d normal_ = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();  // of the step before, m/s
  double arrival_ = 0.0;                                // m/s, towards the collider
  double departure_ = 0.0;                              // m/s, away from it
};

}  // namespace tremolo
