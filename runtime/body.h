// A body: a model with its frame, motion and loads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "common/result.h"
#include "common/state_stream.h"
#include "runtime/bodies/reduced/bones/skin.h"
#include "runtime/bodies/reduced/frames/driven_frame.h"
#include "runtime/bodies/reduced/frames/free_frame.h"
#include "runtime/bodies/reduced/frames/step_coupling.h"
#include "runtime/bodies/reduced/surface/surface.h"
#include "runtime/energy.h"
#include "runtime/energy_bound.h"
#include "runtime/integrator.h"
#include "runtime/load.h"
#include "runtime/model.h"
#include "runtime/parts.h"
#include "runtime/place_forces.h"

namespace tremolo {

// Error kUsage unless q and p have `modes` finite entries each.
Status check_state(Eigen::Index modes, const Eigen::VectorXd& q, const Eigen::VectorXd& p);

// True for avf, ep2 and ep4, which preserve the energy of a body whose frame moves.
bool is_energy_method(std::string_view method);

// Number of steps between checks of the energy: a check costs at most one evaluation of the force.
inline constexpr int kStepsBetweenLooks = 8;

// Support of a body. kFixed: it is at rest, and the mesh's frame is the world's. kDriven: it
// follows poses that are given step by step. kFree: there is none; the body falls, rotates and
// deforms, and these motions are coupled.
enum class FrameKind { kFixed, kDriven, kFree };

// Sums since a body's start, J.
struct BodySums {
  // Work of all external forces, of which support and gravity are parts. For loads it is average .
  // (q1 - q0) per step plus the method's extra work (exact for midpoint-type and energy-preserving
  // methods, second order for the others).
  double work = 0.0;
  double dissipated = 0.0;  // taken by damping
  double support = 0.0;     // work of the frame's accelerations on the motion relative to it
  // Work of gravity on a driven body's relative motion, or on all motion of a free body.
  double gravity = 0.0;

  void carry(StateStream& stream) { stream(work, dissipated, support, gravity); }
};

// Counts since a body's start.
struct BodyCounts {
  std::int64_t steps = 0;       // successful ones
  std::int64_t iterations = 0;  // of all steps
  std::int64_t halved = 0;      // steps that were subdivided

  void carry(StateStream& stream) { stream(steps, iterations, halved); }
};

// Momentum of a free body.
struct BodyMomentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   // kg m/s
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  // about the world's origin, N m s
};

// In place of a bone's number: all bones of a body, or its one frame.
inline constexpr std::size_t kAllBones = ~std::size_t{0};

// A body that touches nothing; contact_body.h has one that does. It starts at rest in the rest
// shape at time 0. Not thread-safe; different bodies of one model may step on different threads.
class Body {
 public:
  // Errors as make_integrator; kUsage for a method that does not support the frame (kDriven needs
  // avf, ep2, ep4, newmark or imexv; kFree needs avf, ep2 or ep4), for a model without inertia
  // integrals, for a free body whose model has a support, and for another body whose model has
  // none.
  static Result<Body> create(Model::Pointer model, std::string_view integrator = kDefaultIntegrator,
                             const IntegratorOptions& options = {},
                             FrameKind frame = FrameKind::kFixed);
  // A driven body on bones with its skin, which must have been made for this model. Its bones are
  // at rest at first; their poses are the identity. Errors as for kDriven; kUsage for a skin of
  // another model.
  static Result<Body> create(Model::Pointer model, std::string_view integrator,
                             const IntegratorOptions& options, std::shared_ptr<const Skin> skin);
  virtual ~Body() = default;
  Body(Body&&) = default;
  Body& operator=(Body&&) = default;

  const Model& model() const { return *model_; }
  const Integrator& integrator() const { return *integrator_; }
  const State& state() const { return state_; }
  const IntegratorOptions& options() const { return options_; }  // in use: step, damping, ...
  double time() const { return static_cast<double>(counts_.steps) * options_.step; }  // s

  // Sets q and p (each r long, finite); the integrator's state is discarded, time continues. Error
  // kUsage, with nothing changed: a wrong length or a value that is not finite.
  Status set_state(const Eigen::VectorXd& q, const Eigen::VectorXd& p);

