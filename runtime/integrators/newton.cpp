#include "runtime/integrators/newton.h"

namespace tremolo {

NewtonWorkspace::NewtonWorkspace(Eigen::Index n)
    : unknowns(Eigen::VectorXd::Zero(n)),
      residual(Eigen::VectorXd::Zero(n)),
      jacobian(Eigen::MatrixXd::Identity(n, n)),
      correction(Eigen::VectorXd::Zero(n)),
      cholesky(n),
      lu(n) {
  if (n == 0) return;
  // A first factorisation makes whatever Eigen makes lazily.
  cholesky.compute(jacobian);
  lu.compute(jacobian);
}

void solve_correction(NewtonWorkspace& workspace) {
  workspace.correction = workspace.residual;
  workspace.cholesky.compute(workspace.jacobian);
  if (workspace.cholesky.info() == Eigen::Success) {
    workspace.cholesky.solveInPlace(workspace.correction);
    return;
  }
  workspace.lu.compute(workspace.jacobian);
  workspace.correction = workspace.lu.solve(workspace.residual);
}

}  // namespace tremolo
