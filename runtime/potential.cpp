#include "runtime/potential.h"

#include <cmath>
#include <string>
#include <utility>

#include "common/packed_index.h"
#include "runtime/contraction.h"

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

Status check_finite(std::span<const double> values, const char* name) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      return content_error(std::string(name) + " coefficient " + std::to_string(i) +
                           " is not finite");
  return Success{};
}

std::vector<double> cubic_by_rows(std::span<const double> cubic, std::size_t r) {
  const std::size_t pairs = pair_count(r);
  std::vector<double> rows(r * pairs);
  for (std::size_t k = 0; k < r; ++k)
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t i = 0; i <= j; ++i)
        rows[k * pairs + pair_index(i, j)] = cubic[triple_index_any(i, j, k)];
  return rows;
}

std::vector<double> quartic_by_pairs(std::span<const double> quartic, std::size_t r) {
  const std::size_t pairs = pair_count(r);
  std::vector<double> packed;
  packed.reserve(pair_count(pairs));
  for (std::size_t l = 0; l < r; ++l)
    for (std::size_t k = 0; k <= l; ++k)
      // Rows a <= b = (k, l) in pair_index order: every pair below l, then (0..k, l).
      for (std::size_t j = 0; j <= l; ++j)
        for (std::size_t i = 0; i <= (j < l ? j : k); ++i)
          packed.push_back(quartic[quad_index_any(i, j, k, l)]);
  return packed;
}

// X_a from q for the pairs whose larger index is in [first, r).
void fill_pairs(const VectorXd& q, Index first, VectorXd& pairs) {
  double* x = pairs.data() + pair_count(static_cast<std::size_t>(first));
  for (Index j = first; j < q.size(); ++j) {
    const double twice = 2.0 * q[j];
    for (Index i = 0; i < j; ++i) *x++ = twice * q[i];
    *x++ = q[j] * q[j];
  }
}

// out_i += sum_j (b B + a A)_ij q_j for i in [first, r), where the pairs at and above `first` hold
// A and B.
void add_pair_product(const VectorXd& cubic, const VectorXd& quartic, double b, double a,
                      const VectorXd& q, Index first, VectorXd& out) {
  Index at = static_cast<Index>(pair_count(static_cast<std::size_t>(first)));
  for (Index j = first; j < q.size(); ++j) {
    double sum = 0.0;
    for (Index i = 0; i < first; ++i, ++at) sum += (b * cubic[at] + a * quartic[at]) * q[i];
    for (Index i = first; i < j; ++i, ++at) {
      const double value = b * cubic[at] + a * quartic[at];
      sum += value * q[i];
      out[i] += value * q[j];
    }
    out[j] += sum + (b * cubic[at] + a * quartic[at]) * q[j];
    ++at;
  }
}

// The block [first, r) of K = Lambda + 6B + 12A.
void fill_tangent(const VectorXd& lambda, const PotentialWorkspace& workspace, Index first,
                  Eigen::MatrixXd& tangent) {
  const double* cubic = workspace.cubic.data();
  const double* quartic = workspace.quartic.data();
  for (Index j = first; j < lambda.size(); ++j) {
    const Index column = static_cast<Index>(pair_count(static_cast<std::size_t>(j)));
    for (Index i = first; i <= j; ++i) {
      const double value = 6.0 * cubic[column + i] + 12.0 * quartic[column + i];
      tangent(i, j) = value;
      tangent(j, i) = value;
    }
    tangent(j, j) += lambda[j];
  }
}

}  // namespace