  // Saves the complete state between steps as the bytes of a file (formats/saved/saved_file.h):
  // state, frame, gravity, damping, forces of apply_force(), sums, and the state of the method.
  // After restore() the following steps have the same bits as those of the saved body, under the
  // same loads in time, which are not saved.
  std::vector<std::byte> save() const;
  // Error kContent, with the body unchanged: bytes that are damaged, of another version, or of a
  // body with another model, method, frame or other loads in time.
  Status restore(std::span<const std::byte> bytes);
  // Saves or restores the same data without an identification, for callers that save several
  // bodies.
  void carry(StateStream& stream);
  // A hash of the body that the data must be restored into.
  std::uint64_t content_hash() const;

  // Sets Rayleigh damping alpha (1/s) and beta (s), or a ratio of each mode, from the next step on
  // and wakes the body: all damping before is replaced. Energy totals are kept. Discards the
  // method's cached state; allocates. Errors: kUsage, alpha or beta is negative or not finite;
  // those of check_ratios.
  Status set_damping(double alpha, double beta) { return set_damping({{alpha, beta}, {}, {}}); }
  Status set_damping(const DampingRatios& damping);
  // Sets another method and step (s) from the next step on. State, frame, loads and sums are
  // kept; the method's state is discarded. Time becomes the nearest multiple of the new step.
  // Errors: same as for make_integrator; kUsage, with nothing changed, for a method that does not
  // support the frame. Allocates.
  Status set_method(std::string_view integrator, double step);

  FrameKind frame() const { return kHasFrames ? frame_ : FrameKind::kFixed; }
  // Number of bones of a body on bones; else 0.
  std::size_t bones() const { return skin_ ? skin_->bones() : 0; }
  const Skin* skin() const { return skin_.get(); }
  // Pose of the frame; for a kFixed body the world's. Vertices are at pose() (X + U q). Of a body
  // on bones: the bone's pose relative to its pose at rest, in the mesh's coordinates; bone <
  // bones().
  Pose pose(std::size_t bone = 0) const;
  // Moves the body, or one of its bones, without an impulse: a driven frame is then at rest; a free
  // body keeps its velocity, and its spin along its own axes. Error kUsage: a fixed body, no such
  // bone, or a pose that is not finite or whose rotation does not have length one to 1e-6.
  Status set_pose(const Pose& pose, std::size_t bone = kAllBones);
  // Sets the pose of a driven body's frame, or of one of its bones, at the end of the next step;
  // without a call the frame is at rest. With `motion` the accelerations of that step are known;
  // without it they are extrapolated from the past poses
  // (runtime/bodies/reduced/frames/driven_frame.h). Errors as set_pose; kUsage if the body is not
  // driven.
  Status move_to(const Pose& next, const std::optional<FrameMotion>& motion = std::nullopt,
                 std::size_t bone = kAllBones);

  // Sets the motion of a free body. velocity: of the centre of mass, m/s, world. spin: rad/s, along
  // the body's axes. Error kUsage: the body is not free or a value is not finite.
  Status set_motion(const Eigen::Vector3d& velocity, const Eigen::Vector3d& spin);
  // Zeros unless the body is free.
  RigidState rigid_state() const { return free_ ? free_->rigid() : RigidState{}; }
  BodyMomentum momentum() const;

  // Sets gravity, m/s^2, world, from the next step on. Error kUsage: it is not finite, or not zero
  // and the model has no inertia integrals.
  Status set_gravity(const Eigen::Vector3d& gravity);
  const Eigen::Vector3d& gravity() const { return gravity_; }
  // Gravity's force on the coordinates at the present pose of the frame or the bones, r; zeros for
  // a free body.
  Eigen::VectorXd gravity_force() const;
  // Rotation of a vertex's surroundings from the mesh's axes to the world's: the frame's rotation,
  // or the blend of the bones' rotations, which is not orthogonal between bones. Errors as
  // Model::vertex.
  Result<Eigen::Matrix3d> turn_at(VertexId vertex) const;

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

