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
#include <optional>
#include <span>
#include <vector>

#include <Eigen/LU>

#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"
#include "runtime/contact/solve/bent_shape.h"
#include "runtime/contact/solve/contact_points.h"
#include "runtime/contact/solve/step_motion.h"
#include "runtime/frames/free_frame.h"
#include "runtime/integrator.h"
#include "runtime/integrators/solve/inertia_filter.h"
#include "runtime/integrators/solve/strain_damping.h"
#include "runtime/parts.h"

namespace tremolo {

// Where a body's points are in a step: at its start within `radius` + `deformed` of `centre` in the
// world, m; in it none goes farther than `travel` without contact.
struct ContactBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.0, deformed = 0.0, travel = 0.0;
};

// What is renewed of what is held before an iteration of Newton's method, counted from 0, at a
// residual of `size` times the small one. Limits of friction always are, or the step would not be
// solved; normals are not near the solution, where any normal near the middle's will do.
// hold: the last resort, for steps whose limits run in circles: after kMostRenewals iterations they
// stay as they are, and so near that of the step that the energy still closes.
ContactRenewal renewal(int iteration, double size, bool hold);

// Whether a move from there is one of Newton's method with limits that follow the force; else they
// are held along the move, and a line search goes by the slope (line_search.h).
bool limits_follow(int iteration, double size, bool hold);
// Where no move helps, a residual below so many times the small one is that of rounding.
double near_rounding(bool hold);
// The shortest length along such a move that is tried, and the fraction of the residual that is
// low enough there.
double shortest_following(int iteration);
double following_bound(double length);

class ContactStep {
 public:
  // mass: kg. free: nothing holds the body.
  ContactStep(Model::Pointer model, const IntegratorOptions& options, const ContactOptions& contact,
              double mass, bool free);

  const ContactPoints& points() const { return *points_; }
  // Of a unit of area: stiffness kappa, N/m^4.
  const ContactLaw& law() const { return law_; }
  // The law of one of its points against a collider of that friction and restitution, or, with
  // `other`, against another body.
  ContactLaw law_of(std::size_t point, double friction, double restitution) const;
  ContactLaw law_of(std::size_t point, const ContactStep& other) const;

  // The memory of its point's contact with the body of that number in a group; null: there is none.
  const ContactMemory* pair_memory(std::size_t body, std::size_t point) const;
  // Those of the step that was made: after finish(), in any order, then sort_pair_memories().
  void remember_pair(const ContactMemory& memory) { pair_memories_.push_back(memory); }
  void note_contact(const ContactedPoint& point) { contacted_.push_back(point); }
  void sort_pair_memories();

  // Finds the points that may touch a collider in the step from q, v. colliders must stay where
  // they are until the step is made. False if there are none: the step is made without contact.
  bool gather(std::span<const PlacedCollider> colliders, const StepPoses& poses,
              const Eigen::VectorXd& q, const Eigen::VectorXd& v, const StepPush& push);
  // After a step that was made without contact because gather() found none, with the body at q in
  // `end`: finds the points that came within the margin all the same; true if there are any, and
  // the step has to be made with them.
  bool find_missed(const Pose& end, const Eigen::VectorXd& q);

  // The hands of the step; they must stay where they are until it is made.
  void hold(std::span<Grip> grips) { grips_ = grips; }

  // The step. free: of a free body, else null; then the poses hold. load: as for an integrator.
  // Where it does not converge, the state is as before.
  // whole: all means are tried, since the step is not cut.
  StepReport step(State& state, const StepLoad& load, FreeFrame* free, bool whole);

  // Account of the last step; when nothing was near, reset() instead.
  const ContactAccount& account() const { return account_; }
  // In how many steps friction's limits were held as a last resort; see renewal().
  std::int64_t held_steps() const { return held_steps_; }
  void note_held_step() { ++held_steps_; }
  void reset();
  // A step in parts: account(), impulses() and contacted() are of the whole after end_parts(), if
  // it was made.
  void begin_parts() { parts_ = {}; }
  void keep_part();
  void end_parts(bool made);
  std::span<const PlacedCollider> colliders() const { return colliders_; }
  // For each collider the sum of the lengths of the impulses on it in the last step, N s; 0 where
  // there was no contact. And the impulse itself, N s, world.
  std::span<const double> impulses() const { return impulses_; }
  std::span<const Eigen::Vector3d> collider_impulses() const { return collider_impulses_; }
  // The points that pushed in the last step, of colliders first. Those of another body's points
  // that met this one's shape are among that body's.
  std::span<const ContactedPoint> contacted() const { return contacted_; }

