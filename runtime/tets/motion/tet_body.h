// A body of corotated tetrahedra that moves: its state, its degrees, its step.
//
// A step is found by Newton's method, by itself or together with bodies that it touches
// (tet_island.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/sparse/block_cholesky.h"
#include "runtime/tets/elements/tet_system.h"
#include "runtime/tets/motion/degree_choice.h"
#include "runtime/tets/motion/tet_hand.h"
#include "runtime/tets/solve/active_solve.h"
#include "runtime/tets/solve/mass_projection.h"
#include "runtime/tets/solve/rigid_balance.h"
#include "runtime/tets/solve/tet_stage.h"

namespace tremolo {

// What becomes of a step that max_iterations do not solve (tet_island.h).
enum class UnsolvedStep {
  kCut,         // it is cut
  kTake,        // it is taken as it is, which is reported
  kTakeContact  // kCut where nothing touches; a step in contact is a few corrections of
                // implicit-euler, which is cut where it would add energy
};

struct TetBodyOptions {
  TetMethod method = TetMethod::kBdf2;
  RotationLaw law = RotationLaw::kLeastEnergy;
  TangentKind tangent = TangentKind::kExact;
  double step = 1.0 / 60.0;                           // s
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // m/s^2
  // 1/s. Damps the motion relative to the nearest rigid one that the fixed points allow, with the
  // force -alpha M (v - rigid_part(v)): it keeps momentum and angular momentum.
  double alpha = 0.0;
  double beta = 0.0;  // s; damping proportional to the stiffness
  double drag = 0.0;  // 1/s; damps the whole motion, with -drag M v, as a resting medium does
  double tolerance =
      1e-6;  // of the residual over the weight and the forces at the step's beginning
  double linear_tolerance = 1e-3;  // of a correction's equation
  int max_iterations = 20;         // corrections of a step
  UnsolvedStep unsolved = UnsolvedStep::kCut;
  bool guard =
      true;  // steps of midpoint and newmark that would add energy are taken in another way
  DegreeOptions degree;
};
// Errors (kContent) name the value: a step, tolerance or damping out of range, thresholds the wrong
// way round.
Status check(const TetBodyOptions& options);

// converged: a step was made. iterations: Newton's; linear: those of conjugate gradients. parts:
// how many steps it took. linearised: each of them is one correction, no solution was found.
// unsolved: one of them was taken as it was. guarded: so many of them would have
// added energy.
// switched: edges that changed their degree. energy_of_switch: J, what they took out of the body.
// jump: the largest way of an end or a middle of an edge in that, over the edge's length.
struct TetStepReport {
  bool converged = true;
  int iterations = 0;
  int linear = 0;
  int parts = 1;
  bool linearised = false;
  bool unsolved = false;
  int guarded = 0;
  std::size_t switched = 0;
  double energy_of_switch = 0.0;
  double jump = 0.0;
};

class TetContact;
class TetIsland;

// Energy that midpoint or newmark has added. known: `energy`, J, is that of the state as it is.
// gained: J, since as much was last taken. largest: kinetic and elastic energy, J, that there was
// at most.
struct TetGuard {
  bool known = false;
  double energy = 0.0, gained = 0.0, largest = 0.0;
};

class TetBody {
 public:
  TetBody(TetBody&&) noexcept;
  TetBody& operator=(TetBody&&) noexcept;
  ~TetBody();

  // At rest in the mesh's place. Errors: those of check().
  static Result<TetBody> create(TetModelPointer model, const TetBodyOptions& options);

  const TetModel& model() const { return system_.model(); }
  const TetBodyOptions& options() const { return options_; }
  const TetSystem& system() const { return system_; }
  const Eigen::VectorXd& positions() const { return now_.x; }   // 3 nodes(), m
  const Eigen::VectorXd& velocities() const { return now_.v; }  // m/s
  double time() const { return time_; }
  std::int64_t steps() const { return steps_; }

  // Control points of linear edges are put at the mean of their ends, held ones move as told.
  // Errors (kContent): another length; a value that is not finite.
  Status set_state(const Eigen::VectorXd& x, const Eigen::VectorXd& v);
  // 1 or 2 for each edge; positions and velocities are projected (degree_choice.h). The energy that
  // it took, J.
  double set_degrees(std::span<const std::uint8_t> degrees);

