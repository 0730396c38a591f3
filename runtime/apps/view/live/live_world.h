// A running world with its last two states and the user's hand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/apps/view/camera/camera.h"
#include "runtime/apps/view/live/live_guests.h"
#include "runtime/apps/view/live/viewed_scene.h"
#include "runtime/apps/view/live/world_moment.h"
#include "runtime/world/scene_world.h"

namespace tremolo {

// Stiffness and damping that suit a vertex, N/m and N s/m. The body follows four fifths of the
// hand's displacement where only the elastic force resists; a free body oscillates at 2 Hz about
// the hand. The damping is half critical.
HandSpring suitable_springs(const ContactBody& body, const VertexRows& place);

// A hand on a vertex of a body, or on a contact point of a guest.
class LiveHand {
 public:
  // Enables every body of the world to be grabbed, where possible; `world` must be before its first
  // step. For a body that cannot be grabbed take() returns the reason.
  static void make_holdable(SceneWorld& world);

  // Grabs the vertex with the largest weight at the hit point, with springs `firmness` times the
  // suitable ones. Errors: kUsage if the body cannot be grabbed or the vertex does not move.
  Status take(SceneWorld& world, const SceneWorld::Hit& hit, double firmness);
  // The same of the guest's contact point that is nearest to the vertex hit. Errors: kUsage if it
  // is fixed.
  Status take(SceneWorld& world, const LiveGuests& guests, const LiveGuests::Hit& hit,
              double firmness);
  // way: displacement of the hand, from the vertex's position when it was grabbed to the end of the
  // next step, m, world.
  void move(const Eigen::Vector3d& way) { way_ = way; }
  // Call this before each step of the world.
  void before_step(SceneWorld& world);
  void let_go(SceneWorld& world);

  bool holds() const { return number_.has_value() || guest_.has_value(); }
  // The name of the body that it holds, and the vertex, of a cloth the particle, as a scene's hand
  // has them; only while holds().
  std::string name(const SceneWorld& world) const;
  VertexId vertex() const { return vertex_; }
  HandSpring springs() const { return springs_; }
  // Present and initial position of the hand, m, world.
  Eigen::Vector3d point() const { return begun_ + way_; }
  const Eigen::Vector3d& begun() const { return begun_; }
  const Eigen::Vector3d& way() const { return way_; }
  // Position of the vertex, m, world; only while holds().
  Eigen::Vector3d held(const SceneWorld& world) const;

 private:
  std::size_t body_ = 0;  // not of a guest
  VertexId vertex_ = 0;
  VertexRows place_;
  HandSpring springs_;
  Eigen::Vector3d begun_ = Eigen::Vector3d::Zero(), way_ = Eigen::Vector3d::Zero();
  std::optional<std::size_t> number_;
  // Instead of body_ to number_, where a guest is held.
  struct GuestHold {
    MixedGuests* guests = nullptr;
    std::size_t guest = 0, point = 0, number = 0;
  };
  std::optional<GuestHold> guest_;
};

class LiveWorld {
 public:
  // Errors of SceneWorld::create, of add_guests, and of the bodies' starts.
  static Result<LiveWorld> create(const ViewedScene& viewed, ModelCache& models);

  // Restarts with the present methods and step.
  Status begin_again(ModelCache& models);

  SceneWorld& world() { return *world_; }
  const SceneWorld& world() const { return *world_; }
  const LiveGuests& guests() const { return guests_; }
  const ViewedScene& viewed() const { return viewed_; }
  LiveHand& hand() { return hand_; }
  const LiveHand& hand() const { return hand_; }

  // The hand takes the first body that the ray meets, with springs `firmness` times the suitable
  // ones. Returns the point at which the ray meets it, m; nothing: it meets none. Errors of
  // LiveHand::take.
  Result<std::optional<Eigen::Vector3d>> take(const CameraRay& ray, double firmness);

  // Steps the world. A body whose step fails stays at rest from then on, and trouble() gives the
  // reason. Errors of look_at_world.
  Status step();
  // The message of the first body that failed; empty: none has. code: its exit code.
  const std::string& trouble() const { return trouble_; }
  int trouble_code() const { return trouble_code_; }

  // Moments before and after the last step; the same before the first.
  const WorldMoment& before() const { return moments_[1 - newest_]; }
  const WorldMoment& now() const { return moments_[newest_]; }
  // The state at t, s, interpolated between these two; outside of them the nearer one.
  void at(double t, WorldMoment& out) const;
  // Looks again, where something has been changed from outside.
  Status refresh();

 private:
  LiveWorld() = default;
  Status begin(ModelCache& models);
  Status look(WorldMoment& moment) const;
  void note_trouble(std::span<const SceneWorld::Failure> failures, double from);

  ViewedScene viewed_;
  std::unique_ptr<SceneWorld> world_;
  LiveGuests guests_;
  LiveHand hand_;
  std::vector<VertexRows> held_;  // by the scene's hands, empty of those on guests
  WorldMoment moments_[2];
  int newest_ = 0;
  std::string trouble_;
  int trouble_code_ = 0;
};

}  // namespace tremolo
