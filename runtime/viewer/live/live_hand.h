// The user's hand: it pulls at what a ray has met, as a scene's hand would.
#pragma once

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/scene/scene_world.h"

namespace tremolo {

// Stiffness and damping that suit a vertex: so stiff that the body goes four fifths of the hand's
// way where only the elastic force resists (of a free body: its mass, at 2 Hz), so damped that the
// pull does not ring. N/m, N s/m.
struct HandSprings {
  double stiffness = 0.0, damping = 0.0;
};
HandSprings suitable_springs(const ContactBody& body, const VertexRows& place);

class LiveHand {
 public:
  // Lets every body of the world be held that can be; `world` must not have made a step. Where one
  // cannot the reason is told by take().
  static void make_holdable(SceneWorld& world);

  // Takes hold of the vertex that weighs most where the ray has hit, and draws from now on at
  // firmness times the suitable springs. Errors: kUsage where the body takes no hand, or the vertex
  // does not move.
  Status take(SceneWorld& world, const SceneWorld::Hit& hit, double firmness);
  // Where the hand shall be at the end of the next step, m, world: from the vertex's place, by how
  // far the user has moved since.
  void move(const Eigen::Vector3d& way) { way_ = way; }
  // Before each step of the world.
  void before_step(SceneWorld& world);
  void let_go(SceneWorld& world);

  bool holds() const { return number_.has_value(); }
  std::size_t body() const { return body_; }
  VertexId vertex() const { return vertex_; }
  HandSprings springs() const { return springs_; }
  // Where it is and began, m, world.
  Eigen::Vector3d point() const { return begun_ + way_; }
  const Eigen::Vector3d& begun() const { return begun_; }
  const Eigen::Vector3d& way() const { return way_; }
  // Where the vertex is, m, world; while it holds.
  Eigen::Vector3d held(const SceneWorld& world) const;

 private:
  std::size_t body_ = 0;
  VertexId vertex_ = 0;
  VertexRows place_;
  HandSprings springs_;
  Eigen::Vector3d begun_ = Eigen::Vector3d::Zero(), way_ = Eigen::Vector3d::Zero();
  std::optional<std::size_t> number_;
};

}  // namespace tremolo
