#include "precompute/reduction/polynomial_check.h"

#include <cmath>
#include <random>

#include "common/energy.h"
#include "precompute/ranks/halo.h"

namespace tremolo {

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
  return (expected - reduced_energy(lambda, cubic, quartic, q).force).norm() / expected.norm();
}

}  // namespace tremolo
