// A body whose support follows given poses (docs/theory.md, section "A body in a world"):
//
//     q'' + D q' + R(q) = f - S^T a - E(q) - grad Phi(q; omega) - 2 G(omega) q'
//
//     a = Ro^T (c'' - g), E_i = omega'.(a_i + sum_j c_ji q_j), Phi = -1/2 omega^T J(q) omega,
//     G_ij = omega.c_ji
//
// Everything of the frame is taken at the middle of the step: omega from the two poses,
// accelerations by the difference of the velocities of neighbouring steps, which is of second
// order.
#pragma once

#include <memory>

#include <Eigen/LU>

#include "runtime/frames/frame_inertia.h"
#include "runtime/frames/pose.h"
#include "runtime/frames/step_coupling.h"
#include "runtime/values/state.h"

namespace tremolo {

// How the frame moves in one step. acceleration: c'', world, m/s^2. spin: omega, spin_rate: omega',
// both along the body's axes, rad/s and rad/s^2. All at mid-step.
struct FrameMotion {
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin_rate = Eigen::Vector3d::Zero();
};

// The motion in the step between `middle[0]` and `middle[1]`, from these and the poses a step
// before and after them.
FrameMotion motion_between(const Pose& before, const Pose& start, const Pose& end,
                           const Pose& after, double step);

class DrivenFrame final : public StepCoupling {
 public:
  // inertia: about the mesh's origin.
  DrivenFrame(std::shared_ptr<const FrameInertia> inertia, double step);

  const Pose& pose() const { return pose_; }
  const Pose& next_pose() const { return next_; }  // at the end of the step to come

  // Puts the frame elsewhere, at rest, without a kick.
  void teleport(const Pose& pose);

  // Where the frame is at the end of the next step; without a call it stands still. The first form
  // knows what was, not what comes: its accelerations are those of the last two nodes, carried on
  // linearly to the middle of the step.
  void move_to(const Pose& next);
  void move_to(const Pose& next, const FrameMotion& motion);

  // Of the next step: turns and forces. gravity: m/s^2, world.
  void prepare(const Eigen::Vector3d& gravity);
  const FrameMotion& motion() const { return motion_; }
  Eigen::Matrix3d mid_rotation() const { return mid_rotation_; }
  // -S^T a and the constant parts of E and grad Phi, r; to be added to the step's load.
  const Eigen::VectorXd& push() const { return push_; }
  bool turning() const { return turning_; }

  // Half of what the turning frame does in a step, for methods that are not of the
  // energy-preserving family: a kick and a turn of the velocity (`first` half: the other way
  // round). Of second order with the step between two of these.
  void half_turn(bool first, State& state);

  // After the step from q0 to q1: the frame is where it was to go. Books the work.
  void end_step(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1);
  // The step was not made: what it booked is taken back.
  void cancel_step();

  double support_work() const { return support_work_; }  // J, on the motion relative to the frame
  double gravity_work() const { return gravity_work_; }  // J, likewise

  // What is carried between steps.
  void carry(StateStream& stream) {
    stream(pose_, next_, motion_.acceleration, motion_.spin, motion_.spin_rate, known_);
    stream(velocity_, spin_, acceleration_, spin_rate_, support_work_, gravity_work_);
  }

  void begin(double h, const Eigen::VectorXd& q0, const Eigen::VectorXd& v0) override;
  void evaluate(const Eigen::VectorXd& d, const Eigen::VectorXd& S, Eigen::VectorXd& dp,
                Eigen::VectorXd& force) override;
  double force_scale() const override { return push_norm_; }
  bool finish(const Eigen::VectorXd& d, double defect, Eigen::VectorXd& v) override;

 private:
  void prepare_turn();

  std::shared_ptr<const FrameInertia> inertia_;
  double step_;
  Pose pose_, next_;
  FrameMotion motion_;
  bool known_ = false;  // motion_ was given
  bool turning_ = false;
  // Of the last step: velocity, m/s, and spin; at the node before it: their changes over the step.
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero(), spin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_ = Eigen::Vector3d::Zero(), spin_rate_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d mid_rotation_ = Eigen::Matrix3d::Identity();
  Eigen::VectorXd push_, gravity_push_;
  double push_norm_ = 0.0;
  Eigen::MatrixXd stiffness_;  // of E and grad Phi, r x r, not symmetric, 1/s^2
  Eigen::MatrixXd gyro_;       // 2 G, r x r, skew, 1/s
  Eigen::MatrixXd turn_;       // I + (h/4) 2 G, and its factor
  Eigen::PartialPivLU<Eigen::MatrixXd> turn_factor_;
  double h_ = 0.0;
  Eigen::VectorXd q0_, x_, stiff_;
  double turned_work_ = 0.0;  // of stiffness_ in this step
  double support_work_ = 0.0, gravity_work_ = 0.0;
};

}  // namespace tremolo
