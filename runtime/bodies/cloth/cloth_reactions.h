// Contact reactions on particles in an implicit step, found together with the end of the step.
//
//   distance(x1) >= thickness,   f >= 0,   f = 0 where the distance is larger
//
// Each reaction is f = l - k m.(x1 - p), where p is the point of the surface nearest to x1. After a
// solve l becomes f, and p and m are found again. Reactions that would pull are removed, and
// particles that are inside get one; then the solve continues. This is an active set (Hueeber and
// Wohlmuth 2005) with Hestenes's multipliers (1969), so that k need not be large.
//
// f acts at the end of the step alone, with all of the step's impulse (Kane, Repetto, Ortiz and
// Marsden 1999). m is the normal in the middle of the particle's path relative to the surface. For
// a plane and a ball m.(x1 - x0) is then the change of the distance, and the work of f over the
// step, f (d1 - d0) with d1 = thickness, is never positive.
//
// Friction is an impulse that is found after the solve, from the slip that is left. What it was in
// the last step acts as a known force in the solve: what sticks is then in equilibrium at its
// place, and nothing of the slip is left. Without that it would move by h^2 times its acceleration.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/cloth/ball_motion.h"
#include "runtime/bodies/cloth/cloth_contact.h"
#include "runtime/bodies/cloth/cloth_model.h"
#include "runtime/step/nodal_system.h"

namespace tremolo {

// Number of the ball or collider in contact; kNone: it is not one of these.
struct ParticleTouch {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::size_t ball = kNone, collider = kNone;
};

// A ball over a step.
struct BallInStep {
  // Positions, m: at the start, at the end without cloth forces (free_end), at the end with them
  // (end). push: force of all cloths on it, N.
  Eigen::Vector3d start = Eigen::Vector3d::Zero(), free_end = start, end = start, push = start;
  double give = 0.0;     // displacement per force, h^2/2m, m/N
  double relaxed = 1.0;  // fraction of the miss by which it was moved last
  Eigen::Vector3d miss = Eigen::Vector3d::Zero();  // the last one, m
  bool missed = false;
};

// The surroundings of the cloths of a scene in a step.
struct ClothSurroundings {
  std::span<MovingBall> balls;
  std::span<const PlacedCollider> colliders;
  std::vector<BallInStep> ways;  // one per ball
  double h = 0.0;                // the step, s
};

// The reaction on a particle.
struct ClothReaction {
  std::size_t particle = 0;
  ParticleTouch touch;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();         // m, length 1
  Eigen::Vector3d solved_normal = Eigen::Vector3d::UnitZ();  // m in the last solve
  Eigen::Vector3d place = Eigen::Vector3d::Zero();           // p, m
  double stiffness = 0.0;                                    // k, N/m
  double force = 0.0;                                        // l, N
  // On the particle, N s, of the step so far; in its parts m may have been another normal.
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  // The known friction, N; its impulse of the step so far, N s; the time for which it acted, s.
  Eigen::Vector3d rub = impulse, rubbed = impulse;
  double rub_time = 0.0;
  bool presses = true;  // it acts

  double force_at(const Eigen::VectorXd& x) const {
    const auto at = 3 * static_cast<Eigen::Index>(particle);
    return force - stiffness * normal.dot(x.segment<3>(at) - place);
  }
};

// Reactions on one cloth. They cover the first 64 balls and colliders; others act by projection
// alone.
class ClothReactions : public NodalContact {
 public:
  // All arguments must outlive it.
  ClothReactions(const ClothModel& model, ClothSurroundings& around, double thickness,
                 double friction);

  // Starts a step from `state`, with the reactions of the last step and those of particles that
  // would be inside if they continued their motion.
  void begin(const NodalState& state);

  void start() override { round_ = 0; }
  // Does a round; there are at most kRounds of them.
  bool revise(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) override;
  void add_force(const Eigen::VectorXd& x1, Eigen::VectorXd& f) const override;
  void add_tangent(BlockMatrix& a) const override;
  double work(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1, double share) const override;
  void keep(const Eigen::VectorXd& x1, double h, double share) override;
  bool pressed() const override { return pressed_last_; }

  // Reactions of the step so far; those that no longer act still have an impulse.
  std::span<const ClothReaction> all() const { return reactions_; }
  // Friction on reaction number i was this impulse in all, N s.
  void remember_friction(std::size_t i, const Eigen::Vector3d& impulse) {
    ClothReaction& r = reactions_[i];
    r.rub = Eigen::Vector3d::Zero();
    if (r.presses && r.rub_time > 0.0) r.rub = impulse / r.rub_time;
  }

 private:
  static constexpr int kRounds = 12;
  // In later rounds no reaction is added: particles that are still inside are projected.
  static constexpr int kAddingRounds = 8;

  CollisionDistance nearest(const ParticleTouch& touch, const Eigen::Vector3d& x) const;
  Eigen::Vector3d way_of(const ParticleTouch& touch, const Eigen::Vector3d& x0) const;
  double aim(ClothReaction& reaction, const Eigen::Vector3d& x0, const Eigen::Vector3d& x1) const;
  bool add_what_is_inside(const Eigen::VectorXd& x0, const Eigen::VectorXd& x1);
  bool let_go();
  bool limit_friction();
  bool move_balls(double share);
  double stiffness_of(std::size_t particle) const;

  const ClothModel& model_;
  ClothSurroundings& around_;
  double thickness_, friction_;
  std::vector<ClothReaction> reactions_;
  std::vector<std::uint64_t> pressed_;   // for each particle one bit per ball and collider
  std::vector<Eigen::Vector3d> pushes_;  // on balls, N
  Eigen::VectorXd ahead_;
  int round_ = 0;
  bool pressed_last_ = false;
};

// Position of a ball at x after it is moved out of fixed colliders, m.
Eigen::Vector3d clear_of(std::span<const PlacedCollider> colliders, double radius,
                         const Eigen::Vector3d& x);

}  // namespace tremolo
