// A body: a model, where it is, how it moves, and what pushes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/contact/contact_law.h"
#include "runtime/contact/contact_values.h"
#include "runtime/display/surface.h"
#include "runtime/energy.h"
#include "runtime/energy_bound.h"
#include "runtime/frames/driven_frame.h"
#include "runtime/frames/free_frame.h"
#include "runtime/frames/point_force.h"
#include "runtime/integrator.h"
#include "runtime/load.h"
#include "runtime/model.h"
#include "runtime/parts.h"
#include "runtime/place_forces.h"
#include "runtime/skeleton/skin.h"

namespace tremolo {

// kUsage unless q and p have `modes` finite entries each.
Status check_state(Eigen::Index modes, const Eigen::VectorXd& q, const Eigen::VectorXd& p);

class BodyGroup;
class ContactStep;

// Energies are looked at every so many steps: a look costs at most a force.
inline constexpr int kStepsBetweenLooks = 8;

// What holds a body. kFixed: its support stands still in the world, the mesh's frame is the
// world's. kDriven: its support follows poses that are given step by step. kFree: nothing does; it
// falls, turns and deforms, each acting on the other.
enum class FrameKind { kFixed, kDriven, kFree };

// Starts at rest in the rest shape at time 0. Not thread-safe; different bodies of one model may
// step on different threads.
class Body {
 public:
  // Errors as make_integrator; kUsage for a method that the frame does not go with (kDriven: avf,
  // ep2, ep4, newmark, imexv; kFree: avf, ep2, ep4) and for a model that has no inertia integrals,
  // or holds on somewhere where it should be free or the other way round.
  static Result<Body> create(Model::Pointer model, std::string_view integrator = kDefaultIntegrator,
                             const IntegratorOptions& options = {},
                             FrameKind frame = FrameKind::kFixed);

  // A driven body that hangs on bones with its skin, which must have been made for this model; its
  // bones are at rest at first, their poses the identity. Errors as for kDriven; kUsage for a skin
  // of another model. Colliders and hands see the first bone's frame alone: use set_contact() with
  // one bone only.
  static Result<Body> create(Model::Pointer model, std::string_view integrator,
                             const IntegratorOptions& options, std::shared_ptr<const Skin> skin);

  const Model& model() const { return *model_; }
  const Model::Pointer& model_pointer() const { return model_; }
  const Integrator& integrator() const { return *integrator_; }
  const State& state() const { return state_; }
  double step_size() const { return options_.step; }                           // s
  std::int64_t steps() const { return steps_; }                                // done so far
  double time() const { return static_cast<double>(steps_) * options_.step; }  // s

  // Sets q and p (each r long, finite); what the integrator carried is forgotten, time goes on.
  // kUsage otherwise, and nothing is changed.
  Status set_state(const Eigen::VectorXd& q, const Eigen::VectorXd& p);

  // All that the body carries from step to step as the bytes of a file
  // (formats/saved/saved_file.h): state, frame, gravity, damping, forces of apply_force(), hands,
  // sums, contact, and what its method carries. With them put back, the steps that follow have the
  // same bits as those of the body that was saved, under the same loads in time, which are not
  // among it.
  std::vector<std::byte> save() const;
  // kContent, and the body is as it was, for bytes that are damaged, of another version, or of a
  // body with another model, method, frame, contact or other loads in time.
  Status restore(std::span<const std::byte> bytes);
  // What save() holds without saying whose it is, for those who save several bodies; a hash of what
  // it must be put back into.
  void carry(StateStream& stream);
  std::uint64_t content_hash() const;

  // Rayleigh's alpha (1/s) and beta (s) from the next step on; a body that sleeps wakes. The
  // accounts go on and stay closed. kUsage if one is negative or not finite. What a method carries
  // from earlier steps to go faster is forgotten; allocates.
  Status set_damping(double alpha, double beta);
  // Another method and step (s) from the next step on: state, frame, loads, hands and sums stay,
  // and what the method carried is forgotten. Time is steps() steps, so it goes to the multiple of
  // the new step that is nearest. Errors as of make_integrator; kUsage, with everything as it was,
  // for a method that the frame or contact does not go with. Allocates.
  Status set_method(std::string_view integrator, double step);
  double alpha() const { return options_.alpha; }
  double beta() const { return options_.beta; }

