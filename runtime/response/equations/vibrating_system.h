// The equation whose periodic solutions are found:
//
//     q'' + D q' + beta M(q) q' + grad V(q) = f(t)
//
// in the model's coordinates. D is diagonal. M(q) is the part of damping by strain rates that
// vanishes at rest (runtime/math/kernels/strain_matrix.h).
#pragma once

#include <memory>

#include <Eigen/Core>

#include "common/result.h"
#include "runtime/math/kernels/potential.h"
#include "runtime/math/kernels/strain_matrix.h"
#include "runtime/model.h"

namespace tremolo {

struct VibratingSystem {
  Potential potential;
  Eigen::VectorXd damping;                      // the diagonal of D, r, 1/s
  double beta = 0.0;                            // of M(q), s
  std::shared_ptr<const StrainMatrix> strains;  // null: no M

  Eigen::Index size() const { return potential.size(); }  // r
  bool damped() const { return damping.maxCoeff() > 0.0; }
};

// The part beta M(q) v of the damping force and its derivatives at one state.
class StrainRateForce {
 public:
  explicit StrainRateForce(const VibratingSystem& system);

  bool none() const { return strains_ == nullptr; }
  // out = beta M(q) v, r.
  void force(const Eigen::VectorXd& q, const Eigen::VectorXd& v, Eigen::VectorXd& out);
  // by_v = beta M(q); by_q = beta d(M(q) v)/dq, both r x r. M is quadratic in q, so that central
  // differences are exact.
  void derivatives(const Eigen::VectorXd& q, const Eigen::VectorXd& v, Eigen::MatrixXd& by_q,
                   Eigen::MatrixXd& by_v);

 private:
  const StrainMatrix* strains_ = nullptr;
  double beta_ = 0.0;
  StrainMatrix::Workspace workspace_;
  Eigen::VectorXd point_, unit_, ahead_, behind_;
};

// The system of a model with Rayleigh damping alpha (1/s) and beta (s), the same as that of its
// bodies, and in addition the rates `more` (r, 1/s, or empty), as modal_rates() gives them. Errors:
// kContent if beta > 0 and the model is nonlinear and has no strain matrix; those of reading it.
Result<VibratingSystem> vibrating_system(const Model& model, double alpha, double beta,
                                         const Eigen::VectorXd& more = {});

}  // namespace tremolo
