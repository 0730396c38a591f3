#include "runtime/bodies/reduced/integrators/solve/strain_damping.h"

#include <algorithm>
#include <cmath>

namespace tremolo {

using Eigen::VectorXd;

StrainDamping::StrainDamping(const Model& model, double beta, double tolerance)
    : quick_(tolerance >= kQuickTolerance) {
  if (!(beta > 0.0) || model.potential().linear()) return;
  beta_ = beta;
  potential_ = &model.potential();
  strains_ = model.known_strain_matrix();
  if (strains_) {
    workspace_ = strains_->make_workspace();
    between_.setZero(model.modes());
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
    const double power =
        quick_ ? strains_->multiply_quickly(q.data(), v.data(), workspace_, out.data())
               : strains_->multiply(q.data(), v.data(), workspace_, out.data());
    out *= beta_;
    return beta_ * power;
  }
  out.noalias() = tangent_->rest * v;
  out *= beta_;
  return v.dot(out);
}

// With the strains' change y over the step, the work d . beta J^T G J d is beta y^T G y. The move
// changes y by e = J(q1 - move/2) move, and y^T G y by 2 S . e + e^T G e, S = G y; e^T G e is near
// move . K move. The part of Lambda, d^T Lambda d, is not of this work.
double StrainDamping::work_after(const VectorXd& move, const VectorXd& q1, const VectorXd& bent,
                                 double work, VectorXd& scratch) {
  between_ = q1 - 0.5 * move;
  strains_->multiply_stress(between_.data(), workspace_, scratch.data());
  const double square = move.dot(bent) - move.dot(potential_->lambda().cwiseProduct(move));
  return work + beta_ * (2.0 * scratch.dot(move) + square);
}

namespace {

constexpr int kMostProducts = 60;   // of one kick
constexpr double kSmall = 1e-14;    // of the force: limit of the residual
constexpr double kRounded = 1e-17;  // of the momenta: a term of the series that is lost

}  // namespace

double StrainKick::operator()(StrainDamping& strain, const VectorXd& q, const VectorXd& f,
                              VectorXd& p) {
  const VectorXd& path = kick_.path();
  strain.stand_at(q);
  velocity_ = kick_.reach().cwiseProduct(p) / half_step_;
  strain.force(q, velocity_, image_);
  force_ = f - image_;
  const double enough = kSmall * kSmall * force_.squaredNorm();
  // Of F the present guess; residual_: without the factor `path` before it, which is the
  // preconditioned one.
  velocity_ = path.cwiseProduct(force_) / half_step_;
  strain.force(q, velocity_, residual_);
  residual_ = -residual_;
  direction_ = residual_;
  double square = residual_.dot(path.cwiseProduct(residual_));
  for (int i = 0; i < kMostProducts && residual_.squaredNorm() > enough; ++i) {
    velocity_ = path.cwiseProduct(direction_) / half_step_;
    strain.force(q, velocity_, image_);
    image_ += direction_;
    const double length = square / direction_.dot(path.cwiseProduct(image_));
    if (!std::isfinite(length)) break;
    force_ += length * direction_;
    residual_ -= length * image_;
    const double next = residual_.dot(path.cwiseProduct(residual_));
    direction_ = residual_ + (next / square) * direction_;
    square = next;
  }
  const double reached = kick_.reach().dot(p.cwiseProduct(f - force_));
  const double forced = path.dot(force_.cwiseProduct(f - force_));
  return kick_(force_, p) + reached + forced;
}

double StrainMidpoint::solve(StrainDamping& strain, const VectorXd& q, const VectorXd& b,
                             double tolerance, VectorXd& d) {
  const auto multiply = [&](const VectorXd& x) {
    const double power = strain.force(q, x, image_);
    image_ = weights_.cwiseProduct(x) + (0.5 * h_) * image_;
    return power;
  };
  strain.stand_at(q);
  double power = multiply(d);
  residual_ = b - image_;
  scaled_ = residual_.cwiseQuotient(weights_);
  direction_ = scaled_;
  double square = residual_.dot(scaled_);
  const double enough = tolerance * b.norm();
  for (int i = 0; i < kMostProducts && residual_.norm() > enough; ++i) {
    multiply(direction_);
    const double length = square / direction_.dot(image_);
    if (!std::isfinite(length)) break;
    d += length * direction_;
    residual_ -= length * image_;
    scaled_ = residual_.cwiseQuotient(weights_);
    const double next = residual_.dot(scaled_);
    direction_ = scaled_ + (next / square) * direction_;
    square = next;
    power = NAN;
  }
  return std::isnan(power) ? strain.force(q, d, image_) : power;
}

double flow_with_strain_damping(StrainDamping& strain, const VectorXd& q, const VectorXd& g,
                                double s, VectorXd& p, StrainFlowScratch& scratch) {
  auto& [term, next, path] = scratch;
  const double before = p.squaredNorm();
  strain.force_at(q, p, next);
  term = s * (g - next);
  path = s * p;
  p += term;
  for (int k = 2; k < kMostProducts; ++k) {
    path += (s / k) * term;
    if (!(term.squaredNorm() > kRounded * kRounded * p.squaredNorm())) break;
    strain.force(q, term, next);
    term = (-s / k) * next;
    p += term;
  }
  return g.dot(path) - 0.5 * (p.squaredNorm() - before);
}

}  // namespace tremolo
