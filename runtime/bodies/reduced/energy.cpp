#include "runtime/energy.h"

namespace tremolo {

double kinetic_energy(const Eigen::VectorXd& p) {
  return 0.5 * p.squaredNorm();
}

double band_energy(const Eigen::VectorXd& lambda, const Eigen::VectorXd& force,
                   const Eigen::VectorXd& p, Eigen::Index low) {
  const Eigen::Index high = lambda.size() - low;
  return 0.5 * (p.tail(high).squaredNorm() +
                (force.tail(high).array().square() / lambda.tail(high).array()).sum());
}

}  // namespace tremolo
