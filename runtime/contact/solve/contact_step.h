// One step of a body that is near colliders (docs/theory.md, section "Contact"): the step of ep2
// (runtime/integrators/energy_preserving.cpp), of a free body with that of
// runtime/frames/free_frame.h, and the forces of contact_law.h on its points, all solved for
// together. A point at y = X + U q of the body takes part with f = U^T Ro~^T F and the torque
// (Ro~ y~) x F, so that F's work is F.(x1 - x0) exactly.
//
// Unknowns are d = q1 - q0 and, of a free body, omega1 and the path e of its centre: r + 6, by
// Newton's method with a line search.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/LU>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"
#include "runtime/contact/solve/contact_points.h"
#include "runtime/frames/free_frame.h"
#include "runtime/integrator.h"
#include "runtime/integrators/solve/inertia_filter.h"

namespace tremolo {

class ContactStep {
 public:
  // mass: kg.
  ContactStep(Model::Pointer model, const IntegratorOptions& options, const ContactOptions& contact,
              double mass);

  const ContactPoints& points() const { return *points_; }
  const ContactLaw& law() const { return law_; }

  // Finds the points that may touch a collider in the step from q, v. colliders must stay where
  // they are until the step is made. False if there are none: the step is made without contact.
  bool gather(std::span<const PlacedCollider> colliders, const StepPoses& poses,
              const Eigen::VectorXd& q, const Eigen::VectorXd& v);

  // The hands of the step; they must stay where they are until it is made.
  void hold(std::span<Grip> grips) { grips_ = grips; }

  // The step. free: of a free body, else null; then the poses hold. load: as for an integrator.
  // Where it does not converge, the state is as before.
  StepReport step(State& state, const StepLoad& load, FreeFrame* free);

  // Of the last step; when nothing was near, reset() instead.
  const ContactAccount& account() const { return account_; }
  void reset();
  // For each collider the impulse on it in the last step, N s; 0 where there was no contact.
  std::span<const double> impulses() const { return impulses_; }

 private:
  // What a force on a place of the body, or on a hand's vertex, does. rows: r x 3.
  struct Touch {
    Eigen::Vector3d x0 = Eigen::Vector3d::Zero(), x1 = x0;  // world
    Eigen::Vector3d arm = x0;  // of the force about the centre, along the body's axes at the start
  };
  struct Candidate {
    std::size_t point;
    std::size_t collider;
    ContactLaw law;
    ContactStart start;
    ContactForce now;
    Touch touch;
  };

  void add_candidates(const PlacedCollider& collider, std::size_t index, const Eigen::VectorXd& q,
                      double reach);
  double evaluate(const StepLoad& load, FreeFrame* free);
  template <class Rows>
  Touch touch_at(const Eigen::Vector3d& rest, const Rows& rows, const Eigen::Matrix3d& mean) const;
  template <class Rows>
  void add_force(const Eigen::Vector3d& force, const Touch& touch, const Rows& rows,
                 const Eigen::Matrix3d& mean);
  void add_grips(const Eigen::Matrix3d& mean);
  void add_contact(FreeFrame* free, const Eigen::Matrix3d& turn);
  void make_jacobian(FreeFrame* free);
  template <class Rows>
  void add_tangent(const Eigen::Matrix3d& stiffness, const Touch& touch, const Rows& rows,
                   FreeFrame* free);
  double size_of_residual(FreeFrame* free) const;
  double way_of_move(FreeFrame* free) const;
  double grips_rounding(FreeFrame* free) const;
  double size_of_motion(const StepLoad& load, FreeFrame* free) const;
  bool solve(const StepLoad& load, FreeFrame* free, StepReport& report);
  void finish(State& state, const StepLoad& load, FreeFrame* free, StepReport& report);
  void settle_grips(FreeFrame* free);
  void settle_account(FreeFrame* free);

  Model::Pointer model_;
  IntegratorOptions options_;
  std::shared_ptr<const ContactPoints> points_;
  ContactLaw law_;
  double mass_;
  InertiaDamping damping_;
  Eigen::VectorXd S_;
  PotentialWorkspace workspace_;
  std::vector<Candidate> candidates_;
  std::span<Grip> grips_;
  std::vector<Touch> held_;  // one a grip
  std::vector<double> impulses_;
  std::span<const PlacedCollider> colliders_;
  StepPoses poses_;
  ContactAccount account_;

  Eigen::VectorXd q0_, v0_, q1_, G_, dp_, force_, middle_, contact_push_;
  Eigen::MatrixXd K_;
  Eigen::VectorXd z_, z_before_, residual_, move_;
  Eigen::MatrixXd jacobian_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd push_;    // n x 3: how a force on a point changes the residual
  Eigen::MatrixXd pushed_;  // that times a stiffness
  Eigen::MatrixXd way_;     // 3 x n: how the point's end moves with the unknowns
  Eigen::Matrix3d R0_, R1_, turn_, spin_jacobian_;
  Eigen::Vector3d c0_, c1_;  // of the mesh's origin, or of a free body's centre of mass
  Eigen::Vector3d origin_;   // in the mesh's coordinates, of c
  Eigen::Vector3d contact_force_, contact_torque_;
  double scale_ = 0.0;
};

}  // namespace tremolo