  // Where the frame is; that of a kFixed body is the world's. Vertices are at pose() (X + U q).
  FrameKind frame() const { return kHasFrames ? frame_ : FrameKind::kFixed; }
  Pose pose() const;
  // Puts the body elsewhere without a kick: a driven frame is then at rest, a free body keeps its
  // velocities, as its own axes see them its spin. kUsage for a fixed body, or a pose that is not
  // finite or whose rotation is not of length one to 1e-6.
  Status set_pose(const Pose& pose);

  // Where the frame of a driven body is at the end of the next step; without a call it stands
  // still. With `motion` the accelerations of that step are known; without, they are extrapolated
  // from the poses so far (runtime/frames/driven_frame.h). Errors as set_pose, kUsage if the body
  // is not driven.
  Status move_to(const Pose& next);
  Status move_to(const Pose& next, const FrameMotion& motion);

  // Number of bones of a body on bones; else 0. pose() is then the first bone's; set_pose() and
  // move_to() do the same with all bones.
  std::size_t bones() const { return skin_ ? skin_->bones() : 0; }
  const Skin* skin() const { return skin_.get(); }
  // Where the bone is relative to where it is at rest, in the mesh's coordinates. bone < bones().
  const Pose& bone_pose(std::size_t bone) const { return driven_->pose(bone); }
  // As set_pose, move_to and move_to with one bone. kUsage also if there is no such bone.
  Status set_bone(std::size_t bone, const Pose& pose);
  Status move_bone_to(std::size_t bone, const Pose& next);
  Status move_bone_to(std::size_t bone, const Pose& next, const FrameMotion& motion);

  // Sets a free body moving. velocity: of the centre of mass, m/s, world. spin: rad/s, along the
  // body's axes. kUsage if the body is not free or a value is not finite.
  Status set_motion(const Eigen::Vector3d& velocity, const Eigen::Vector3d& spin);
  // Zeros unless the body is free.
  RigidState rigid_state() const { return free_ ? free_->rigid() : RigidState{}; }
  Eigen::Vector3d linear_momentum() const;   // kg m/s
  Eigen::Vector3d angular_momentum() const;  // about the world's origin, N m s

  // m/s^2, world; from the next step on. kUsage if it is not finite, or not zero and the model has
  // no inertia integrals.
  Status set_gravity(const Eigen::Vector3d& gravity);
  const Eigen::Vector3d& gravity() const { return gravity_; }
  // Gravity's force on the coordinates with the frame or the bones where they are now, r; zeros
  // for a free body.
  Eigen::VectorXd gravity_force() const;
  // How a vertex's surroundings are turned from the mesh's axes to the world's: the frame's
  // rotation, or the blend of the bones', which is not orthogonal between them. Errors as
  // Model::vertex.
  Result<Eigen::Matrix3d> turn_at(VertexId vertex) const;

  // Makes the body feel colliders. kUsage for options out of range, a method that contact does not
  // go with (a fixed body takes any; those near a collider take the step of
  // runtime/contact/solve/contact_step.h), a model without inertia integrals.
  Status set_contact(const ContactOptions& options = {});
  // Account of the last step; zeros without contact.
  ContactAccount contact_account() const;
  const ContactStep* contact() const { return contact_.get(); }

