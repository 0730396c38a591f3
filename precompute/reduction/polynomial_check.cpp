#include "precompute/reduction/polynomial_check.h"

#include <cmath>
#include <random>

#include "common/packed_index.h"
#include "precompute/ranks/halo.h"

namespace tremolo {

Eigen::VectorXd polynomial_force(const Eigen::VectorXd& lambda, const std::vector<double>& cubic,
                                 const std::vector<double>& quartic, const Eigen::VectorXd& q) {
  const auto r = static_cast<std::size_t>(lambda.size());
  Eigen::VectorXd force = lambda.cwiseProduct(q);
  // Derivative of one monomial c q_i q_j q_k (q_l), one factor at a time; repeated indices
  // accumulate.
  for (std::size_t k = 0; k < r; ++k)
    for (std::size_t j = 0; j <= k; ++j)
      for (std::size_t i = 0; i <= j; ++i) {
        const double c = cubic[triple_index(i, j, k)] * orderings(i, j, k);
        force[i] += c * q[j] * q[k];
        force[j] += c * q[i] * q[k];
        force[k] += c * q[i] * q[j];
        for (std::size_t l = k; l < r; ++l) {
          const double d = quartic[quad_index(i, j, k, l)] * orderings(i, j, k, l);
          force[i] += d * q[j] * q[k] * q[l];
          force[j] += d * q[i] * q[k] * q[l];
          force[k] += d * q[i] * q[j] * q[l];
          force[l] += d * q[i] * q[j] * q[k];
        }
      }
  return force;
}

double polynomial_error(const Solid& solid, std::size_t counted, const BasisRows& basis,
                        const Eigen::VectorXd& lambda, const std::vector<double>& cubic,
                        const std::vector<double>& quartic, double reach) {
  std::mt19937 engine(20110101);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::VectorXd q(lambda.size());
  // Softer coordinates are given larger values, as in a real motion.
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = uniform(engine) / std::sqrt(lambda[i]);
  Eigen::VectorXd u = basis * q;
  double largest = 0;
  for (Eigen::Index v = 0; v < u.size(); v += 3)
    largest = std::max(largest, u.segment<3>(v).norm());
  largest = over_ranks(largest, MPI_MAX);
  q *= reach / largest;
  u *= reach / largest;
  Eigen::MatrixXd expected = basis.transpose() * internal_force(solid, u, counted);
  sum_over_ranks(expected);
  return (expected - polynomial_force(lambda, cubic, quartic, q)).norm() / expected.norm();
}

}  // namespace tremolo