Result<Potential> Potential::create(VectorXd lambda, std::span<const double> cubic,
                                    std::span<const double> quartic) {
  const auto r = static_cast<std::size_t>(lambda.size());
  if (r == 0) return content_error("the potential has no coordinates");
  if (cubic.size() < triple_count(r) || quartic.size() < quad_count(r))
    return content_error("the potential needs " + std::to_string(triple_count(r)) + " cubic and " +
                         std::to_string(quad_count(r)) +
                         " quartic coefficients for r = " + std::to_string(r) + ", found " +
                         std::to_string(cubic.size()) + " and " + std::to_string(quartic.size()));
  cubic = cubic.first(triple_count(r));
  quartic = quartic.first(quad_count(r));
  if (Status status = check_finite({lambda.data(), r}, "lambda"); !status) return status.error();
  if (Status status = check_finite(cubic, "cubic"); !status) return status.error();
  if (Status status = check_finite(quartic, "quartic"); !status) return status.error();
  Potential potential;
  potential.lambda_ = std::move(lambda);
  potential.cubic_rows_ = cubic_by_rows(cubic, r);
  potential.quartic_pairs_ = quartic_by_pairs(quartic, r);
  return potential;
}

Potential Potential::leading(Index count) const {
  const std::size_t pairs = pair_count(static_cast<std::size_t>(lambda_.size()));
  const std::size_t kept = pair_count(static_cast<std::size_t>(count));
  Potential part;
  part.lambda_ = lambda_.head(count);
  part.cubic_rows_.reserve(static_cast<std::size_t>(count) * kept);
  for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
    const double* row = cubic_rows_.data() + k * pairs;
    part.cubic_rows_.insert(part.cubic_rows_.end(), row, row + kept);
  }
  const double* quartic = quartic_pairs_.data();
  part.quartic_pairs_.assign(quartic, quartic + pair_count(kept));
  return part;
}

PotentialWorkspace Potential::make_workspace() const {
  const VectorXd pairs = VectorXd::Zero(static_cast<Index>(pair_count(lambda_.size())));
  const VectorXd coordinates = VectorXd::Zero(size());
  return {pairs, pairs, pairs, pairs, pairs, coordinates, coordinates};
}

Evaluation Potential::make_evaluation() const {
  return {0.0, VectorXd::Zero(size()), Eigen::MatrixXd::Zero(size(), size())};
}

void Potential::evaluate(const VectorXd& q, unsigned want, PotentialWorkspace& workspace,
                         Evaluation& out) const {
  const std::size_t r = lambda_.size();
  const std::size_t pairs = pair_count(r);
  fill_pairs(q, 0, workspace.pairs);
  workspace.quartic.setZero();
  workspace.cubic.setZero();
  multiply_symmetric_block(quartic_pairs_.data(), 0, pairs, workspace.pairs.data(),
                           workspace.quartic.data());
  add_scaled_rows(cubic_rows_.data(), pairs, 0, pairs, 0, r, q.data(), workspace.cubic.data());
  if (want & kWantEnergy)
    out.energy = 0.5 * q.dot(lambda_.cwiseProduct(q)) + workspace.pairs.dot(workspace.cubic) +
                 workspace.pairs.dot(workspace.quartic);
  if (want & kWantForce) {
    out.force = lambda_.cwiseProduct(q);
    add_pair_product(workspace.cubic, workspace.quartic, 3.0, 4.0, q, 0, out.force);
  }
  if (want & kWantTangent) fill_tangent(lambda_, workspace, 0, out.tangent);
}

void Potential::begin_trailing(const VectorXd& q, Index held, PotentialWorkspace& workspace) const {
  const std::size_t first = pair_count(static_cast<std::size_t>(held));
  const std::size_t pairs = pair_count(lambda_.size());
  fill_pairs(q, 0, workspace.pairs);
  workspace.held_quartic.setZero();
  workspace.held_cubic.setZero();
  multiply_leading_columns(quartic_pairs_.data(), first, pairs, workspace.pairs.data(),
                           workspace.held_quartic.data());
  add_scaled_rows(cubic_rows_.data(), pairs, first, pairs, 0, static_cast<std::size_t>(held),
                  q.data(), workspace.held_cubic.data());
}

