// A body whose support follows given poses (docs/theory.md, section "A body in a world"):
//
//     q'' + D q' + R(q) = f - S^T a - E(q) - grad Phi(q; omega) - 2 G(omega) q'
//
//     a = Ro^T (c'' - g), E_i = omega'.(a_i + sum_j c_ji q_j), Phi = -1/2 omega^T J(q) omega,
//     G_ij = omega.c_ji
//
// All values of the frame are those at the middle of the step: omega from the two poses,
// accelerations from the difference of the velocities of neighbouring steps, which is of second
// order.
//
// A body may hang on several bones. Each is a frame of its own and has the weight w_b(X) of the
// mass at X (docs/theory.md, "A body on bones"). s, a, P and c are sums over bones, each with the
// integrals of its weighted mass. The weights add up to one and so do the integrals, and the
// kinetic energy relative to the bones is 1/2 |q'|^2 as with one frame.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include <Eigen/LU>

#include "runtime/bodies/reduced/frames/frame_inertia.h"
#include "runtime/bodies/reduced/frames/step_coupling.h"
#include "runtime/math/pose.h"
#include "runtime/math/state.h"

namespace tremolo {

// Motion of the frame in one step, at mid-step.
struct FrameMotion {
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // c'', m/s^2, world
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();          // omega, rad/s, along the body's axes
  Eigen::Vector3d spin_rate = Eigen::Vector3d::Zero();     // omega', rad/s^2, along the body's axes
};

// The motion in the step between `middle[0]` and `middle[1]`, from these and the poses a step
// before and after them.
FrameMotion motion_between(const Pose& before, const Pose& start, const Pose& end,
                           const Pose& after, double step);

class DrivenFrame final : public StepCoupling {
 public:
  // inertia: about the mesh's origin.
  DrivenFrame(std::shared_ptr<const FrameInertia> inertia, double step);
  // One inertia per bone, at least one: that of the bone's weighted mass.
  DrivenFrame(const std::vector<std::shared_ptr<const FrameInertia>>& shares, double step);

  // Sets the step, s, from the next step on.
  void set_step(double step) { step_ = step; }

  std::size_t bones() const { return bones_.size(); }
  const Pose& pose(std::size_t bone = 0) const { return bones_[bone].pose; }
  // At the end of the next step.
  const Pose& next_pose(std::size_t bone = 0) const { return bones_[bone].next; }

  // Moves a bone to a pose, at rest, without an impulse.
  void teleport(const Pose& pose, std::size_t bone = 0);

  // Sets the pose of a bone at the end of the next step; without a call the bone is at rest.
  // Without the motion only the past is known: the accelerations are those of the last two nodes,
  // extrapolated linearly to the middle of the step.
  void move_to(const Pose& next, std::size_t bone = 0);
  void move_to(const Pose& next, const FrameMotion& motion, std::size_t bone = 0);

  // Prepares rotations and forces of the next step. gravity: m/s^2, world.
  void prepare(const Eigen::Vector3d& gravity);
  const Eigen::Matrix3d& mid_rotation(std::size_t bone = 0) const {
    return bones_[bone].mid_rotation;
  }
  // Force of gravity at the present poses, r.
  Eigen::VectorXd gravity_force(const Eigen::Vector3d& gravity) const;
  // -S^T a and the constant parts of E and grad Phi, r; to be added to the step's load.
  const Eigen::VectorXd& push() const { return push_; }
  bool turning() const { return turning_; }

  // Half of the rotating frame's effect in a step, for methods outside the energy-preserving
  // family: a kick and a rotation of the velocity (`first` half: in the opposite order). Second
  // order with the step between two of these.
  void half_turn(bool first, State& state);

  // Ends the step from q0 to q1: the frame reaches its next pose. Adds to the work.
  void end_step(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1);
  // For a prepared step that is taken in parts, each ended by end_step(): take_part() sets the
  // poses of the part [from, to], fractions of the step; forces are those of the whole step's
  // middle. end_parts() sets the history of the whole step, after the last part or a failure.
  void start_parts();
  void take_part(double from, double to);
  void end_parts();
  // Cancels a failed step and the work that was added for it.
  void cancel_step();

  // Work of all bones on the motion relative to them, J.
  double support_work() const { return support_work_; }
  double gravity_work() const { return gravity_work_; }  // J, of gravity on the same motion

  // Saves or restores the state between steps.
  void carry(StateStream& stream) {
    for (Bone& bone : bones_) {
      stream(bone.pose, bone.next, bone.motion.acceleration, bone.motion.spin);
      stream(bone.motion.spin_rate, bone.known, bone.velocity, bone.spin, bone.acceleration);
      stream(bone.spin_rate);
    }
    stream(support_work_, gravity_work_);
  }

  void begin(double h, const Eigen::VectorXd& q0, const Eigen::VectorXd& v0) override;
  void evaluate(const Eigen::VectorXd& d, const Eigen::VectorXd& S, Eigen::VectorXd& dp,
                Eigen::VectorXd& force) override;
  bool changes_momentum() const override { return false; }
  double force_scale() const override { return push_norm_; }
  bool finish(const Eigen::VectorXd& d, double defect, Eigen::VectorXd& v) override;

 private:
  struct Bone {
    std::shared_ptr<const FrameInertia> inertia;
    Pose pose, next;
    FrameMotion motion;
    bool known = false;  // motion was given
    // velocity, m/s, and spin, rad/s, are those of the last step.
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), spin = Eigen::Vector3d::Zero();
    // At the node before that step: changes of velocity and spin over the step.
    Eigen::Vector3d acceleration = Eigen::Vector3d::Zero(), spin_rate = Eigen::Vector3d::Zero();
    Eigen::Matrix3d mid_rotation = Eigen::Matrix3d::Identity();
    bool turning() const { return !motion.spin.isZero(0.0) || !motion.spin_rate.isZero(0.0); }
  };

  void find_motion(Bone& bone) const;
  void take_next(Bone& bone) const;
  void add_turn(const Bone& bone);

  std::vector<Bone> bones_, whole_;  // whole_: before the first part
  double step_;
  bool turning_ = false;
  Eigen::VectorXd push_, gravity_push_;
  double push_norm_ = 0.0;
  // Matrices of E and grad Phi, not symmetric, 1/s^2, and 2 G, skew, 1/s: r x r, followed by unused
  // rows.
  Eigen::MatrixXd stiffness_, gyro_;
  Eigen::MatrixXd turn_;  // I + (h/4) 2 G, and its factor
  Eigen::PartialPivLU<Eigen::MatrixXd> turn_factor_;
  double h_ = 0.0;
  Eigen::VectorXd q0_, x_;
  Eigen::VectorXd stiff_, whirl_;  // their products with q and d, tall_rows(r)
  double turned_work_ = 0.0;       // of stiffness_ in this step
  double support_work_ = 0.0, gravity_work_ = 0.0;
};

}  // namespace tremolo
