#include "runtime/apps/tremolo/start/run_notes.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <Eigen/Core>
#include <fmt/format.h>

#include "runtime/math/dense/decompositions.h"
#include "runtime/scene/scene_start.h"

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
                     body.options().step * 2.0 / std::sqrt(stiffness));
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
      method, body.integrator().split()->low, unstable, body.options().step);
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
  const double h = body.options().step;
  return h * h * std::max(0.0, symmetric_eigenvalues(block).maxCoeff());
}

std::vector<std::string> notes_before(const Body& body, const VectorXd& load) {
  std::vector<std::string> notes;
  if (body.options().beta > 0.0 && !body.model().potential().linear() &&
      !body.model().has_strain_gram())
    notes.push_back(
        "the model has no Gram matrix of its strains (an imported model, or a file made before "
        "version 1.4): beta damps it by the positive part of its tangent stiffness; "
        "tremolo-precompute makes a file with the matrix");
  if (std::string note = note_on_explicit_half(body, load); !note.empty())
    notes.push_back(std::move(note));
  return notes;
}

namespace {

constexpr int kAttempts = 30;
constexpr double kNear = 0.01;  // relative, of the amplitude

double four_digits(double value) {
  return std::stod(fmt::format("{:.4g}", value));
}

// Secant steps on logarithms, kept inside the bracket once there is one.
class Search {
 public:
  explicit Search(double wanted) : wanted_(wanted) {}

  void take(const LoadAttempt& attempt) {
    LoadAttempt& side = attempt.amplitude < wanted_ ? low_ : high_;
    side = attempt;
  }

  double next(const LoadAttempt& last) const {
    if (high_.scale == 0.0) return last.scale * std::clamp(wanted_ / last.amplitude, 1.05, 10.0);
    if (low_.scale == 0.0)
      return std::isfinite(last.amplitude)
                 ? last.scale * std::clamp(wanted_ / last.amplitude, 0.1, 0.95)
                 : 0.1 * last.scale;
    const double width = std::log(high_.scale / low_.scale);
    const double slope = std::log(high_.amplitude / low_.amplitude);
    const double part = std::isfinite(slope) ? std::log(wanted_ / low_.amplitude) / slope : 0.5;
    return low_.scale * std::exp(width * std::clamp(part, 0.1, 0.9));
  }

  bool closed() const {
    return low_.scale > 0.0 && high_.scale > 0.0 && high_.scale < 1.002 * low_.scale;
  }

  std::string trouble() const {
    if (!high_.reason.empty())
      return fmt::format("with {:.4g} times the load, at {:.3g} of the size: {}", low_.scale,
                         low_.amplitude, "the next larger one breaks off: " + high_.reason);
    return fmt::format(
        "the displacement jumps from {:.3g} to {:.3g} of the size near {:.4g} times "
        "the load",
        low_.amplitude, high_.amplitude, high_.scale);
  }

 private:
  double wanted_;
  LoadAttempt low_, high_;
};

}  // namespace

Result<LoadScale> search_load_scale(double wanted,
                                    const std::function<Result<LoadAttempt>(double)>& attempt) {
  Search search(wanted);
  double scale = 1e-2;
  for (int i = 0; i < kAttempts && !search.closed(); ++i) {
    const Result<LoadAttempt> result = attempt(four_digits(scale));
    if (!result) return result.error();
    if (!(result->amplitude > 0.0)) return LoadScale{0.0, "the load does not move it"};
    if (std::abs(result->amplitude / wanted - 1.0) <= kNear) return LoadScale{result->scale, ""};
    search.take(*result);
    scale = search.next(*result);
  }
  return LoadScale{0.0, search.trouble()};
}

}  // namespace tremolo