  // What pulls at the body from the next step on; nothing: no hand. Errors (kUsage), and nothing is
  // changed: control points that are none, a stiffness or damping that is negative, what is not
  // finite.
  Status set_hand(const std::optional<TetHand>& hand);
  const std::optional<TetHand>& hand() const { return hand_; }
  // By how much a force on a place of a body that is held moves it at rest where it is now, m/N.
  Eigen::Matrix3d give_at(const TetHand& place);

  // Makes a step by itself. contact: what it touches; null: nothing. Where it fails, the state is
  // as before.
  TetStepReport step(TetContact* contact = nullptr);
  // Velocities and what is carried from step to step become zero.
  void stop();
  // A step passes in which the body does not move.
  void skip_step();

  // Where forces are taken in a step, for partners of a contact (tet_contact.h).
  const Eigen::VectorXd& trial_places() const { return s_; }
  const Eigen::VectorXd& trial_velocities() const { return velocity_; }

  // Energies of the state: kinetic, elastic and of gravity, J.
  double kinetic_energy() const { return system_.kinetic_energy(now_.v); }
  double elastic_energy();
  double gravity_energy() const;
  Eigen::Vector3d momentum() const { return system_.momentum(now_.v); }
  Eigen::Vector3d angular_momentum() const { return system_.angular_momentum(now_.x, now_.v); }
  std::size_t bytes() const;  // of the body; the model's come once

 private:
  friend class TetIsland;  // which takes the following in turn

  TetBody(TetModelPointer model, const TetBodyOptions& options);
  void keep_state();
  void restore_state();  // all of it
  void rewind();         // to where the step began, without what came before
  void keep_part();      // x and v, where a part of a step begins
  void rewind_part();
  // Energy of the state, and of its contact with what is at rest, J.
  double guarded_energy(const TetContact* contact);
  // Takes `excess` J of the kinetic energy relative to the nearest rigid motion, or all there is.
  // Returns what it took.
  double take_internal_energy(double excess);
  // Momentum and angular momentum become those of `before`, and what gravity added in the time that
  // passed, s. Only of a body that nothing else acts on.
  void restore_momenta(const TetMotion& before, double passed);
  void begin(TetMethod method, double h);
  void guess(bool stay);  // the way to begin with; stay: none, where the body is
  // The forces at way_, without contact, go to force_, and then become the residual.
  void find_forces();
  void add_hand_force();
  // deceleration += the part of damping that is proportional to the mass, over the mass, m/s^2, at
  // positions x and velocities v.
  void add_mass_damping(const Eigen::VectorXd& x, const Eigen::VectorXd& v,
                        Eigen::VectorXd& deceleration);
  // c of the part c M of Newton's matrix; g is the stage's rate.
  double mass_factor() const {
    return stage_.rate * (stage_.rate + options_.alpha + options_.drag);
  }
  // Newton's matrix has alpha M for alpha (M - M rigid_part): what that leaves out of the
  // correction's rigid part.
  void free_rigid_correction();
  void add_to_held(const Eigen::Vector3d& force);
  double close_residual();  // |r|^2
  double stop_size(double tolerance) const;
  void assemble(TangentKind tangent, bool single);
  void take_preconditioner(bool single);  // of what was assembled last, without touches
  // Of a body that touches nothing: how many directions its last search took, and whether a
  // factorisation has fewer multiplications. Its memory, of the fully quadratic pattern, is taken
  // when the body is made, and only of slender ones: of others it is more than the body's.
  void note_search(int iterations);
  bool factor_pays() const;
  bool solve_by_factor();  // correction_ = matrix_^-1 residual_; false where it is not positive
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
  Eigen::VectorXd way_, s_, start_, velocity_, force_, residual_, correction_, direction_, inertia_,
      weight_, work_, rigid_;
  double rounding_scale_ = 0.0, load_ = 0.0, time_ = 0.0;
  std::int64_t steps_ = 0;
  std::optional<TetHand> hand_;
  std::unique_ptr<TetIsland> alone_;
};

}  // namespace tremolo
