// One step of a body that is near colliders (docs/theory.md, section "Contact"). The step is that
// of ep2 (runtime/bodies/reduced/integrators/energy_preserving.cpp), for a free body together with
// that of runtime/bodies/reduced/frames/free_frame.h. The forces of contact_law.h on the body's
// points are solved for in the same system. A force F on the point y = X + U q adds f = U^T Ro~^T F
// and the torque (Ro~ y~) x F, so that the work of F is F.(x1 - x0) exactly.
//
// The unknowns are d = q1 - q0 and, for a free body, omega1 and the path e of its centre: r + 6.
// Newton's method with a line search finds them.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "runtime/bodies/reduced/frames/free_frame.h"
#include "runtime/bodies/reduced/integrators/solve/inertia_filter.h"
#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"
#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_memories.h"
#include "runtime/contact/contact_record.h"
#include "runtime/contact/contact_values.h"
#include "runtime/contact/impact.h"
#include "runtime/contact/solve/contact_equations.h"
#include "runtime/integrator.h"
#include "runtime/math/dense/dense_lu.h"
#include "runtime/parts.h"

namespace tremolo {

// Colliders and grabs that may act on a body in a step. They must stay in memory until the step has
// ended.
struct ContactNear {
  std::span<const PlacedCollider> colliders;
  std::span<Grip> grips;
  // Of a body on several bones: the maps of the grabbed positions, one a grab.
  std::span<const StepMaps> grip_maps = {};
};

// The results of ContactStep::gather() for the present step.
struct GatheredStep {
  ContactBall ball;
  StepPoses poses;
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  // of a free body by gravity, m/s^2
  std::span<const PlacedCollider> colliders;               // that the body feels
};

// Returns the parts of ContactHeld that are renewed before iteration `iteration` (from 0) of
// Newton's method. size: the residual divided by its small size (ContactStep::enough()).
//
// Friction limits are always renewed, because otherwise the step would not be solved. Normals are
// not renewed near the solution, where any normal near that of the middle is good enough. hold: the
// last resort for steps whose limits cycle. After kMostRenewals iterations the limits are kept;
// they are then so near those of the step that the energy balance still closes.
ContactRenewal renewal(int iteration, double size, bool hold);

// True if the next move is one of Newton's method in which friction limits follow the force.
// Otherwise limits are constant along the move, and a line search uses the slope (line_search.h).
bool limits_follow(int iteration, double size, bool hold);
// If no move lowers the residual, a residual below this multiple of the small size is rounding.
double near_rounding(bool hold);
// The shortest length along such a move that is tried.
double shortest_following(int iteration);
// The fraction of the residual below which a move of that length is accepted.
double following_bound(double length);

class ContactStep {
 public:
  ContactStep(Model::Pointer model, const IntegratorOptions& options, ContactSurface surface);
  // Sets the step and Rayleigh damping from the next step on. The contact law depends on neither.
  void set_options(const IntegratorOptions& options);

  // Attaches the contact points of a body to its several bones. Before each gather() of such a body
  // call place(), which places them for the next step of the frame.
  void attach(std::shared_ptr<BonePoints> points);
  void place(const DrivenFrame& frame);
  bool on_bones() const { return bool(eq_.bones); }

  const ContactSurface& surface() const { return eq_.surface; }
  // Contacts with other bodies that are remembered from the last step, by the number of the other
  // body in its group. finish() clears them; add those of the step after it.
  const ContactMemories& pair_memories() const { return pair_memories_; }
  ContactMemories& pair_memories() { return pair_memories_; }

  // Finds the points that may be in contact with a collider in the step from q, v. False if there
  // are no such points and no grabs: the step is then taken without contact.
  bool gather(const ContactNear& near, const StepPoses& poses, const Eigen::VectorXd& q,
              const Eigen::VectorXd& v, const StepPush& push);
  const GatheredStep& gathered() const { return gathered_; }
  // The position of a contact point at the start of the step of gather(), m, world.
  Eigen::Vector3d start_of_point(std::size_t point) const;
  // A position of the world in the mesh's coordinates, there, m.
  Eigen::Vector3d into_rest_at_start(const Eigen::Vector3d& x) const;
  // False: at the start the position, m, world, is farther from the body than `reach`, m.
  bool may_reach(const Eigen::Vector3d& x, double reach) const {
    const ContactBall& ball = gathered_.ball;
    return (x - ball.centre).norm() <= ball.radius + ball.deformed + reach;
  }
  // False: y = into_rest_at_start(x) has no meaning, because x is outside the body and between its
  // bones.
  bool agrees(const Eigen::Vector3d& x, const Eigen::Vector3d& y) const {
    return !on_bones() || eq_.bones->agree(x, y, false);
  }
  // Call this after a step without contact, taken because gather() found no points; the body is at
  // q in `end`. It finds the points that came within the margin nevertheless. True if there are
  // any: the step must be repeated with them.
  bool find_missed(const Pose& end, const Eigen::VectorXd& q);

  // For impact.h, of a rigid body whose step gather() has prepared: the body, and its points near
  // colliders, which are added as those of the body `number`.
  ImpactBody impact_body(const RigidState& rigid) const;
  void add_impacts(std::size_t number, std::vector<ImpactPoint>& points) const;

  // True if such a body alone hits a collider so hard that the step must be divided.
  bool hits_hard(const RigidState& rigid);

  // Takes the step. free: null unless the body is free; the poses of gather() are used then. load:
  // as for an integrator. whole: tries all means, because the step will not be subdivided. If the
  // step does not converge, the state is unchanged.
  StepReport step(State& state, const StepLoad& load, FreeFrame* free, bool whole);

  // The last step. If nothing was near in a step, call reset() instead of finish().
  const ContactRecord& record() const { return record_; }
  ContactRecord& record() { return record_; }
  void reset();