void Potential::evaluate_trailing(const VectorXd& q, Index held, unsigned want,
                                  PotentialWorkspace& workspace, Evaluation& out) const {
  const std::size_t r = lambda_.size();
  const std::size_t first = pair_count(static_cast<std::size_t>(held));
  const std::size_t pairs = pair_count(r);
  fill_pairs(q, held, workspace.pairs);
  const auto count = static_cast<Index>(pairs - first);
  workspace.quartic.tail(count) = workspace.held_quartic.tail(count);
  workspace.cubic.tail(count) = workspace.held_cubic.tail(count);
  multiply_symmetric_block(quartic_pairs_.data(), first, pairs, workspace.pairs.data(),
                           workspace.quartic.data());
  add_scaled_rows(cubic_rows_.data(), pairs, first, pairs, static_cast<std::size_t>(held), r,
                  q.data(), workspace.cubic.data());
  if (want & kWantForce) {
    const Index trailing = size() - held;
    out.force.tail(trailing) = lambda_.tail(trailing).cwiseProduct(q.tail(trailing));
    add_pair_product(workspace.cubic, workspace.quartic, 3.0, 4.0, q, held, out.force);
  }
  if (want & kWantTangent) fill_tangent(lambda_, workspace, held, out.tangent);
}

void Potential::averaged_gradient(const VectorXd& q0, const VectorXd& q1,
                                  PotentialWorkspace& workspace, VectorXd& out,
                                  Eigen::MatrixXd* tangent) const {
  const std::size_t r = lambda_.size();
  const std::size_t pairs = pair_count(r);
  workspace.mean = 0.5 * (q0 + q1);
  workspace.half = 0.5 * (q1 - q0);
  // A of m m^T + d d^T, and B of m; held_* serve as a second scratch here.
  fill_pairs(workspace.mean, 0, workspace.pairs);
  fill_pairs(workspace.half, 0, workspace.held_quartic);
  workspace.pairs += workspace.held_quartic;
  workspace.quartic.setZero();
  workspace.cubic.setZero();
  multiply_symmetric_block(quartic_pairs_.data(), 0, pairs, workspace.pairs.data(),
                           workspace.quartic.data());
  add_scaled_rows(cubic_rows_.data(), pairs, 0, pairs, 0, r, workspace.mean.data(),
                  workspace.cubic.data());
  out = lambda_.cwiseProduct(workspace.mean);
  add_pair_product(workspace.cubic, workspace.quartic, 3.0, 4.0, workspace.mean, 0, out);
  if (tangent != nullptr) fill_tangent(lambda_, workspace, 0, *tangent);
  workspace.held_cubic.setZero();
  add_scaled_rows(cubic_rows_.data(), pairs, 0, pairs, 0, r, workspace.half.data(),
                  workspace.held_cubic.data());
  add_pair_product(workspace.held_cubic, workspace.quartic, 1.0, 0.0, workspace.half, 0, out);
}

void Potential::averaged_jacobian(const VectorXd& q0, const VectorXd& q1,
                                  PotentialWorkspace& workspace, Eigen::MatrixXd& out) const {
  const std::size_t r = lambda_.size();
  const std::size_t pairs = pair_count(r);
  workspace.mean = 0.5 * (q0 + q1);
  workspace.half = 0.5 * (q1 - q0);
  // Half of fill_tangent's Lambda + 6 C[m + d/3] + 12 Q[X], with
  // X = m m^T + d d^T/3 + (m d^T + d m^T)/3 = (m + d/3)(m + d/3)^T + 2/9 d d^T.
  workspace.mean += workspace.half / 3.0;
  fill_pairs(workspace.mean, 0, workspace.pairs);
  fill_pairs(workspace.half, 0, workspace.held_quartic);
  workspace.pairs += (2.0 / 9.0) * workspace.held_quartic;
  workspace.quartic.setZero();
  workspace.cubic.setZero();
  multiply_symmetric_block(quartic_pairs_.data(), 0, pairs, workspace.pairs.data(),
                           workspace.quartic.data());
  add_scaled_rows(cubic_rows_.data(), pairs, 0, pairs, 0, r, workspace.mean.data(),
                  workspace.cubic.data());
  fill_tangent(lambda_, workspace, 0, out);
  out *= 0.5;
}

}  // namespace tremolo
