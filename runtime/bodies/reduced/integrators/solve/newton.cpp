#include "runtime/bodies/reduced/integrators/solve/newton.h"

#include <algorithm>

namespace tremolo {

NewtonWorkspace::NewtonWorkspace(Eigen::Index n)
    : unknowns(Eigen::VectorXd::Zero(n)),
      residual(Eigen::VectorXd::Zero(n)),
      jacobian(Eigen::MatrixXd::Identity(n, n)),
      correction(Eigen::VectorXd::Zero(n)),
      jacobian_c(Eigen::VectorXd::Zero(n)),
      cholesky(n),
      start(Eigen::VectorXd::Zero(n)) {
  moves.fill(start);
}

bool factor_jacobian(NewtonWorkspace& workspace) {
  workspace.shift = 0.0;
  if (workspace.cholesky.compute(workspace.jacobian)) return true;
  if (!workspace.jacobian.allFinite()) return false;
  // Gershgorin's circles bound the spectrum from below.
  const Eigen::Index n = workspace.jacobian.rows();
  double deepest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double diagonal = workspace.jacobian(i, i);
    const double others = workspace.jacobian.col(i).cwiseAbs().sum() - std::abs(diagonal);
    deepest = std::max(deepest, others - diagonal);
  }
  for (double shift = 1e-3 * deepest; shift > 0.0; shift *= 4.0) {
    workspace.jacobian.diagonal().array() += shift - workspace.shift;
    workspace.shift = shift;
    if (workspace.cholesky.compute(workspace.jacobian)) return true;
    if (shift > 2.0 * deepest) break;
  }
  return false;
}

void solve_correction(NewtonWorkspace& workspace) {
  workspace.correction = workspace.residual;
  workspace.cholesky.solve(workspace.correction);
}

void apply_broyden(std::span<const Eigen::VectorXd> moves, Eigen::VectorXd& move) {
  for (std::size_t j = 0; j + 1 < moves.size(); ++j) {
    const Eigen::VectorXd& s = moves[j];
    move += (s.dot(move) / s.squaredNorm()) * moves[j + 1];
  }
  if (moves.empty()) return;
  const Eigen::VectorXd& last = moves.back();
  const double share = last.dot(move) / last.squaredNorm();
  if (share < 0.9) move /= 1.0 - share;
}

double first_zero(double end, double slope0, double bend0, double slope1, double bend1) {
  // Hermite's cubic in t/end.
  const double c1 = end * bend0;
  const double c2 = 3.0 * (slope1 - slope0) - end * (2.0 * bend0 + bend1);
  const double c3 = 2.0 * (slope0 - slope1) + end * (bend0 + bend1);
  const auto cubic = [&](double t) { return ((c3 * t + c2) * t + c1) * t + slope0; };
  constexpr int kPieces = 64;
  constexpr double kFarthest = 4.0;
  double below = 0.0;
  for (int i = 1; i <= kPieces; ++i) {
    double above = kFarthest * i / kPieces;
    if (cubic(above) < 0.0) {
      below = above;
      continue;
    }
    for (int k = 0; k < 40; ++k) {
      const double middle = 0.5 * (below + above);
      (cubic(middle) < 0.0 ? below : above) = middle;
    }
    return end * below;
  }
  return end * kFarthest;
}

}  // namespace tremolo
