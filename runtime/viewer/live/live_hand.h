// The user's hand: it pulls the point that a ray has hit, as a scene's hand would.
#pragma once

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/scene/scene_world.h"

namespace tremolo {

// Stiffness and damping that suit a vertex, N/m and N s/m. The body follows four fifths of the
// hand's displacement where only the elastic force resists; a free body oscillates at 2 Hz about
// the hand. The damping is half critical.
struct HandSprings {
  double stiffness = 0.0, damping = 0.0;
};
HandSprings suitable_springs(const ContactBody& body, const VertexRows& place);

class LiveHand {
 public:
  // Enables every body of the world to be grabbed, where possible; `world` must be before its first
  // step. For a body that cannot be grabbed take() returns the reason.
  static void make_holdable(SceneWorld& world);

  // Grabs the vertex with the largest weight at the hit point, with springs `firmness` times the
  // suitable ones. Errors: kUsage if the body cannot be grabbed or the vertex does not move.
  Status take(SceneWorld& world, const SceneWorld::Hit& hit, double firmness);
  // way: displacement of the hand, from the vertex's position when it was grabbed to the end of the
  // next step, m, world.
  void move(const Eigen::Vector3d& way) { way_ = way; }
  // Call this before each step of the world.
  void before_step(SceneWorld& world);
  void let_go(SceneWorld& world);

  bool holds() const { return number_.has_value(); }
  std::size_t body() const { return body_; }
  VertexId vertex() const { return vertex_; }
  HandSprings springs() const { return springs_; }
  // Present and initial position of the hand, m, world.
  Eigen::Vector3d point() const { return begun_ + way_; }
  const Eigen::Vector3d& begun() const { return begun_; }
  const Eigen::Vector3d& way() const { return way_; }
  // Position of the vertex, m, world; only while holds().
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
