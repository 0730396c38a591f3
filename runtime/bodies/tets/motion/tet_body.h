// A moving body of corotated tetrahedra: its state, its degrees, its step.
//
// Newton's method solves a step, for one body or together with the bodies in contact with it
// (tet_island.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/bodies/tets/elements/tet_system.h"
#include "runtime/bodies/tets/motion/degree_choice.h"
#include "runtime/bodies/tets/motion/tet_hand.h"
#include "runtime/bodies/tets/solve/active_solve.h"
#include "runtime/bodies/tets/solve/mass_projection.h"
#include "runtime/bodies/tets/solve/rigid_balance.h"
#include "runtime/bodies/tets/solve/tet_stage.h"
#include "runtime/math/sparse/block_cholesky.h"

namespace tremolo {

// Handling of a step that max_iterations do not solve (tet_island.h).
enum class UnsolvedStep {
  kCut,   // it is subdivided
  kTake,  // it is accepted, which is reported
  // As kCut without contact; in contact it is solved to a thousandth, and accepted before that,
  // which is reported, where corrections gain little.
  kTakeContact
};

struct TetBodyOptions {
  TetMethod method = TetMethod::kBdf2;
  RotationLaw law = RotationLaw::kLeastEnergy;
  TangentKind tangent = TangentKind::kExact;
  double step = 1.0 / 60.0;                           // s
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2
  // 1/s. Damps the motion relative to the nearest rigid motion that the fixed points allow, with
  // the force -alpha M (v - rigid_part(v)): it conserves momentum and angular momentum.
  double alpha = 0.0;
  double beta = 0.0;  // s; damping proportional to the stiffness
  double drag = 0.0;  // 1/s; damps the whole motion with -drag M v, like a resting medium
  double tolerance =
      1e-6;  // of the residual over the weight and the forces at the start of the step
  double linear_tolerance = 1e-3;  // of a correction's linear system
  int max_iterations = 20;         // corrections in a step
  UnsolvedStep unsolved = UnsolvedStep::kCut;
  bool guard = true;  // repeats steps of midpoint and newmark that would add energy
  DegreeOptions degree;
};
// Errors (kContent) name the value: a step, tolerance or damping out of range, thresholds in the
// wrong order.
Status check(const TetBodyOptions& options);

// Report of a step.
struct TetStepReport {
  bool converged = true;          // the step succeeded
  int iterations = 0;             // of Newton's method
  int linear = 0;                 // of conjugate gradients
  int parts = 1;                  // number of steps that it was divided into
  bool linearised = false;        // each of them is one correction; no solution was found
  bool unsolved = false;          // at least one of them was accepted without a solution
  int guarded = 0;                // number of them that would have added energy
  std::size_t switched = 0;       // edges that changed their degree
  double energy_of_switch = 0.0;  // energy that this took from the body, J
  // Largest displacement of an end or a middle of an edge by it, over the edge's length.
  double jump = 0.0;

  void carry(StateStream& stream) {
    stream(converged, iterations, linear, parts, linearised, unsolved, guarded, switched);
    stream(energy_of_switch, jump);
  }
};

class TetContact;
class TetIsland;
class TetStep;

// Energy added by midpoint or newmark.
struct TetGuard {
  bool known = false;  // `energy` is that of the present state
  // energy: J. gained: since as much was last lost, J. largest: largest kinetic plus elastic
  // energy, J.
  double energy = 0.0, gained = 0.0, largest = 0.0;

  void carry(StateStream& stream) { stream(known, energy, gained, largest); }
};

class TetBody {
 public:
  TetBody(TetBody&&) noexcept;
  TetBody& operator=(TetBody&&) noexcept;
  ~TetBody();

  // Makes a body at rest at the mesh's position. Errors: those of check().
  static Result<TetBody> create(TetModelPointer model, const TetBodyOptions& options);

  const TetModel& model() const { return system_.model(); }
  const TetBodyOptions& options() const { return options_; }
  const TetSystem& system() const { return system_; }
  const Eigen::VectorXd& positions() const { return now_.x; }   // 3 nodes(), m
  const Eigen::VectorXd& velocities() const { return now_.v; }  // m/s
  double time() const { return time_; }
  std::int64_t steps() const { return steps_; }

  // Sets positions and velocities. Control points of linear edges are moved to the mean of their
  // ends; fixed ones move to the given values. Errors (kContent): another length; a value that is
  // not finite.
  Status set_state(const Eigen::VectorXd& x, const Eigen::VectorXd& v);
  // Puts the body at rest in its equilibrium under gravity and constant forces on control points,
  // N, 3 nodes(). Call it for a body in its shape at rest, before the first step. Adaptive edges
  // get the degrees that they keep there. Errors, with nothing changed: kContent if its fixed
  // points leave a rigid motion of a part of it; kSolver if it buckles under a part of the forces,
  // or if no equilibrium is found.
  Status settle(const Eigen::VectorXd& forces);
  // Sets 1 or 2 for each edge; positions and velocities are projected (degree_choice.h). Returns
  // the energy that this took, J.
  double set_degrees(std::span<const std::uint8_t> degrees);

  // Sets the grab of the body from the next step on; empty: none. Errors (kUsage), with nothing
  // changed: control points that do not exist, a negative stiffness or damping, a value that is not
  // finite.
  Status set_hand(const std::optional<TetHand>& hand);
  const std::optional<TetHand>& hand() const { return hand_; }
  // Compliance of a supported body at a point: displacement at rest per force there, m/N.
  Eigen::Matrix3d give_at(const TetHand& place);