  // What solvers of several bodies at once need (contact_island.h). After gather(): begin(), with
  // z() where the body would go without forces; evaluate() at a z(), then the forces of the other
  // bodies, then close(); make_jacobian() there; in the end settle_pairs() and finish().
  void begin(const State& state, const StepLoad& load, FreeFrame* free);
  Eigen::Index unknowns() const { return model_->modes() + (free_ != nullptr ? 6 : 0); }
  // unknowns() entries of these are used. residual: kg^1/2 m for d, N m s for omega1, N for e.
  Eigen::VectorXd& z() { return z_; }
  const Eigen::VectorXd& residual() const { return residual_; }
  const Eigen::MatrixXd& jacobian() const { return jacobian_; }
  void evaluate(const ContactRenewal& renewal);
  // A joint of this stiffness, N/m, holds the place: what rounding leaves there counts as small.
  // After begin().
  void hold_at(const VertexRows& place, double stiffness);
  double close();  // the residual's size, all rows as momenta, kg^1/2 m/s
  // What makes momenta of the residual's rows, kg^1/2 m/s; the first unknowns() are used.
  const Eigen::VectorXd& row_scale() const { return row_scale_; }
  // How far the coordinates move any point in the step, m.
  double bend_in_step() const { return z_.head(model_->modes()).cwiseAbs().dot(points_->reach); }
  // The product of the residual, as forces, with a move of the unknowns: the slope of what the step
  // minimizes, J, but for what turns.
  double work_along(const Eigen::Ref<const Eigen::VectorXd>& move) const;
  double enough() const;  // a residual's size that is small
  // heavier: so many times more inertia than there is, for a move that falls. follows: as of
  // contact_slopes().
  void make_jacobian(double heavier, bool follows);
  // Where the step is solved: adds the points that came within a collider's margin but were not
  // found before; true if there are any, and the step has to be solved with them.
  bool add_missed();
  // Whether the body, at the present z(), went farther than gather() foresaw.
  bool went_far() const { return went_far(end_pose(), q1_); }
  // What other bodies' contact is in the account: energy, lost, rubbed, work, given, penetration,
  // impulse and active of `pairs`, and the energy at the start of the step, J.
  void settle_pairs(const ContactAccount& pairs, double start) {
    pairs_ = pairs;
    pairs_start_ = start;
  }
  // The state at the end of the step.
  void finish(State& state, StepReport& report);

  // The body's frame in the step, at the present z(), and what a force does to its equations.
  const StepMotion& motion() const { return motion_; }
  PlaceLever& lever() { return lever_; }
  // A place of the body that touches, at the present z(): a point; or any place, with the straight
  // mean of its ends as the force's.
  ContactTouch touch_at_point(std::size_t point) const;
  ContactTouch straight_touch_at(const VertexRows& place) const;
  Eigen::Vector3d end_of_point(std::size_t point) const;  // its x1
  // By how much a place, whose rows of U are `rows`, moves in the step as the body bends, m, world:
  // a force's work is its product with that and with motion().way_under().
  Eigen::Vector3d bend_under(const PlaceRows& rows) const;
  const Eigen::VectorXd& q_start() const { return q0_; }
  // The body's own shape, bent as at the start or the end of the step; for a body with a shape.
  BentShape shape_at_start() const { return {&*shape_, points_.get(), &u0_}; }
  BentShape shape_at_end() const { return {&*shape_, points_.get(), &u1_}; }
  // A force, N, world, between evaluate() and close(); bend_force: what bends the body. And a
  // torque alone, N m, world.
  void push_point(const Eigen::Vector3d& force, const ContactTouch& touch, std::size_t point);
  void push(const Eigen::Vector3d& force, const Eigen::Vector3d& bend_force,
            const ContactTouch& touch, const PlaceRows& rows);
  void push_turn(const Eigen::Vector3d& torque);
  auto point_rows(std::size_t point) const {
    return points_->rows.middleCols<3>(static_cast<Eigen::Index>(3 * point));
  }
  Eigen::MatrixXd& whole_block() { return jacobian_; }
  auto own_block() { return jacobian_.topLeftCorner(unknowns(), unknowns()); }
  // What the force on a place adds to the Jacobian because the place and the body turn: where the
  // lever has its swing; on a point; and on a place of another body's point (what does not depend
  // on that body's unknowns).
  void add_geometry(const Eigen::Vector3d& force, const Eigen::Vector3d& bend_force,
                    const ContactTouch& touch, const PlaceRows& rows);
  void add_geometry_at_point(const Eigen::Vector3d& force, const ContactTouch& touch,
                             std::size_t point);
  void add_geometry_of_other(const Eigen::Vector3d& force, const Eigen::Vector3d& bend_force,
                             const ContactTouch& touch, const PlaceRows& rows);
  bool turns() const { return free_ != nullptr; }
  double mass() const { return mass_; }
  bool can_move() const { return can_move_; }
  // False: it feels hands alone.
  bool feels() const { return feels_; }
  // What other bodies bump into; null: nothing.
  const Collider* shape() const { return shape_ ? &*shape_ : nullptr; }
  // Results of the last gather().
  const ContactBall& ball() const { return ball_; }
  const StepPoses& poses() const { return poses_; }

  // alpha, beta: Rayleigh's, from the next step on.
  void set_damping(double alpha, double beta);
  // s, likewise. Contact is as stiff as the new step allows: what it stores changes with that,
  // which the account tells as surplus.
  void set_step(double step);

