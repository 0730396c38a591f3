// The members of a ClothWorld; only its own files include this.
#pragma once

#include <memory>
#include <vector>

#include "runtime/bodies/cloth/ball_motion.h"
#include "runtime/bodies/cloth/cloth_contact.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/bodies/cloth/cloth_reactions.h"
#include "runtime/bodies/cloth/cloth_world.h"
#include "runtime/scene/scene_colliders.h"

namespace tremolo {

// A cloth of the world. It does not move in memory, because the integrator has the model's address.
struct WorldCloth {
  SceneCloth scene;
  ClothModel model;
  NodalState state, before;  // before: at the start of the step
  std::unique_ptr<NodalIntegrator> integrator;
  std::unique_ptr<ClothReactions> reactions;  // null: the method solves no equations
  bool touched = false;                       // contact acted in this step
};

// Kinetic energy of the particles that are not held, J.
double free_cloth_kinetic(const WorldCloth& cloth);

// A grab of the scene.
struct WorldHand {
  std::size_t cloth = 0, particle = 0;
  MotionPath path;
  double from = 0.0, until = kForEver;
  bool holds = false, over = false;
  // Position of its particle when it was grabbed, without the motion, m.
  Eigen::Vector3d base = Eigen::Vector3d::Zero();
};

struct ClothWorld::Inside {
  ClothScene scene;
  std::vector<std::unique_ptr<WorldCloth>> cloths;
  std::vector<ContactCloth> touching;  // the same cloths
  std::vector<MovingBall> balls;
  std::vector<Ball> shown;
  SceneColliders colliders;
  std::vector<WorldHand> hands;
  ClothContact contact;
  ClothSurroundings around;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  ClothEnergy sums;
  double limit = 0.0;
  double penetration = 0.0;
  std::int64_t steps = 0, iterations = 0, cut_steps = 0;

  Status add_cloth(const SceneCloth& wanted);
  Status check_limit() const;
  Status add_hand(const ClothHand& wanted);
  void hold(WorldCloth& cloth, std::size_t particle, const Eigen::Vector3d& at);
  void let_go(WorldCloth& cloth, std::size_t particle);
  void move_hands();
  // Refuses free particles that start inside a ball or a collider, and triangles cut by a sphere
  // between their particles.
  Status check_apart() const;
  Status check_particles(const WorldCloth& cloth) const;
  void set_weather(double t);
  void release_pins(double t);
  Status advance_cloths(double t);
  void make_reactions();
  bool solves_steps() const;
  void begin_contact(double t, double h);
  void push_balls(double h);
  void settle(WorldCloth& cloth, std::size_t number, double h);
  bool settle_all(double h);
  bool stands_still() const;
  double take_excess(double excess);
  bool touch(double t, double h);
  double present() const;
  double given() const;
  bool project(double h);
  void add_present(ClothEnergy& energy) const;
};

}  // namespace tremolo
