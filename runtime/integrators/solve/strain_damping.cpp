#include "runtime/integrators/solve/strain_damping.h"

#include <algorithm>

namespace tremolo {

using Eigen::VectorXd;

StrainDamping::StrainDamping(const Model& model, double beta) {
  if (!(beta > 0.0) || model.potential().linear()) return;
  beta_ = beta;
  potential_ = &model.potential();
  strains_ = model.known_strain_matrix();
  if (strains_) {
    workspace_ = strains_->make_workspace();
    return;
  }
  const Eigen::Index r = model.modes();
  tangent_ = std::unique_ptr<Tangent>(new Tangent{
      potential_->make_workspace(kUseTangent),
      potential_->make_evaluation(),
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(r),
      SmallCholesky(r),
      Eigen::MatrixXd::Zero(r, r),
      Eigen::MatrixXd::Zero(r, r),
  });
}

void StrainDamping::stand_at(const VectorXd& q) {
  if (!tangent_) return;
  Tangent& t = *tangent_;
  potential_->evaluate(q, kWantTangent, t.workspace, t.evaluation);
  const Eigen::MatrixXd& K = t.evaluation.tangent;
  if (!K.allFinite()) {
    t.rest.setZero();  // the step itself finds the numbers
    return;
  }
  if (t.factor.compute(K)) {
    t.rest = K;
  } else {
    t.eigen.compute(K);
    t.product = t.eigen.eigenvectors();
    for (Eigen::Index i = 0; i < q.size(); ++i)
      t.product.col(i) *= std::max(t.eigen.eigenvalues()[i], 0.0);
    t.rest.noalias() = t.product * t.eigen.eigenvectors().transpose();
  }
  t.rest.diagonal() -= potential_->lambda();
}

double StrainDamping::force(const VectorXd& q, const VectorXd& v, VectorXd& out) {
  if (strains_) {
    const double power = strains_->multiply(q.data(), v.data(), workspace_, out.data());
    out *= beta_;
    return beta_ * power;
  }
  out.noalias() = tangent_->rest * v;
  out *= beta_;
  return v.dot(out);
}

}  // namespace tremolo