  // A hand takes hold of a vertex where it is, by a spring (N/m) and a damper (N s/m) to a point
  // that goes where move_hand() says. Returns its number. Needs set_contact(). A spring stiffer
  // than that of stiffest_hand() is replaced by it and its damper, that is by pin(): beyond, its
  // rounding errors are larger than the step's tolerance. A damper is limited to h/2 times that
  // stiffness. hand_spring() returns the values in use. Errors as Model::vertex; kUsage for values
  // that are not finite or negative.
  Result<std::size_t> grab(VertexId vertex, double stiffness, double damping = 0.0);
  // The same of a vertex that was looked up before (Model::vertex): nothing is allocated where
  // reserve_contact() has made room.
  Result<std::size_t> grab(VertexId vertex, VertexRows place, double stiffness, double damping);
  // The same at any place of a surface, as pick() finds it. Errors as Model::place.
  Result<std::size_t> grab(const SurfacePlace& place, double stiffness, double damping = 0.0);
  // Holds a vertex, or a place of a surface, where it is, or where move_hand() says: a hand whose
  // stiffness follows from mass and step, k = (30/h)^2 m and a damper of 60 m/h, m the mass with
  // which the place resists in a step. It lets go by release(). Under a force F the place is F/k
  // off, of a body of mass M that hangs on it M g h^2/(900 m); a motion that it had dies by an
  // eighth a step. Errors as grab(), and kUsage for a place that does not move.
  Result<std::size_t> pin(VertexId vertex);
  Result<std::size_t> pin(const SurfacePlace& place);
  Result<std::size_t> pin(VertexId vertex, VertexRows place);  // as grab() of such a vertex
  // The spring and damper of a pin at the place with the present step; infinite for a place that
  // does not move.
  HandSpring stiffest_hand(const VertexRows& place) const;
  // Makes room for steps among these colliders with so many hands at once; set_contact() first.
  void reserve_contact(std::span<const PlacedCollider> colliders, std::size_t hands);
  // Where the point is at the end of the next step, m, world. kUsage: no such hand, not finite.
  Status move_hand(std::size_t hand, const Eigen::Vector3d& place);
  std::span<const Grip> grips() const { return grips_; }  // those that hold
  // The force on the body in the last step, N, world; the hand feels the opposite. Zero for none.
  Eigen::Vector3d hand_force(std::size_t hand) const;
  // The spring and damper in use; zeros for no such hand. A longer step (set_method()) may lower
  // them again.
  HandSpring hand_spring(std::size_t hand) const;
  // Numbers of other hands stay.
  Status release(std::size_t hand);
  double hand_work() const { return sums_.hand; }  // J, since the start; part of work()
  // What joints did to the body (runtime/contact/joint.h), likewise.
  double joint_work() const { return sums_.joint; }
  // With which a place resists a force in a step, the mean over all directions, kg; infinite for a
  // place that does not move. A coordinate of the frequency omega resists as 1 + (h omega)^2/4.
  double mass_at(const VertexRows& place) const;

  // Adds a load in time; its signal's clock is time(). Forces on vertices are along the world's
  // axes, whatever the frame does; reduced ones along the frame's, and not for a free body.
  Status add_load(const Load& load);  // kUsage if its force is not r long and finite
  Status add_load(const Signal& signal, VertexId vertex, const Eigen::Vector3d& force);  // N
  // Forces on several vertices at once. Errors as above.
  Status add_load(const Signal& signal, const DefaultLoad& forces);
  // The model's default load, times scale. kUsage if the model has none.
  Status add_default_load(const Signal& signal, double scale = 1.0);
  void clear_loads();

  // A force (N) at a vertex, constant over the next `steps` steps. Several add up. Errors as
  // reduce_force.
  Status apply_force(VertexId vertex, const Eigen::Vector3d& force, int steps = 1);
  void clear_forces();  // those of apply_force() that still act

  // One step. If the report says not converged, the time and the pending loads are as before, and
  // so is the state if its energy is sound. If it is not, because the method has exploded, or if
  // this step's is far out (StepFailure::kEnergy), the state, work() and dissipated() are those of
  // the last sound look, and what the integrator carried is forgotten. Looks are at the start, when
  // a state is set and every kStepsBetweenLooks steps; what is sound says runtime/energy_bound.h.
  // Nothing is allocated.
  StepReport step() { return step({}); }
  // The same among colliders, which must stay where they are until it returns; set_contact() first.
  StepReport step(std::span<const PlacedCollider> colliders);
  const EnergyBound& energy_bound() const { return bound_; }

  // True if a load can still act on a step to come.
  bool load_to_come() const;

