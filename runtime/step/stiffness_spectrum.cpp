// The largest eigenvalue of M^-1/2 K M^-1/2 by Lanczos's recurrence with full orthogonalisation
// (Lanczos 1950): the largest of the tridiagonal matrix of k steps, from below.
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "runtime/step/nodal_integrator.h"

namespace tremolo {
namespace {

constexpr int kMostLanczos = 300;

// Pseudo-random numbers between -1 and 1 that are the same in every run.
Eigen::VectorXd scattered_vector(Eigen::Index size) {
  Eigen::VectorXd x(size);
  std::uint64_t state = 0x9e3779b97f4a7c15u;
  for (Eigen::Index i = 0; i < size; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    x[i] = static_cast<double>(state >> 11) * 0x1p-52 - 1.0;
  }
  return x;
}

}  // namespace

double largest_eigenvalue(const NodalSystem& system, const Eigen::VectorXd& x, ForcePart part,
                          double relative) {
  const Eigen::Index n = x.size();
  BlockMatrix stiffness(system.pattern());
  stiffness.set_zero();
  system.add_tangent(x, Eigen::VectorXd::Zero(n), part, 1.0, 0.0, 0.0, stiffness);
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(n);  // 0: fixed
  for (Eigen::Index i = 0; i < system.mass().size(); ++i)
    if (system.held()[i] == 0)
      scale.segment<3>(3 * i).setConstant(1.0 / std::sqrt(system.mass()[i]));
  std::vector<Eigen::VectorXd> basis;
  Eigen::VectorXd q = (scale.array() > 0.0).select(scattered_vector(n), 0.0), w(n), y(n);
  if (q.isZero(0.0)) return 0.0;
  q.normalize();
  std::vector<double> diagonal, off;
  double largest = 0.0;
  for (int k = 0; k < kMostLanczos; ++k) {
    basis.push_back(q);
    y = q.cwiseProduct(scale);
    stiffness.multiply(y, w);
    w = w.cwiseProduct(scale);
    diagonal.push_back(q.dot(w));
    for (int twice = 0; twice < 2; ++twice)
      for (const Eigen::VectorXd& old : basis) w -= old.dot(w) * old;
    const Eigen::Index size = diagonal.size();
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> small;
    small.computeFromTridiagonal(Eigen::Map<Eigen::VectorXd>(diagonal.data(), size),
                                 Eigen::Map<Eigen::VectorXd>(off.data(), size - 1));
    largest = small.eigenvalues().maxCoeff();
    const double next = w.norm();
    // The residual of the largest pair. It bounds the error of the value, which is far smaller once
    // the residual is small.
    const double residual = next * std::abs(small.eigenvectors()(size - 1, size - 1));
    if (residual <= relative * largest || next <= 1e-14 * largest) break;
    off.push_back(next);
    q = w / next;
  }
  return largest;
}

}  // namespace tremolo
