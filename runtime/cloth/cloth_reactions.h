// What particles press on in an implicit step: reactions at its end, found together with it.
//
//   distance(x1) >= thickness,   f >= 0,   f = 0 where the distance is larger
//
// Each reaction is f = l - k m.(x1 - p), p the place on the surface nearest to x1. After a solve l
// becomes f, p and m are found anew, what would pull is let go and what is inside is added; then
// the solve goes on: an active set (Hueeber and Wohlmuth 2005) with Hestenes's multipliers (1969),
// so that k need not be large.
//
// f acts at the end of the step alone, and with all of the step's impulse (Kane, Repetto, Ortiz and
// Marsden 1999). m is the normal in the middle of the particle's way past the surface: of a plane
// and a ball m.(x1 - x0) is then the change of the distance, and the work of f over the step, f (d1
// - d0) with d1 = thickness, is never positive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/cloth/ball_motion.h"
#include "runtime/cloth/cloth_contact.h"
#include "runtime/cloth/cloth_model.h"
#include "runtime/nodal/nodal_system.h"

namespace tremolo {

// Which ball or collider, by its number; kNone: not that.
struct ParticleTouch {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::size_t ball = kNone, collider = kNone;
};

// A ball over a step. end: where it is at its end, m, given what presses on it: push, N, of all
// cloths; free_end: without. give: by how much a newton moves it, h^2/2m, m/N.
struct BallInStep {
  Eigen::Vector3d start = Eigen::Vector3d::Zero(), free_end = start, end = start, push = start;
  double give = 0.0;
  double relaxed = 1.0;                            // share of a miss by which it was moved last
  Eigen::Vector3d miss = Eigen::Vector3d::Zero();  // the last one, m
  bool missed = false;
};

// What the cloths of a scene press on in a step of h, s.
struct ClothSurroundings {
  std::span<MovingBall> balls;
  std::span<const PlacedCollider> colliders;
  std::vector<BallInStep> ways;  // of the balls
  double h = 0.0;
};

// normal: m. place: p. stiffness: k, N/m. force: l, N. impulse: N s, on the particle, of the step
// so far, in whose parts m may have been another one.
struct ClothReaction {
  std::size_t particle = 0;
  ParticleTouch touch;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d solved_normal = Eigen::Vector3d::UnitZ();  // of the solve before the last look
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  double stiffness = 0.0;
  double force = 0.0;
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  bool presses = true;

  double force_at(const Eigen::VectorXd& x) const {
    const auto at = 3 * static_cast<Eigen::Index>(particle);
    return force - stiffness * normal.dot(x.segment<3>(at) - place);
  }
};

// Reactions on one cloth. The first 64 balls and colliders are known to it; others push by
// projection alone.
class ClothReactions : public NodalContact {
 public:
  // All must outlive it.
  ClothReactions(const ClothModel& model, ClothSurroundings& around, double thickness);

  // Before a step from `state`: with what pressed in the last one, and what particles would be in
  // if they went on as they go.
  void begin(const NodalState& state);

  void start() override { round_ = 0; }
  // A round; there are at most kRounds of them.
  bool revise(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) override;
  void add_force(const Eigen::VectorXd& x1, Eigen::VectorXd& f) const override;
  void add_tangent(BlockMatrix& a) const override;
  double work(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) const override;
  void keep(const Eigen::VectorXd& x1, double h, double share) override;
  bool pressed() const override { return pressed_last_; }

  // Reactions of the step so far; those that press no more have an impulse all the same.
  std::span<const ClothReaction> all() const { return reactions_; }

 private:
  static constexpr int kRounds = 12;
  // In later rounds nothing is added: what is left inside is projected.
  static constexpr int kAddingRounds = 8;

  CollisionDistance nearest(const ParticleTouch& touch, const Eigen::Vector3d& x) const;
  Eigen::Vector3d way_of(const ParticleTouch& touch, const Eigen::Vector3d& x0) const;
  double aim(ClothReaction& reaction, const Eigen::Vector3d& x0, const Eigen::Vector3d& x1) const;
  bool add_what_is_inside(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1);
  bool let_go();
  bool move_balls(double share);
  double stiffness_of(std::size_t particle) const;

  const ClothModel& model_;
  ClothSurroundings& around_;
  double thickness_;
  std::vector<ClothReaction> reactions_;
  std::vector<std::uint64_t> pressed_;   // a bit a ball and collider, of each particle
  std::vector<Eigen::Vector3d> pushes_;  // on balls, N
  Eigen::VectorXd ahead_;
  int round_ = 0;
  bool pressed_last_ = false;
};

// The place of a ball that is at x, out of what does not move.
Eigen::Vector3d clear_of(std::span<const PlacedCollider> colliders, double radius,
                         const Eigen::Vector3d& x);

}  // namespace tremolo