  // Takes one step and allocates nothing. If the report is not converged, the time and the pending
  // loads are as before, and so is the state if its energy is valid. If it is not, because the
  // method has exploded, or if this step's energy is far too high (StepFailure::kEnergy), the
  // state and the sums return to those of the last valid check, and the integrator's
  // state is discarded.
  //
  // The energy is checked at the start, when a state is set and every kStepsBetweenLooks steps;
  // runtime/energy_bound.h defines a valid energy.
  StepReport step();
  const EnergyBound& energy_bound() const { return bound_; }

  // True if a load can still act in a later step.
  bool load_to_come() const;

  const BodySums& sums() const { return sums_; }
  const BodyCounts& counts() const { return counts_; }

  // Energy of the present state; evaluates V. The high band begins at coordinate `low`, 0 <= low <=
  // r; without it, the band is that of the integrator's split or, for a method without a split, of
  // the one that options.split would give.
  Energy energy(std::optional<Eigen::Index> low = std::nullopt) const;

  // The first hit of a ray on the deformed surface, from either side; nullopt: none. origin: m,
  // world; direction: world, of any length. Error kUsage: a value is not finite, or the direction
  // is zero. Nothing is allocated after the first call of a model, or of a body on several bones,
  // for which every triangle is tested.
  Result<std::optional<SurfaceHit>> pick(const Eigen::Vector3d& origin,
                                         const Eigen::Vector3d& direction,
                                         SurfaceKind surface = SurfaceKind::kDrawn) const;

  // The coordinates for drawing: q, followed by the forces at the end of the last step at the
  // vertices for which the model has a response, along the body's axes, N; r + 3p. Energy and rays
  // ignore the shape W f. Valid until the next call.
  const Eigen::VectorXd& shown() const;

  // U_vertex q + W_vertex f, m. Errors as Model::vertex.
  Result<Eigen::Vector3d> displacement(VertexId vertex) const;

  // pose() (X + displacement), or on bones their blend, m. Errors as Model::vertex.
  Result<Eigen::Vector3d> position(VertexId vertex) const;

  // Positions of a surface's vertices, pose() (X + U q + W f), or on bones their blend, x y z x y z
  // ..., m. out: three numbers a vertex, of model().drawn() or, for kBoundary, of
  // model().surface(); else kUsage. Allocates nothing.
  Status surface_positions(std::span<double> out, SurfaceKind surface = SurfaceKind::kDrawn) const;
  // The drawn surface for display: positions and, unless `normals` is empty, the unit normals of
  // its vertices, weighted by triangle area: zero where a vertex's triangles have no normal. Each 3
  // * model().drawn().rest.size() long, else kUsage. Reads rows that the model makes at the first
  // call (runtime/bodies/reduced/surface/surface.h gives their error), and allocates nothing after
  // a body's first call.
  Status surface(std::span<float> positions, std::span<float> normals = {}) const;

 protected:
  // The parts of a step, for a body that is in contact: begin_step(), then advance() or a step of
  // another solver, then end_step(). begin_step: a report if the loads are not valid.
  std::optional<StepReport> begin_step();
  StepReport advance();
  // outside: work of forces that are not among the body's loads, J. summed: the energies of the
  // step are in the sums already.
  StepReport end_step(StepReport report, double outside, bool summed);
  // Adds the energies of a step, or of a part of it, to the sums.
  // kick: the energy that those forces give the body at rest, J (runtime/energy_bound.h).
  void book_step(const StepReport& report, double outside, double kick = 0.0);
  // Undoes advance(): the state is that of begin_step(). p: the momentum before it.
  void take_back(const Eigen::VectorXd& p);
  // Poses of the frame at both ends of the step, as far as they are known.
  StepPoses step_poses() const;
  // Pose of the frame at the end of a step that succeeded.
  Pose step_end() const { return free_ ? free_->pose() : step_poses().end; }
  // True unless a frame that follows given poses moves in the step.
  // Removes the motion; returns the energy that this takes, J, which is added to the work.
  double stop_motion();
  // Keeps the present state as that of the last valid check.
  void keep_sound_state();
  // One step of time for a body at rest.
  void rest_a_step();
  // Keep the sums of a derived body with the state of a valid check, and put them back.
  virtual void keep_outside_sums() {}
  virtual void put_back_outside_sums() {}
  // Rotation from the axes of the world to those at a place of Model::response_places().
  Eigen::Matrix3d turn_at_place(Eigen::Index place) const;
  bool has_energy_method() const { return energy_method_; }
  // Weights of a vertex for the bones of a skin, in their order. Errors: kUsage if the skin has
  // none; those of reading the interior.
  Result<std::span<const double>> weights_of(VertexId vertex) const;
  std::span<const BoneMap> bone_maps() const;  // at the present poses

