#include "tests/lab/damping/stiff_orbit.h"

#include <array>
#include <cmath>
#include <string>

#include <Eigen/LU>

#include "common/packed_index.h"
#include "common/text.h"
#include "runtime/bodies/reduced/integrators/solve/damping.h"
#include "tests/lab/work/failure.h"

namespace tremolo::damping {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kStages = 3;
constexpr double kTolerance =
    1e-12;  // of the stages' accelerations, relative to the largest so far
constexpr int kMaxIterations = 30;

const double kRoot6 = std::sqrt(6.0);

// The stages' weights a_ij; the last row is that of the step itself.
Eigen::Matrix3d stage_weights() {
  const double s = kRoot6;
  Eigen::Matrix3d a;
  a << (88 - 7 * s) / 360, (296 - 169 * s) / 1800, (-2 + 3 * s) / 225,  //
      (296 + 169 * s) / 1800, (88 + 7 * s) / 360, (-2 - 3 * s) / 225,   //
      (16 - s) / 36, (16 + s) / 36, 1.0 / 9;
  return a;
}

// Unknown are the stages' accelerations k_i = f(t_i) - D(q_i) p_i - R(q_i), D summed from its
// definition alpha + beta J^T G J, with
// p_i = p0 + h sum a_ij k_j and q_i = q0 + c_i h p0 + h^2 sum (A^2)_ij k_j.
class Radau {
 public:
  explicit Radau(const StiffProblem& problem)
      : problem_(problem),
        potential_(problem.model->potential()),
        rates_(damping_rates(problem.model->lambda(), problem.alpha, problem.beta)),
        nodes_(a_.rowwise().sum()),
        workspace_(potential_.make_workspace(kUseTangent)),
        evaluation_(potential_.make_evaluation()),
        strains_(whole_matrix(problem.strain_gram, rates_.size())),
        load_(make_step_load(rates_.size())),
        q_(VectorXd::Zero(rates_.size())),
        p_(q_),
        k_(MatrixXd::Zero(rates_.size(), kStages)),
        residual_(k_),
        stage_load_(q_) {}

  // The strain terms of common/packed_index.h and their derivatives, which are linear in q.
  MatrixXd strain_derivative(const VectorXd& q) const {
    const auto r = static_cast<std::size_t>(q.size());
    MatrixXd J = MatrixXd::Zero(strains_.rows(), q.size());
    for (std::size_t j = 0; j < r; ++j) {
      const auto at = [](std::size_t i) { return static_cast<Index>(i); };
      J(at(strain_index(j)), at(j)) = 1.0;
      for (std::size_t i = 0; i <= j; ++i) {
        J(at(strain_index(i, j)), at(i)) += q[at(j)];
        J(at(strain_index(i, j)), at(j)) += q[at(i)];
      }
    }
    return J;
  }

  // D(q) v.
  VectorXd damping_force(const VectorXd& q, const VectorXd& v) const {
    if (strains_.size() == 0) return rates_.cwiseProduct(v);
    const MatrixXd J = strain_derivative(q);
    return problem_.alpha * v + problem_.beta * (J.transpose() * (strains_ * (J * v)));
  }

  bool step(double time) {
    sample_loads({problem_.load}, time, problem_.step, load_);
    if (!solve()) return false;
    q_ = position(kStages - 1);
    p_ = velocity(kStages - 1);
    return true;
  }
  const VectorXd& q() const { return q_; }

 private:
  static MatrixXd whole_matrix(const std::vector<double>& packed, Index modes) {
    if (packed.empty()) return {};
    const std::size_t terms = strain_terms(static_cast<std::size_t>(modes));
    MatrixXd whole(terms, terms);
    for (std::size_t b = 0; b < terms; ++b)
      for (std::size_t a = 0; a <= b; ++a)
        whole(static_cast<Index>(a), static_cast<Index>(b)) =
            whole(static_cast<Index>(b), static_cast<Index>(a)) = packed[pair_index(a, b)];
    return whole;
  }

  VectorXd position(Index i) const {
    const double h = problem_.step;
    return q_ + nodes_[i] * h * p_ + (h * h) * (k_ * a2_.row(i).transpose());
  }
  VectorXd velocity(Index i) const { return p_ + problem_.step * (k_ * a_.row(i).transpose()); }

  void factor() {
    const double h = problem_.step;
    const Index r = rates_.size();
    potential_.evaluate(q_, kWantForce | kWantTangent, workspace_, evaluation_);
    MatrixXd matrix = MatrixXd::Identity(kStages * r, kStages * r);
    MatrixXd damping = rates_.asDiagonal();
    if (strains_.size() > 0) {
      const MatrixXd J = strain_derivative(q_);
      damping = problem_.beta * (J.transpose() * (strains_ * J));
      damping.diagonal().array() += problem_.alpha;
    }
    for (Index i = 0; i < kStages; ++i)
      for (Index j = 0; j < kStages; ++j) {
        auto block = matrix.block(i * r, j * r, r, r);
        block += (h * h * a2_(i, j)) * evaluation_.tangent;
        block += (h * a_(i, j)) * damping;
      }
    lu_.compute(matrix);
  }

  bool solve() {
    factor();
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      for (Index i = 0; i < kStages; ++i) {
        potential_.evaluate(position(i), kWantForce, workspace_, evaluation_);
        load_at(load_, nodes_[i], stage_load_);
        residual_.col(i) =
            k_.col(i) - stage_load_ + damping_force(position(i), velocity(i)) + evaluation_.force;
      }
      const VectorXd correction = lu_.solve(residual_.reshaped());
      k_.reshaped() -= correction;
      largest_ = std::max(largest_, k_.norm());
      if (!std::isfinite(largest_)) return false;
      if (correction.norm() <= kTolerance * largest_) return true;
    }
    return false;
  }

  const StiffProblem& problem_;
  const Potential& potential_;
  VectorXd rates_;
  Eigen::Matrix3d a_ = stage_weights();
  Eigen::Matrix3d a2_ = a_ * a_;
  Eigen::Vector3d nodes_;
  PotentialWorkspace workspace_;
  Evaluation evaluation_;
  MatrixXd strains_;  // G, whole; empty where it is not known
  StepLoad load_;
  VectorXd q_;
  VectorXd p_;
  MatrixXd k_;
  MatrixXd residual_;
  VectorXd stage_load_;
  Eigen::PartialPivLU<MatrixXd> lu_;
  double largest_ = 0.0;
};

}  // namespace

MatrixXd stiff_orbit(const StiffProblem& problem) {
  const Index samples = std::llround(problem.duration / problem.sample);
  const Index steps = std::llround(problem.sample / problem.step);
  Radau radau(problem);
  MatrixXd q(problem.model->modes(), samples);
  for (Index k = 0; k < samples; ++k) {
    for (Index i = 0; i < steps; ++i) {
      const double time = static_cast<double>(k * steps + i) * problem.step;
      if (!radau.step(time))
        throw Failure({ErrorKind::kSolver,
                       "Radau's stages could not be solved at " + number_text(time) + " s"});
    }
    q.col(k) = radau.q();
  }
  return q;
}

}  // namespace tremolo::damping
