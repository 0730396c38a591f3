// A body of corotated tetrahedra that moves: its state, its degrees, its step.
//
// A step finds d in M g^2 (d - d_a) = F(x_v + d, g d) (tet_stage.h) by Newton's method with the
// matrix
//   M (g^2 + alpha g) + dforce/dx + beta g ddamping/dv,
// first with the exact derivative; where that is indefinite, with R K R^T. Each correction is
// shortened until the residual no longer points back. A step that is not solved is cut into two,
// then eight of implicit-euler; where even those have no solution (an element goes through a flat
// shape and its rotation jumps), into eight of one correction each with R K R^T.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "runtime/tets/active_solve.h"
#include "runtime/tets/degree_choice.h"
#include "runtime/tets/tet_stage.h"
#include "runtime/tets/tet_system.h"

namespace tremolo {

// step: s. gravity: m/s^2. alpha, 1/s, and beta, s: Rayleigh's. tolerance: of the residual over the
// forces at the step's beginning. linear_tolerance: of a correction's equation.
struct TetBodyOptions {
  TetMethod method = TetMethod::kBdf2;
  RotationLaw law = RotationLaw::kLeastEnergy;
  TangentKind tangent = TangentKind::kExact;
  double step = 1.0 / 60.0;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  double alpha = 0.0;
  double beta = 0.0;
  double tolerance = 1e-6;
  double linear_tolerance = 1e-3;
  int max_iterations = 20;
  DegreeOptions degree;
};
// Errors (kContent) name the value: a step, tolerance or damping out of range, thresholds the wrong
// way round.
Status check(const TetBodyOptions& options);

// What a body is pushed by beside gravity. The forces are of the control points, N, and their
// stiffness goes into blocks of the pattern.
class TetPushes {
 public:
  virtual ~TetPushes() = default;
  // f += forces at places s and velocities v; all nodes, not folded.
  virtual void add_forces(const Eigen::VectorXd& s, const Eigen::VectorXd& v,
                          Eigen::VectorXd& f) = 0;
  // a += -dforce/ds - velocity_rate dforce/dv of the last add_forces, through `system`.
  virtual void add_stiffness(const TetSystem& system, double velocity_rate, BlockMatrix& a) = 0;
};

// converged: a step was made. iterations: Newton's; linear: those of conjugate gradients. parts:
// how many steps it took. linearised: each of them is one correction, no solution was found.
// switched: edges that changed their degree. energy_of_switch: J, what they took out of the body.
struct TetStepReport {
  bool converged = true;
  int iterations = 0;
  int linear = 0;
  int parts = 1;
  bool linearised = false;
  std::size_t switched = 0;
  double energy_of_switch = 0.0;
};

class TetBody {
 public:
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

  // Makes a step. Where it fails, the state is as before.
  TetStepReport step(TetPushes* pushes = nullptr);

  // Of the state: kinetic, elastic and of gravity, J.
  double kinetic_energy() const { return system_.kinetic_energy(now_.v); }
  double elastic_energy();
  double gravity_energy() const;
  Eigen::Vector3d momentum() const { return system_.momentum(now_.v); }
  Eigen::Vector3d angular_momentum() const { return system_.angular_momentum(now_.x, now_.v); }
  std::size_t bytes() const;  // of the body; the model's come once

 private:
  TetBody(TetModelPointer model, const TetBodyOptions& options);
  bool solve_stage(TetPushes* pushes, TetStepReport& report);
  double find_residual(TetPushes* pushes);
  void find_correction(TetPushes* pushes, TangentKind tangent, TetStepReport& report);
  bool take_correction(TetPushes* pushes, double& size);
  void balance_momenta();
  bool make_step(TetMethod method, double h, TetPushes* pushes, TetStepReport& report);
  bool make_linear_step(double h, TetPushes* pushes, TetStepReport& report);
  bool make_parts(int parts, bool linear, TetPushes* pushes, TetStepReport& report);
  void find_acceleration();

  TetBodyOptions options_;
  TetSystem system_;
  DegreeChoice choice_;
  ActiveSolve solve_;
  BlockMatrix matrix_;
  TetMotion now_, before_, saved_, saved_before_;
  TetStage stage_;
  bool has_before_ = false, has_acceleration_ = false, held_ = false;
  Eigen::VectorXd way_, s_, start_, velocity_, force_, residual_, correction_, direction_, inertia_,
      weight_;
  double rounding_scale_ = 0.0, time_ = 0.0;
  std::int64_t steps_ = 0;
};

}  // namespace tremolo
