// A body without support: six rigid degrees of freedom, coupled to the vibration in both directions
// (docs/theory.md, section "A body in a world").
//
//     T = 1/2 m |V|^2 + 1/2 omega^T J(q) omega + omega.C(q) v + 1/2 |v|^2,   v = q'
//     p = v + C(q)^T omega,    L = J(q) omega + C(q) v,    L' = L x omega + torque
//     p_j' = -dV/dq_j - (D v)_j + 1/2 omega^T d_jJ omega + omega.sum_k c_jk v_k + f_j
//
// omega, L along the body's axes; V and forces along the world's. The step, with mean values m, v~,
// omega~ of its ends, y~ that of X + U q, and Ro~ that of the rotations,
//
//     N (q1 - q0)/h = (v0 + v1)/2 + theta h D (p1 - p0)
//     N (p1 - p0)/h = -(mean of grad V) - D d/h + f + g
//     g_j = 1/2 [omega0^T d_jJ(m) omega1 + omega0.sum_k c_jk v1_k + omega1.sum_k c_jk v0_k]
//     Ro1 = Ro0 cay(h omega~),   l1 = l0 + h sum (Ro~ y~) x F,   f = U^T Ro~^T F
//     J(q1) omega1 + C(q1) v1 = Ro1^T l1
//
// where l is the spatial angular momentum about the centre of mass. The step conserves l and the
// linear momentum to rounding, and the energy except for loads, gravity and damping. With y = (v,
// omega), T = 1/2 y^T M(q) y gives T1 - T0 = v~.(p1 - p0) + omega~.(L1 - L0) - g.d, and because
// omega~ is the axis of the Cayley rotation, omega~.(L1 - L0) is h omega~ times the torque. The
// step is time-reversible and of second order.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "runtime/bodies/reduced/frames/frame_inertia.h"
#include "runtime/bodies/reduced/frames/step_coupling.h"
#include "runtime/math/pose.h"
#include "runtime/math/state.h"

namespace tremolo {

// The rigid part of a free body's state.
struct RigidState {
  // Of mass, m, world; the position is centre + centre_rest.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  // The part of the centre that the sum over all steps would lose to rounding, m.
  Eigen::Vector3d centre_rest = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();            // m/s, world
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  // of length one
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();  // omega, rad/s, along the body's axes
  // Spatial angular momentum about the centre of mass, N m s, world.
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
};

inline void carry(StateStream& stream, RigidState& rigid) {
  stream(rigid.centre, rigid.centre_rest, rigid.velocity, rigid.rotation, rigid.spin);
  stream(rigid.momentum);
}

// A force on a vertex, constant over one step.
struct StepForce {
  const VertexRows* place = nullptr;                // the vertex, about the mesh's origin
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // N, world
};

class FreeFrame final : public StepCoupling {
 public:
  // inertia: about the centre of mass.
  explicit FreeFrame(std::shared_ptr<const FrameInertia> inertia);

  const RigidState& rigid() const { return rigid_; }
  Pose pose() const;  // of the mesh's frame

  // Moves the mesh's frame to the pose; momenta rotate with it.
  void set_pose(const Pose& pose, const Eigen::VectorXd& q, const Eigen::VectorXd& v);
  // velocity: of the centre of mass, world, m/s. spin: along the body's axes, rad/s.
  void set_motion(const Eigen::Vector3d& velocity, const Eigen::Vector3d& spin,
                  const Eigen::VectorXd& q, const Eigen::VectorXd& v);
  void restore(const RigidState& rigid) { rigid_ = rigid; }