  // Takes a step of this body alone. contact: its contact; null: none. On failure the state is as
  // before.
  TetStepReport step(TetContact* contact = nullptr);
  // Sets velocities and the method's state to zero.
  void stop();
  // Advances the time by a step without motion.
  void skip_step();

  // Positions at which forces are evaluated in a step, for partners of a contact (tet_contact.h).
  const Eigen::VectorXd& trial_places() const { return s_; }

  // Sets gravity from the next step on, m/s^2, finite. gravity_energy() is then still the work of
  // gravity since the start, with the opposite sign, plus its value there. Allocates nothing.
  void set_gravity(const Eigen::Vector3d& gravity);

  // Energies of the state: kinetic, elastic and of gravity, J.
  double kinetic_energy() const { return system_.kinetic_energy(now_.v); }
  double elastic_energy();
  double gravity_energy() const;
  Eigen::Vector3d momentum() const { return system_.momentum(now_.v); }
  Eigen::Vector3d angular_momentum() const { return system_.angular_momentum(now_.x, now_.v); }
  std::size_t bytes() const;  // of the body, without the shared model

  // Saves or restores the state between steps, to the bit, of a body without a grab.
  void carry(StateStream& stream);

 private:
  friend class TetIsland;  // both call the following functions
  friend class TetStep;    // runtime/mixed/tet_step.h
  friend class TetRest;    // tet_settle.cpp

  TetBody(TetModelPointer model, const TetBodyOptions& options);
  void keep_state();
  void restore_state();  // the complete state
  void rewind();         // to the start of the step, without the step before it
  void keep_part();      // x and v, at the start of a part of a step
  void rewind_part();
  void find_load();
  // Energy of the state, and of its contact with fixed obstacles, J.
  double guarded_energy(const TetContact* contact);
  // Removes up to `excess` J of the kinetic energy relative to the nearest rigid motion. Returns
  // the energy removed.
  double take_internal_energy(double excess);
  // Sets momentum and angular momentum to those of `before` plus the contribution of gravity in the
  // time `passed`, s. Only for a body without other forces.
  void restore_momenta(const TetMotion& before, double passed);
  // After a step of bdf2 that was taken by implicit-euler, which gives the body all the momentum of
  // its forces at once. start: its start; before: the step before that; null: there was none. Sets
  // the velocity at the start that the next step uses: bdf2 conserves M (3 v_1 - v_0)/2 plus h F,
  // and what it had still to pass on, it passes on, but what was given is not given again.
  void begin_bdf2_again(const TetMotion& start, const TetMotion* before);
  // Gravity accelerates the body in the next step by this much more than in the last one, m/s^2.
  // Changes the velocity before the last step, so that bdf2 gives the body its momentum at once, as
  // it does for forces that stay.
  void expect_change(const Eigen::Vector3d& acceleration);
  void begin(TetMethod method, double h);
  void guess(bool stay);  // initial displacement; stay: zero
  // Computes the forces at way_, without contact, in force_; they then become the residual.
  void find_forces();
  void add_hand_force();
  // deceleration += the mass-proportional part of damping, divided by the mass, m/s^2, at positions
  // x and velocities v.
  void add_mass_damping(const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                        Eigen::VectorXd& deceleration);
  // c of the part c M of Newton's matrix; g is the stage's rate.
  double mass_factor() const {
    return stage_.rate * (stage_.rate + options_.alpha + options_.drag);
  }
  // Newton's matrix has alpha M instead of alpha (M - M rigid_part); this corrects the rigid part
  // of the correction.
  void free_rigid_correction();
  void add_to_held(const Eigen::Vector3d& force);
  double close_residual();  // |r|^2
  double stop_size(double tolerance) const;
  // An edge's row of the residual below this is left by the solve, N.
  double edge_noise() const;
  void assemble(TangentKind tangent, bool single);
  void take_preconditioner(bool single);  // of the last assembled matrix, without contacts
  // For a body without contact: stores the number of directions of its last search, and checks
  // whether a factorisation has fewer multiplications. Memory of the fully quadratic pattern is
  // allocated with the body, and only for slender ones: for others it is larger than the body's.
  void note_search(int iterations);
  bool factor_pays() const;
  bool solve_by_factor();  // correction_ = matrix_^-1 residual_; false if it is not positive
  void balance_momenta();
  void end();
  void find_acceleration();
  void choose_degrees(TetStepReport& report);
  double largest_jump() const;  // from saved_.x

  TetBodyOptions options_;
  TetSystem system_;
  DegreeChoice choice_;
  ActiveSolve solve_;
  MassProjection projection_;
  BlockMatrix matrix_;
  std::optional<BlockCholesky> factor_;
  int search_iterations_ = 0;
  std::size_t search_nodes_ = 0;
  RigidFreedom freedom_;
  std::vector<std::uint8_t> folded_;  // a flag for each control point that is not active
  TetMotion now_, before_, saved_, saved_before_, part_;
  TetGuard guard_;
  TetStage stage_;
  bool has_before_ = false, had_before_ = false, has_acceleration_ = false, held_ = false;
  // A given force of the next step, on control points, in steps of bdf2, N; empty: none.
  Eigen::VectorXd given_;
  Eigen::VectorXd way_, s_, start_, velocity_, force_, residual_, correction_, direction_, inertia_,
      weight_, work_, rigid_;
  double rounding_scale_ = 0.0, load_ = 0.0, time_ = 0.0;
  double gravity_shift_ = 0.0;  // of gravity_energy(), by changes of gravity, J
  std::int64_t steps_ = 0;
  std::optional<TetHand> hand_;
  std::unique_ptr<TetIsland> alone_;
};

}  // namespace tremolo