  Model::Pointer model_;
  std::unique_ptr<Integrator> integrator_;
  IntegratorOptions options_;
  State state_;
  FrameOwner<DrivenFrame> driven_;  // also of a fixed body on which gravity acts
  FrameOwner<FreeFrame> free_;
  PlaceForces place_forces_;
  StepLoad step_load_;
  Eigen::VectorXd q_before_;
  // By set_state(), set_pose() or set_motion() since the last step of a group.
  bool moved_ = false;

 private:
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
  // The bones that kAllBones or a number means: from the first to the last one, without it.
  Result<std::pair<std::size_t, std::size_t>> bones_of(std::size_t bone) const;
  Status add_point_force(const Signal& signal, VertexId vertex, const Eigen::Vector3d& force,
                         int steps);
  void take_place_forces();
  void gather_loads();
  void gather_frame();
  void gather_on_free();
  void carry_forces(StateStream& stream);
  void carry_frame(StateStream& stream);
  double end_frame_motion(bool made);
  double frame_kinetic(const Eigen::VectorXd& p) const;
  // weights: the weights of the skin to use for these vectors.
  template <class Number>
  void to_world(std::span<Number> vectors, bool places, BoneWeights Skin::*weights) const;
  void age_applied_forces();
  double kick() const;
  double total_energy() const;
  // direction: of unit length.
  std::optional<SurfaceTree::Hit> nearest(const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction,
                                          SurfaceKind surface) const;
  const Evaluation& at_state() const;
  double harmonic_energy() const;
  bool look();
  void put_back();
  StepReport explain(StepReport report);

  Eigen::Index low_;  // where the high band begins
  FrameKind frame_ = FrameKind::kFixed;
  FrameSharer<const Skin> skin_;            // of a driven body; null: it has one frame
  mutable std::vector<BoneMap> bone_maps_;  // one per bone, at their poses
  Eigen::Vector3d gravity_ = Eigen::Vector3d::Zero();
  std::vector<PointForce> points_;  // for a body whose frame moves
  std::vector<StepForce> step_forces_;
  RigidState rigid_before_, sound_rigid_;
  bool energy_method_ = false;  // the integrator reads StepLoad::coupling
  std::vector<Load> loads_;
  std::vector<AppliedForce> applied_;
  std::vector<Eigen::VectorXd> place_weights_;  // for a body on bones: of the places
  double kick_ = 0.0;                           // of the step's loads, J
  BodyCounts counts_;
  BodySums sums_;
  EnergyBound bound_;
  int steps_since_look_ = 0;
  State sound_;  // at the last valid check
  BodySums sound_sums_;
  mutable PotentialWorkspace workspace_;
  mutable Evaluation evaluation_;        // of at_state()
  mutable Eigen::VectorXd evaluated_q_;  // where, r; NaN before the first
  mutable Eigen::VectorXd momentum_;
  mutable SurfaceWorkspace surface_;
  mutable Eigen::VectorXd shown_;            // r + 3p, or none
  mutable std::vector<double> seen_places_;  // of nearest(), on several bones
};

// kBound for kEnergy, else kSolver.
ErrorKind error_kind(StepFailure failure);

// The reason why the step from `time` (s) failed, a sentence without a full stop.
std::string failure_message(const StepReport& report, double time);

}  // namespace tremolo