  // Kinetic energy with that of the vibration, J.
  double kinetic(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const;
  Eigen::Vector3d linear_momentum() const { return inertia_->mass * rigid_.velocity; }
  // About the world's origin, N m s.
  Eigen::Vector3d angular_momentum() const {
    const Eigen::Vector3d linear = linear_momentum();
    return rigid_.momentum + rigid_.centre.cross(linear) + rigid_.centre_rest.cross(linear);
  }

  // Prepares the next step: forces, which must stay in memory until it ends; gravity, m/s^2.
  void prepare(std::span<const StepForce> forces, const Eigen::Vector3d& gravity);
  // Prepares the same forces and gravity again, for the next part of the step.
  void prepare_again() { prepare(forces_, gravity_); }
  // Work in the last step that succeeded, J.
  double load_work() const { return load_work_; }
  double gravity_work() const { return gravity_work_; }

  // For solvers with more forces, which depend on the end of the step: evaluate() at a given omega1
  // = w.
  struct SpinTrial {
    Eigen::Vector3d residual;  // J1 w + C1 v1 - Ro1^T l1, N m s, with the forces of prepare() only
    Eigen::Matrix3d jacobian;  // derivative of the residual by w
    Eigen::Matrix3d turn;      // cay(h omega~)
  };
  SpinTrial try_spin(const Eigen::VectorXd& d, const Eigen::VectorXd& S, const Eigen::Vector3d& w,
                     Eigen::VectorXd& dp, Eigen::VectorXd& force);
  // C1, 3 x r.
  const Eigen::Matrix3Xd& end_coupling() const { return at1_.C; }
  // m (e/h - V0) 2/h - sum of F - m g for the path e of the centre, N, with the forces of
  // prepare().
  Eigen::Vector3d centre_residual(const Eigen::Vector3d& e) const;
  double mass() const { return inertia_->mass; }
  const Eigen::Vector3d& mesh_centre() const { return inertia_->centre; }
  // Sets the result of such a solver for evaluate() and finish(): a force (N, world) and the mean
  // torque about the centre (N m, along the body's axes at the start). Valid until the next
  // prepare().
  void set_contact(const Eigen::Vector3d& force, const Eigen::Vector3d& torque);

  void begin(double h, const Eigen::VectorXd& q0, const Eigen::VectorXd& v0) override;
  void evaluate(const Eigen::VectorXd& d, const Eigen::VectorXd& S, Eigen::VectorXd& dp,
                Eigen::VectorXd& force) override;
  double unsolved() const override { return unsolved_; }
  bool changes_momentum() const override { return true; }
  double force_scale() const override { return force_norm_; }
  bool finish(const Eigen::VectorXd& d, double defect, Eigen::VectorXd& v) override;

 private:
  void set_end(const Eigen::VectorXd& d);
  void add_forces(Eigen::VectorXd& dp, Eigen::VectorXd& force);
  SpinTrial spin_equation(const Eigen::Matrix3d& inertia, const Eigen::Vector3d& coupled,
                          const Eigen::Vector3d& w);
  Eigen::Matrix3d begin_spin(const Eigen::VectorXd& S, const Eigen::VectorXd& dp);
  void end_spin(const Eigen::VectorXd& S, const Eigen::VectorXd& dp);
  void find_spin(const Eigen::VectorXd& S, const Eigen::VectorXd& dp);
  Eigen::Vector3d torque(const Eigen::Matrix3d& mean_turn) const;
  void move_centre();

  std::shared_ptr<const FrameInertia> inertia_;
  RigidState rigid_;
  std::span<const StepForce> forces_;
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  double load_work_ = 0.0, gravity_work_ = 0.0;

  // Within a step. "0" and "1" are its ends; vectors are along the body's axes at its start.
  double h_ = 0.0;
  Eigen::VectorXd q0_, q1_, v0_, v1_, m_;
  InertiaAt at0_, at1_;
  bool at_end_ = false;  // at1_ is that of q1_
  mutable InertiaAt scratch_;
  Eigen::VectorXd kick0_;                                    // C0^T omega0
  Eigen::VectorXd bend0_, bend1_;                            // 3r: rows m r + j: sum_k (c_m)_jk v_k
  Eigen::VectorXd kappa_;                                    // C1^T omega1 - C0^T omega0
  Eigen::VectorXd added_;                                    // added by evaluate() to the force
  Eigen::Vector3d momentum0_;                                // Ro0^T l0
  Eigen::Vector3d spin1_;                                    // omega1
  double unsolved_ = 0.0;                                    // of find_spin(), N m s
  Eigen::Vector3d momentum1_;                                // Ro1^T l1
  Eigen::Vector3d torque_ = Eigen::Vector3d::Zero();         // mean, along the axes at the start
  Eigen::Vector3d total_force_ = Eigen::Vector3d::Zero();    // world, without contact
  Eigen::Vector3d contact_force_ = Eigen::Vector3d::Zero();  // world
  Eigen::Vector3d contact_torque_ = Eigen::Vector3d::Zero();  // part of torque_
  std::vector<Eigen::Vector3d> arms_;                         // y~ of each force, body
  std::vector<Eigen::Vector3d> pulls_;                        // Ro0^T F
  double force_norm_ = 0.0;
};

}  // namespace tremolo
