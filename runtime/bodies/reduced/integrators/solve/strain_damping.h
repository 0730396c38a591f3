// Stiffness damping by strain rates, independent of rotation (Kelvin-Voigt; docs/theory.md,
// "Stiffness damping"). The force on a velocity v at q is beta J(q)^T G J(q) v, of which the
// methods include beta Lambda v in D = alpha + beta Lambda (damping.h). This file adds the
// remaining part
//
//     rest(q) v = beta [J(q)^T G J(q) - Lambda] v        (runtime/math/kernels/strain_matrix.h),
//
// In a step with d = q1 - q0 and the middle qm, beta/h J(qm)^T G J(qm) d takes beta/h Dy^T G Dy >=
// 0 of the energy, Dy = y(q1) - y(q0), exactly.
//
// A model without G (imported, or of a file before 1.4) is damped by the positive part of the
// tangent K at one position of the step, beta [K_+ - Lambda] v: rotation is not damped there either
// where K is positive, and no velocity gains energy.
#pragma once

#include <memory>
#include <utility>

#include <Eigen/Eigenvalues>

#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "runtime/math/dense/small_matrices.h"
#include "runtime/math/kernels/potential.h"
#include "runtime/math/kernels/strain_matrix.h"
#include "runtime/model.h"

namespace tremolo {

// Float's share of a solve's tolerance: its rounding is some 1e-8 to 1e-7 of the force.
inline constexpr double kQuickTolerance = 5e-7;

class StrainDamping {
 public:
  // beta: s. The model must outlive this, and its strain_matrix() must have been read if it has one
  // (make_integrator() does that).
  //
  // tolerance: of the solve in which the force takes part, relative. From kQuickTolerance on the
  // small part of the force that is not the stretch of a coordinate is computed in float
  // (StrainMatrix::multiply_quickly).
  StrainDamping(const Model& model, double beta, double tolerance = 0.0);

  // False: beta = 0 or a linear model; the rest is zero.
  bool present() const { return beta_ > 0.0; }
  double beta() const { return beta_; }  // s; 0 where not present

  // The tolerance of the solve that follows.
  void set_tolerance(double tolerance) { quick_ = tolerance >= kQuickTolerance; }

  // Sets the position, r, at which K_+ is computed from now on, for a model without G; else does
  // nothing.
  void stand_at(const Eigen::VectorXd& q);

  // out = rest(q) v. Returns v . rest(q) v, which is at least -v . beta Lambda v. r each; nothing
  // is allocated.
  double force(const Eigen::VectorXd& q, const Eigen::VectorXd& v, Eigen::VectorXd& out);

  // A step's d has moved by `move` since force(qm, d) returned `work`, d . rest(qm) d, to an end
  // q1. Returns that work now, to second order in the move: by the strains' change from there to
  // q1, with the stresses of the last product. bent: K move. scratch: r, overwritten. Only for a
  // model with G, else take force() again, which costs little there: has_stresses().
  double work_after(const Eigen::VectorXd& move, const Eigen::VectorXd& q1,
                    const Eigen::VectorXd& bent, double work, Eigen::VectorXd& scratch);
  bool has_stresses() const { return strains_ != nullptr; }

  // stand_at(q) and force(q, v): for methods that evaluate the force where it acts.
  double force_at(const Eigen::VectorXd& q, const Eigen::VectorXd& v, Eigen::VectorXd& out) {
    stand_at(q);
    return force(q, v, out);
  }

 private:
  // For a model without G.
  struct Tangent {
    PotentialWorkspace workspace;
    Evaluation evaluation;
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
    SmallCholesky factor;
    Eigen::MatrixXd product;
    Eigen::MatrixXd rest;  // K_+ - Lambda
  };

  double beta_ = 0.0;
  bool quick_ = false;
  const Potential* potential_ = nullptr;
  std::shared_ptr<const StrainMatrix> strains_;
  StrainMatrix::Workspace workspace_;
  Eigen::VectorXd between_;
  std::unique_ptr<Tangent> tangent_;
};

// DampedKick (damping.h) with the damping of StrainDamping at the position of the kick: the kick by
// f - rest(q) v, where v is the mean velocity in the half step that results from that force itself.
//
// With the reach and path of DampedKick, F the total force and s = h/2,
//
//     F = f - rest(q) v,      s v = reach p + path F,
//
// that is (path + path rest(q) path/s) F = path (f - rest(q) reach p/s): symmetric, and positive
// because path beta Lambda/s < 1. Conjugate gradients preconditioned by `path` solve it.

class StrainKick {
 public:
  StrainKick() = default;
  // rates: D of all coordinates, same as for DampedKick.
  StrainKick(const Eigen::VectorXd& rates, double step)
      : kick_(rates, step), half_step_(0.5 * step) {
    for (Eigen::VectorXd* v : {&force_, &residual_, &direction_, &image_, &velocity_})
      v->setZero(rates.size());
  }

  // Kicks p at q by f, r each. Returns the energy that damping took, J. Nothing is allocated.
  double operator()(StrainDamping& strain, const Eigen::VectorXd& q, const Eigen::VectorXd& f,
                    Eigen::VectorXd& p);

 private:
  DampedKick kick_;
  double half_step_ = 0.0;
  Eigen::VectorXd force_, residual_, direction_, image_, velocity_;
};

// Rows of the midpoint rule with the damping of StrainDamping, whose position is given: they solve
//
//     (W + (h/2) rest(q)) d = b,       W diagonal, at least 1 + (h/2) beta Lambda,
//
// symmetric and positive, by conjugate gradients preconditioned by W.
class StrainMidpoint {
 public:
  StrainMidpoint() = default;
  // weights: W, r. step: h, s.
  StrainMidpoint(Eigen::VectorXd weights, double step) : weights_(std::move(weights)), h_(step) {
    for (Eigen::VectorXd* v : {&residual_, &scaled_, &direction_, &image_})
      v->setZero(weights_.size());
  }

  // d: a guess, then the solution to `tolerance` of b, r. Returns d . rest(q) d. Nothing is
  // allocated.
  double solve(StrainDamping& strain, const Eigen::VectorXd& q, const Eigen::VectorXd& b,
               double tolerance, Eigen::VectorXd& d);

 private:
  Eigen::VectorXd weights_;
  double h_ = 0.0;
  Eigen::VectorXd residual_, scaled_, direction_, image_;
};

struct StrainFlowScratch {
  Eigen::VectorXd term, next, path;  // r each
};

// The exact flow of p' = g - rest(q) p over the time s, which may be negative. Returns the energy
// that damping took, J. The series ends where its terms are below rounding.
double flow_with_strain_damping(StrainDamping& strain, const Eigen::VectorXd& q,
                                const Eigen::VectorXd& g, double s, Eigen::VectorXd& p,
                                StrainFlowScratch& scratch);

}  // namespace tremolo