  // Interface for solvers of several bodies at once (contact_island.h). After gather() call
  // begin(), which sets the equations' z to the motion without forces. Then call evaluate() at a z,
  // add the forces of the other bodies, call close() and make_jacobian(). At the end call finish().
  ContactEquations& equations() { return eq_; }
  const ContactEquations& equations() const { return eq_; }
  void begin(const State& state, const StepLoad& load, FreeFrame* free);
  // Declares that a joint of this stiffness, N/m, acts at the point: the rounding error that it
  // causes there counts as small. other: distance of the joint's other end from the world's origin,
  // m; 0: no more than that of the body. Call it after begin().
  void hold_at(const VertexRows& place, double stiffness, double other = 0.0);
  void evaluate(const ContactRenewal& renewal);
  double close();         // size of the residual, all rows as momenta, kg^1/2 m/s
  double enough() const;  // size below which a residual is small
  // heavier: the factor of added inertia, for a move that lowers the residual. follows: same as for
  // contact_slopes().
  void make_jacobian(double heavier, bool follows);
  // Call this where the step is solved. It adds the points that came within a collider's margin but
  // were not found before. True if there are any: the step must be solved with them.
  bool add_missed();
  // Bounds of the motion in the step with the z of the last evaluate().
  StepWay way_in_step() const;
  // True if the body, at the present z, went farther than gather() predicted.
  bool went_far() const { return went_far(end_pose(), eq_.q1); }
  // Sets the state at the end of the step. pairs: the part of the energy balance that belongs to
  // contact with other bodies (energy, lost, friction_loss, work, given, penetration, impulse,
  // active); start: their energy at the start of the step, J.
  void finish(State& state, StepReport& report, const ContactAccount& pairs = {},
              double start = 0.0);

  // Saves or restores the state between steps: the energy balance, and the contact memories.
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
  void set_levels(std::size_t collider, std::size_t from);
  void begin_candidate(Candidate& candidate);
  void remember();
  double frame_reach(const StepPoses& poses, double radius) const;
  Eigen::Vector3d place_of(std::size_t point, const Pose& pose, bool at_end,
                           const Eigen::VectorXd& q) const;
  double acceleration_reach(const Eigen::VectorXd& q, const StepPush& push) const;
  void add_grips();
  void follow_bones();
  const StepMotion& motion_of_grip(std::size_t i) const {
    return on_bones() ? grip_motions_[i] : eq_.motion;
  }
  void evaluate_body();
  void make_slopes();
  void add_contact(const ContactRenewal& renewal);
  ContactTime time_with(std::size_t collider) const { return {options_.step, rates_[collider]}; }
  void add_contact_slopes(bool follows);
  Eigen::Vector3d turn_along(const ColliderTurns& turns, const PlacedCollider& collider) const;
  Eigen::Vector3d surface_of(const Candidate& candidate) const;
  void add_roll_slopes(const Candidate& candidate, const PlacedSlope& slope);
  bool went_far(const Pose& end, const Eigen::VectorXd& q) const;
  Pose end_pose() const;
  double size_without_contact();
  double size_of_motion() const;
  double grips_rounding() const;
  double work_of_rounding() const;  // J, of all hands and joints, at most
  bool solve(double heavier, bool hold, StepReport& report);
  bool try_following(int iteration, double size, double& reached);
  void settle_grips();
  void settle_account(const ContactAccount& pairs, double start);
  void use_options();

  Model::Pointer model_;
  IntegratorOptions options_;
  ContactEquations eq_;
  bool in_island_ = false;  // other bodies may touch it in the step
  GatheredStep gathered_;
  InertiaDamping damping_;
  StrainDamping strain_;
  Eigen::VectorXd rest_, rest_middle_;  // rest(qm) d of strain_, and qm; r
  double rest_work_ = 0.0;              // d.rest(qm) d/h, J
  Eigen::VectorXd S_;
  PotentialWorkspace workspace_;
  std::vector<Candidate> candidates_;
  std::vector<PairRate> rates_;       // one a collider
  std::vector<ColliderTurns> turns_;  // one a collider
  // Effect of the pairs' rates on the residual, and growth of the fraction that restitution takes
  // with the unknowns; one column per collider.
  Eigen::MatrixXd taken_push_, taken_growth_;
  ContactMemories memories_;  // of colliders
  ContactMemories pair_memories_;
  std::vector<ImpactPoint> impacts_;  // scratch
  std::vector<char> listed_;          // points that are candidates; scratch
  std::span<Grip> grips_;
  std::span<const StepMaps> grip_maps_;
  std::vector<ContactTouch> held_;        // one a grip
  std::vector<StepMotion> grip_motions_;  // of a body on several bones, one a grip
  ContactRecord record_;
  double joints_rounding_ = 0.0;  // kg^1/2 m/s
  double joints_far_ = 0.0;       // largest distance of their ends from the world's origin, m
  // Of the first residual of a step without forces at positions; below 0 before it.
  double first_size_ = 0.0;
  const StepLoad* load_ = nullptr;
  FramePointer<FreeFrame> free_ = nullptr;

  Eigen::VectorXd v0_, G_, dp_, force_, middle_;
  // Residual without forces at positions, found by evaluate_body() at known_z_.
  bool known_ = false;
  Eigen::VectorXd known_z_, own_force_;
  Eigen::Vector3d own_spin_residual_, own_centre_residual_;
  Eigen::MatrixXd K_;  // of slopes_at_, if slopes_known_ in this step
  Eigen::VectorXd slopes_at_;
  bool slopes_known_ = false;
  Eigen::VectorXd z_before_, move_;
  DenseLu factor_;
  Eigen::Matrix3d spin_jacobian_;
};

}  // namespace tremolo
