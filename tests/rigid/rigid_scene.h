// Scenes of rigid bodies, and the measures that tests take of them.
#pragma once

#include <cmath>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "runtime/world/scene_world.h"

namespace tremolo::testing {

constexpr double kG = 9.81;  // m/s^2

inline SceneBody rigid_body(const std::string& name, const Collider& shape,
                            const Eigen::Vector3d& position, double density = 1000.0) {
  SceneBody body;
  body.name = name;
  body.kind = FrameKind::kFree;
  body.rigid.emplace();
  body.rigid->shape = shape;
  body.rigid->density = density;
  body.pose.position = position;
  return body;
}

inline SceneCollider floor_with(double friction, double restitution = 0.0) {
  SceneCollider floor;
  floor.name = "floor";
  floor.shape = PlaneShape{};
  floor.friction = friction;
  floor.restitution = restitution;
  return floor;
}

// One body above a floor, with gravity as on a slope of that angle that falls along x.
inline Scene on_slope(const SceneBody& body, double angle, double friction, double step) {
  Scene scene;
  scene.step = step;
  scene.duration = 1000.0;
  scene.gravity.values = {{kG * std::sin(angle), 0.0, -kG * std::cos(angle)}};
  scene.bodies = {body};
  scene.colliders = {floor_with(friction)};
  return scene;
}

inline SceneWorld make_world(const Scene& scene, const ModelSource& source = load_scene_model) {
  Result<SceneWorld> world = SceneWorld::create(scene, source);
  EXPECT_TRUE(world) << (world ? "" : world.error().message);
  return std::move(*world);
}

// Takes steps until `time`, s; calls look() after each.
template <class Look>
void run_until(SceneWorld& world, double time, const Look& look) {
  while (world.time() < time - 0.5 * world.step_size()) {
    const auto failed = world.step();
    if (!failed.empty()) FAIL() << why_not_made(failed[0].report, world.time());
    look();
  }
}
inline void run_until(SceneWorld& world, double time) {
  run_until(world, time, [] {});
}

// The acceleration of the centre along x between the times, from its velocities, m/s^2.
inline double acceleration(SceneWorld& world, double from, double to) {
  run_until(world, from);
  const double before = world.body(0).rigid_state().velocity.x(), begin = world.time();
  run_until(world, to);
  return (world.body(0).rigid_state().velocity.x() - before) / (world.time() - begin);
}

inline Eigen::Vector3d centre_of(const SceneWorld& world, std::size_t i) {
  return world.body(i).rigid_state().centre;
}

// Follows the sum of all balances: energy plus what was taken never grows.
struct Growth {
  double most = 0.0, worst = 0.0;

  void look(const SceneWorld& world) {
    double remainder = 0.0, energy = 0.0;
    for (std::size_t i = 0; i < world.size(); ++i) {
      remainder += world.account(i).remainder();
      energy += world.account(i).total();
    }
    most = std::max(most, std::abs(energy));
    worst = std::max(worst, std::abs(remainder));
  }
};

}  // namespace tremolo::testing
