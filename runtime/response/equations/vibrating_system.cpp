#include "runtime/response/equations/vibrating_system.h"

#include "runtime/bodies/reduced/integrators/solve/damping.h"

namespace tremolo {

StrainRateForce::StrainRateForce(const VibratingSystem& system) : beta_(system.beta) {
  if (!(beta_ > 0.0) || !system.strains) return;
  strains_ = system.strains.get();
  workspace_ = strains_->make_workspace();
  point_ = unit_ = ahead_ = behind_ = Eigen::VectorXd::Zero(system.size());
}

void StrainRateForce::force(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                            Eigen::VectorXd& out) {
  strains_->multiply(q.data(), v.data(), workspace_, out.data());
  out *= beta_;
}

void StrainRateForce::derivatives(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                  Eigen::MatrixXd& by_q, Eigen::MatrixXd& by_v) {
  const double largest = q.lpNorm<Eigen::Infinity>();
  const double step = largest > 0.0 ? largest : 1.0;
  unit_.setZero();
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    unit_[j] = 1.0;
    force(q, unit_, ahead_);
    by_v.col(j) = ahead_;
    unit_[j] = 0.0;
    point_ = q;
    point_[j] = q[j] + step;
    force(point_, v, ahead_);
    point_[j] = q[j] - step;
    force(point_, v, behind_);
    by_q.col(j) = (ahead_ - behind_) / (2.0 * step);
  }
}

Result<VibratingSystem> vibrating_system(const Model& model, double alpha, double beta,
                                         const Eigen::VectorXd& more) {
  VibratingSystem system{model.potential(), damping_rates(model.lambda(), alpha, beta), 0.0, {}};
  if (more.size() > 0) system.damping += more;
  if (!(beta > 0.0) || model.potential().linear()) return system;
  if (!model.has_strain_gram())
    return content_error(
        "the model has no strain matrix, so that stiffness damping is not known in large motion; "
        "use damping of the mass alone or a damping ratio of each mode, or make the model with "
        "tremolo-precompute");
  if (Status s = take(system.strains, model.strain_matrix()); !s) return s.error();
  system.beta = beta;
  return system;
}

}  // namespace tremolo