  // Since the start, J: work of all that pushes, of which support_work() and gravity_work() are
  // parts: of the loads, average . (q1 - q0) a step plus what the method adds to
  // it (exact for midpoint-type and energy-preserving methods, second order for the others), and
  // what damping took.
  double work() const { return sums_.work; }
  double dissipated() const { return sums_.dissipated; }
  // What the frame did to the motion relative to it, by its accelerations, and gravity (to
  // a driven body's relative motion, or to all of a free body).
  double support_work() const { return sums_.support; }
  double gravity_work() const { return sums_.gravity; }
  // Likewise of contact: what it did to the body (part of work()), and of that what restitution and
  // friction took, what moving colliders gave, and the contact energy that was found where the step
  // before had none (contact_error: it should be zero). contact_work = given - lost - rubbed -
  // growth of contact_account().energy + error.
  double contact_work() const { return sums_.contact; }
  double contact_lost() const { return sums_.lost; }
  double contact_rubbed() const { return sums_.rubbed; }
  double contact_given() const { return sums_.given; }
  double contact_error() const { return sums_.contact_error; }
  std::int64_t iterations() const { return iterations_; }      // of all steps
  std::int64_t halved_steps() const { return halved_steps_; }  // steps that were taken in parts

  // Evaluates V. The high band is that of the integrator's split, or, for a method that does not
  // split, of the one that options.split would give.
  Energy energy() const { return energy(low_); }
  // The same with the high band from coordinate `low` on, 0 <= low <= r.
  Energy energy(Eigen::Index low) const;

  // What a ray meets first on the surface as it is bent now, from either side; nullopt: nothing.
  // origin: m, world; direction: world, of any length. kUsage if either is not finite, or the
  // direction zero, and of a body on several bones. Nothing is allocated after a model's first
  // call.
  Result<std::optional<SurfaceHit>> pick(const Eigen::Vector3d& origin,
                                         const Eigen::Vector3d& direction,
                                         SurfaceKind surface = SurfaceKind::kDrawn) const;

  // What surfaces are shown by: q, and behind it the forces at the end of the last step at the
  // places where the model keeps its response: those of loads, of apply_force() and of hands that
  // hold these vertices, along the body's axes, N; r + 3p. Energy, contact and rays know nothing of
  // the shape W f. Valid until the next call.
  const Eigen::VectorXd& shown() const;

  // U_vertex q + W_vertex f, m. Errors as Model::vertex.
  Result<Eigen::Vector3d> displacement(VertexId vertex) const;

  // pose() (X + displacement), or on bones their blend, m. Errors as Model::vertex.
  Result<Eigen::Vector3d> position(VertexId vertex) const;

  // pose() (X + U q + W f), or on bones their blend, of the drawn surface's vertices, x y z x y z
  // ..., m. out: 3 * model().drawn().rest.size() long, else kUsage. The double variant allocates
  // nothing. The float variant reads rows that the model makes for it when they are first asked for
  // (runtime/display/surface.h, where its error is told), and allocates nothing after that.
  Status surface_positions(std::span<double> out) const;
  Status surface_positions(std::span<float> out) const;
  // Those of the solid's boundary, whatever is drawn: 3 * model().surface().rest.size() long.
  Status boundary_positions(std::span<double> out) const;

  // The same with the unit normals of its vertices, each triangle counting with its area: zero
  // where a vertex's triangles have none. Both 3 * model().drawn().rest.size() long, else kUsage.
  // Nothing is allocated after a body's first call.
  Status surface(std::span<float> positions, std::span<float> normals) const;

 private:
  // Since the start, J; what of it is what is told at the functions that return them.
  struct Sums {
    double work = 0.0, dissipated = 0.0;
    double support = 0.0, gravity = 0.0;
    double contact = 0.0, lost = 0.0, rubbed = 0.0, given = 0.0, contact_error = 0.0;
    double hand = 0.0, joint = 0.0;

    void carry(StateStream& stream) {
      stream(work, dissipated, support, gravity, contact, lost, rubbed, given, contact_error);
      stream(hand, joint);
    }
  };
  struct AppliedForce {
    Eigen::VectorXd force;
    int steps = 0;

    void carry(StateStream& stream) {
      stream.sized(force);
      stream(steps);
    }
  };