  // What is carried between steps: the account, and where the body was when others looked last.
  void carry(StateStream& stream);

 private:
  struct Candidate {
    std::size_t point = 0;
    std::size_t collider = 0;
    ContactLaw law = {};
    ContactMemory memory = {};
    Eigen::Vector3d y0 = Eigen::Vector3d::Zero();  // from c along the body's axes, at the start, m
    ContactStart start = {};
    ContactEnd end = {};
    ContactHeld held = {};
    ContactForce now = {};
    ContactTouch touch = {};
  };

  std::span<Candidate> touching() {
    return kHasColliders ? std::span<Candidate>(candidates_) : std::span<Candidate>();
  }
  void add_candidates(const PlacedCollider& collider, std::size_t index, const Eigen::VectorXd& q,
                      double reach);
  Candidate make_candidate(std::size_t point, std::size_t index, const Eigen::Vector3d& x) const;
  void begin_candidate(Candidate& candidate);
  void remember();
  void find_dampers();
  double acceleration_reach(const Eigen::VectorXd& q, const StepPush& push) const;
  Eigen::Vector3d place_in_body(std::size_t point, const Eigen::VectorXd& q) const;
  ContactTouch touch_at(const Eigen::Vector3d& rest, const PlaceRows& rows) const;
  void add_grips();
  void evaluate_body();
  void add_contact(const ContactRenewal& renewal);
  ContactTime time_with(std::size_t collider) const { return {options_.step, rates_[collider]}; }
  void add_contact_slopes(bool follows);
  bool went_far(const Pose& end, const Eigen::VectorXd& q) const;
  Pose end_pose() const;
  double size_of_residual() const;
  double size_of_motion() const;
  double way_of_move() const;
  double held_rounding(const VertexRows& place, double stiffness, double far) const;
  double grips_rounding() const;
  bool solve(double heavier, bool hold, StepReport& report);
  bool try_following(int iteration, double size, double& reached);
  void settle_grips();
  void settle_account();
  void scale_rows();

  Model::Pointer model_;
  IntegratorOptions options_;
  std::shared_ptr<const ContactPoints> points_;
  ContactLaw law_;
  double mass_;
  bool can_move_;
  bool feels_;
  bool in_island_ = false;  // other bodies may touch it in the step
  std::optional<Collider> shape_;
  ContactBall ball_;
  InertiaDamping damping_;
  StrainDamping strain_;
  Eigen::VectorXd rest_, rest_middle_;  // rest(qm) d of strain_, and qm; r
  double rest_work_ = 0.0;              // d.rest(qm) d/h, J
  Eigen::VectorXd S_;
  PotentialWorkspace workspace_;
  std::vector<Candidate> candidates_;
  std::vector<PairRate> rates_;       // one a collider
  std::vector<ColliderTurns> turns_;  // likewise
  // What the pairs' rates do to the residual, and how what restitution takes grows with the
  // unknowns; a column a collider.
  Eigen::MatrixXd taken_push_, taken_growth_;
  std::vector<ContactMemory> memories_;       // by collider and point
  std::vector<ContactMemory> pair_memories_;  // by body and point
  std::vector<char> listed_;                  // points that are candidates; scratch
  std::vector<double> dampers_;               // c of friction.h over the square root of k, kg^1/2
  std::span<Grip> grips_;
  std::vector<ContactTouch> held_;  // one a grip
  std::vector<double> impulses_;
  std::vector<Eigen::Vector3d> collider_impulses_;
  std::vector<ContactedPoint> contacted_;
  std::span<const PlacedCollider> colliders_;
  StepPoses poses_;
  ContactAccount account_;
  ContactAccount pairs_;
  // Of the parts of a step so far.
  struct {
    ContactAccount account;
    std::vector<double> impulses;
    std::vector<Eigen::Vector3d> collider_impulses;
    std::vector<ContactedPoint> contacted;
  } parts_;
  double pairs_start_ = 0.0;
  std::int64_t held_steps_ = 0;
  double joints_rounding_ = 0.0;  // kg^1/2 m/s
  double first_size_ = 0.0;       // of the first residual of a step; below 0 before it
  const StepLoad* load_ = nullptr;
  FramePointer<FreeFrame> free_ = nullptr;

  Eigen::VectorXd u0_, u1_, q0_, v0_, q1_, G_, dp_, force_, middle_, contact_push_;
  // What evaluate_body() found at known_z_: of the residual, without places.
  bool known_ = false;
  Eigen::VectorXd known_z_, own_force_;
  Eigen::Vector3d own_spin_residual_, own_centre_residual_;
  Eigen::MatrixXd K_;
  Eigen::VectorXd z_, z_before_, residual_, row_scale_, move_;
  Eigen::MatrixXd jacobian_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::Matrix3d spin_jacobian_;
  StepMotion motion_;
  PlaceLever lever_;
  Eigen::Vector3d contact_force_, contact_torque_;
};

}  // namespace tremolo
