#include "runtime/program/start/run_notes.h"

#include <cmath>
#include <string_view>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "runtime/scene/statics.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A load applied suddenly moves a body about twice as far as one that grows slowly.
constexpr double kOvershoot = 2.0;

// Methods with a fixed explicit part.
bool has_fixed_explicit_half(std::string_view method) {
  return method == "imexv" || method == "imexv-linear" || method == "imexv-coupled" ||
         method == "imexv-thesis";
}

// A clause about the stability of the explicit half at q; empty if it is stable there.
std::string unstable_place(const Body& body, const VectorXd& q, const char* where) {
  const double stiffness = explicit_stiffness(body, q);
  if (!(stiffness > 4.0)) return {};
  return fmt::format("{} its explicit half is stable up to a step of {:.3g} s", where,
                     body.step_size() * 2.0 / std::sqrt(stiffness));
}

std::string note_on_explicit_half(const Body& body, const VectorXd& load) {
  const std::string_view method = body.integrator().name();
  if (!has_fixed_explicit_half(method)) return {};
  std::string unstable = unstable_place(body, body.state().q, "where it begins");
  VectorXd force = load;
  if (const VectorXd gravity = body.gravity_force(); gravity.size() == force.size())
    force += gravity;
  if (unstable.empty() && !force.isZero(0.0)) {
    // If no equilibrium is found, the linear one is accurate enough.
    const Result<VectorXd> still = standing_shape(body.model().potential(), force);
    const VectorXd reached = still ? *still : VectorXd(force.cwiseQuotient(body.model().lambda()));
    unstable = unstable_place(body, reached, "where its loads hold it");
    if (unstable.empty())
      unstable = unstable_place(body, kOvershoot * reached, "where its loads swing it to");
  }
  if (unstable.empty()) return {};
  return fmt::format(
      "{} takes {} coordinates explicitly, and {}, not {:.3g} s: deformation has stiffened them. "
      "The run will probably break off; ep4 holds, imexv-adaptive too",
      method, body.integrator().split()->low, unstable, body.step_size());
}

}  // namespace

double explicit_stiffness(const Body& body, const VectorXd& q) {
  const Potential& potential = body.model().potential();
  const std::optional<Split> split = body.integrator().split();
  if (!split || potential.linear()) return 0.0;
  Evaluation at = potential.make_evaluation();
  PotentialWorkspace workspace = potential.make_workspace(kUseTangent);
  potential.evaluate(q, kWantTangent, workspace, at);
  if (!at.tangent.allFinite()) return 0.0;
  Index rows = split->low;
  if (body.integrator().name() == "imexv-linear") {
    at.tangent.diagonal().tail(split->high) -= potential.lambda().tail(split->high);
    rows = q.size();
  }
  if (rows == 0) return 0.0;
  const MatrixXd block = at.tangent.topLeftCorner(rows, rows);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(block, Eigen::EigenvaluesOnly);
  const double h = body.step_size();
  return h * h * std::max(0.0, eigen.eigenvalues().maxCoeff());
}

std::vector<std::string> notes_before(const Body& body, const VectorXd& load) {
  std::vector<std::string> notes;
  if (body.beta() > 0.0 && !body.model().potential().linear() && !body.model().has_strain_gram())
    notes.push_back(
        "the model has no Gram matrix of its strains (an imported model, or a file made before "
        "version 1.4): beta damps it by the positive part of its tangent stiffness; "
        "tremolo-precompute makes a file with the matrix");
  if (std::string note = note_on_explicit_half(body, load); !note.empty())
    notes.push_back(std::move(note));
  return notes;
}

}  // namespace tremolo