  Body(Model::Pointer model, std::unique_ptr<Integrator> integrator,
       const IntegratorOptions& options, Eigen::Index low);
  void begin_frame(FrameKind frame);
  void begin_driven();
  Status check_pose(const Pose& pose) const;
  Status check_bone(std::size_t bone, const Pose& pose) const;
  Result<Eigen::VectorXd> weights_of(VertexId vertex) const;
  std::span<const BoneMap> bone_maps() const;
  Status add_point_force(const Signal& signal, VertexId vertex, const Eigen::Vector3d& force,
                         int steps);
  void take_place_forces();
  void gather_loads();
  void gather_frame();
  void gather_on_free();
  StepReport advance();
  StepReport advance_among(std::span<const PlacedCollider> colliders);
  StepReport advance_near(bool near);
  StepPush step_push() const;
  Pose step_end() const;
  // The parts of a step, for groups of bodies that touch each other.
  friend class BodyGroup;
  friend class StepParts;
  std::optional<StepReport> begin_step();
  bool near_something(std::span<const PlacedCollider> colliders);
  StepReport advance_in_parts(const StepReport& failure);
  void end_contact();
  StepReport end_step(StepReport report);
  void book_step(const StepReport& report);
  bool can_be_cut() const;
  void fall_asleep();
  void sleep_a_step();
  StepPoses step_poses() const;
  void carry_forces(StateStream& stream);
  void carry_frame(StateStream& stream);
  void carry_hands(StateStream& stream);
  const Grip* find_hand(std::size_t hand) const;
  Grip* find_hand(std::size_t hand);
  void limit_hand(Grip& grip) const;
  double end_frame_step(bool made);
  double end_frame_motion(bool made);
  double frame_kinetic(const Eigen::VectorXd& p) const;
  // weights: of the skin, for these vectors.
  template <class Number>
  void to_world(std::span<Number> vectors, bool places, BoneWeights Skin::*weights) const;
  void age_applied_forces();
  double kick() const;
  double total_energy() const;
  double harmonic_energy() const;
  bool look();
  void keep_sound_state();
  void put_back();
  StepReport explain(StepReport report);

  Model::Pointer model_;
  std::unique_ptr<Integrator> integrator_;
  IntegratorOptions options_;
  Eigen::Index low_;  // where the high band begins
  State state_;
  FrameKind frame_ = FrameKind::kFixed;
  FrameOwner<DrivenFrame> driven_;  // also of a fixed body on which gravity acts
  FrameOwner<FreeFrame> free_;
  FrameSharer<const Skin> skin_;            // of a driven body; null: one frame carries it
  mutable std::vector<BoneMap> bone_maps_;  // one a bone, at their poses
  std::shared_ptr<ContactStep> contact_;    // its type is not known here; no one shares it
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  std::vector<PointForce> points_;  // of a body whose frame moves
  std::vector<StepForce> step_forces_;
  RigidState rigid_before_, sound_rigid_;
  bool energy_method_ = false;  // the integrator reads StepLoad::coupling
  std::vector<Load> loads_;
  std::vector<AppliedForce> applied_;
  PlaceForces place_forces_;
  std::vector<Eigen::VectorXd> place_weights_;  // of a body on bones: of the places
  StepLoad step_load_;
  Eigen::VectorXd q_before_, p_before_;
  double kick_ = 0.0;  // of the step's loads, J
  std::int64_t steps_ = 0;
  std::int64_t iterations_ = 0;
  std::int64_t halved_steps_ = 0;
  bool booked_ = false;  // the step at hand was made in parts that are booked
  Sums sums_;
  std::vector<Grip> grips_;         // those that hold
  std::vector<std::size_t> hands_;  // the number of each
  std::size_t next_hand_ = 0;
  EnergyBound bound_;
  int steps_since_look_ = 0;
  State sound_;  // at the last sound look
  Sums sound_sums_;
  mutable PotentialWorkspace workspace_;
  mutable Evaluation evaluation_;
  mutable Eigen::VectorXd momentum_;
  mutable SurfaceWorkspace surface_;
  mutable Eigen::VectorXd shown_;  // r + 3p, or none
};

// kBound for kEnergy, else kSolver.
ErrorKind error_kind(StepFailure failure);

// Why the step from `time` (s) was not made, a sentence without a full stop.
std::string why_not_made(const StepReport& report, double time);

}  // namespace tremolo
