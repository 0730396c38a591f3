// What a ClothWorld is made of; for its own files alone.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "runtime/cloth/ball_motion.h"
#include "runtime/cloth/cloth_contact.h"
#include "runtime/cloth/cloth_model.h"
#include "runtime/cloth/cloth_world.h"
#include "runtime/scene/scene_colliders.h"

namespace tremolo {

// Does not move in memory: the integrator has the model's address. before: the state in which the
// step began.
struct WorldCloth {
  SceneCloth scene;
  ClothModel model;
  NodalState state, before;
  std::unique_ptr<NodalIntegrator> integrator;
};

struct ClothWorld::Inside {
  ClothScene scene;
  std::vector<std::unique_ptr<WorldCloth>> cloths;
  std::vector<ContactCloth> touching;  // the same
  std::vector<MovingBall> balls;
  std::vector<Ball> shown;
  SceneColliders colliders;
  ClothContact contact;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  ClothEnergy told;
  double limit = 0.0;
  double penetration = 0.0;
  std::int64_t steps = 0, iterations = 0, cut_steps = 0;

  Status add_cloth(const SceneCloth& wanted);
  Status check_limit();
  Status check_apart() const;
  void set_weather(double t);
  void release_pins(double t);
  Status advance_cloths(double t);
  void lean(double h);
  std::optional<Eigen::Vector3d> will_touch(const WorldCloth& cloth, Eigen::Index at, double h,
                                            ParticleTouch& touch) const;
  void push_back(double h);
  void push_back_from(std::size_t c, const ClothLean& lean, double reaction, double h);
  void project(double h);
  void add_present(ClothEnergy& energy) const;
};

}  // namespace tremolo
