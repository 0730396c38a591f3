#include "runtime/kernels/potential.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <string>
#include <utility>

#include "common/packed_index.h"
#include "runtime/kernels/lanes.h"

#define TREMOLO_KERNEL "runtime/kernels/potential.inc"
#include "runtime/kernels/every_machine.inc"

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

// Below, the pair kernel's tangent is the faster one: it has no second stage.
constexpr Index kPairTangent = 20;
// From here on two forces in one pass over the unique coefficients cost less than the pair matrix.
constexpr Index kTwoForces = 22;

void copy(const VectorXd& q, AlignedDoubles& point) {
  std::copy(q.data(), q.data() + q.size(), point.begin());
}

}  // namespace

// Unique tensor entries, and the pair matrices once somebody wants them.
struct Potential::Coefficients {
  std::vector<double> cubic;
  std::vector<double> quartic;
  AlignedDoubles masks = lane_masks();
  mutable std::once_flag once;
  mutable PairKernel pairs;
};

Result<Potential> Potential::create(VectorXd lambda, std::span<const double> cubic,
                                    std::span<const double> quartic) {
  const auto r = static_cast<std::size_t>(lambda.size());
  if (r == 0) return content_error("the potential has no coordinates");
  if (Status status = check_finite({lambda.data(), r}, "lambda"); !status) return status.error();
  Potential potential;
  potential.lambda_ = std::move(lambda);
  if (cubic.empty() && quartic.empty()) return potential;
  if (cubic.size() < triple_count(r) || quartic.size() < quad_count(r))
    return content_error("the potential needs " + std::to_string(triple_count(r)) + " cubic and " +
                         std::to_string(quad_count(r)) +
                         " quartic coefficients for r = " + std::to_string(r) + ", found " +
                         std::to_string(cubic.size()) + " and " + std::to_string(quartic.size()));
  cubic = cubic.first(triple_count(r));
  quartic = quartic.first(quad_count(r));
  if (Status status = check_finite(cubic, "cubic"); !status) return status.error();
  if (Status status = check_finite(quartic, "quartic"); !status) return status.error();
  potential.unique_ = SymmetricKernel(r, cubic, quartic);
  auto kept = std::make_shared<Coefficients>();
  kept->cubic.assign(cubic.begin(), cubic.end());
  kept->quartic.assign(quartic.begin(), quartic.end());
  potential.coefficients_ = std::move(kept);
  return potential;
}

std::span<const double> Potential::cubic() const {
  return linear() ? std::span<const double>() : coefficients_->cubic;
}

std::span<const double> Potential::quartic() const {
  return linear() ? std::span<const double>() : coefficients_->quartic;
}

Potential Potential::leading(Index count) const {
  return count == 0 ? Potential() : *create(lambda_.head(count), cubic(), quartic());
}

const PairKernel& Potential::pair_kernel() const {
  std::call_once(coefficients_->once, [this] {
    coefficients_->pairs =
        PairKernel(static_cast<std::size_t>(size()), coefficients_->cubic, coefficients_->quartic);
  });
  return coefficients_->pairs;
}

PotentialWorkspace Potential::make_workspace(unsigned uses) const {
  PotentialWorkspace workspace;
  const auto r = static_cast<std::size_t>(size());
  if (linear()) return workspace;
  workspace.unique = unique_.make_workspace();
  if (!(uses & kUseSegment) && !((uses & kUseTangent) && size() < kPairTangent)) return workspace;
  workspace.pair_kernel = &pair_kernel();
  const std::size_t padded = lanes::padded(r);
  if ((uses & kUseSegment) && size() >= kTwoForces)
    workspace.unique_second = unique_.make_workspace();
  for (AlignedDoubles* vector : {&workspace.point, &workspace.second, &workspace.product})
    vector->assign(padded + lanes::kLanes, 0.0);
  // Whole groups of eight columns are read.
  const std::size_t pairs = lanes::padded(pair_count(padded)) + lanes::kLanes;
  for (AlignedDoubles* vector :
       {&workspace.pairs, &workspace.quartic, &workspace.cubic, &workspace.held_quartic,
        &workspace.held_cubic, &workspace.triangle})
    vector->assign(pairs, 0.0);
  return workspace;
}

Evaluation Potential::make_evaluation() const {
  return {0.0, VectorXd::Zero(size()), Eigen::MatrixXd::Zero(size(), size())};
}

void Potential::evaluate(const VectorXd& q, unsigned want, PotentialWorkspace& workspace,
                         Evaluation& out) const {
  if (linear()) return evaluate_linear(q, want, out);
  if ((want & kWantTangent) && workspace.pair_kernel != nullptr && size() < kPairTangent)
    return evaluate_pairs(q, want, workspace, out);
  double* force = want & kWantForce ? out.force.data() : workspace.unique.column.data();
  double value = 0.0;
  if (want & kWantTangent) {
    value = unique_.hessian(q.data(), workspace.unique, force, out.tangent.data());
    out.tangent.diagonal() += lambda_;
  } else {
    value = unique_.gradient(q.data(), workspace.unique, force);
  }
  if (want & kWantEnergy) out.energy = 0.5 * q.dot(lambda_.cwiseProduct(q)) + value;
  if (want & kWantForce) out.force += lambda_.cwiseProduct(q);
}

void Potential::evaluate_linear(const VectorXd& q, unsigned want, Evaluation& out) const {
  if (want & kWantEnergy) out.energy = 0.5 * q.dot(lambda_.cwiseProduct(q));
  if (want & kWantForce) out.force = lambda_.cwiseProduct(q);
  if (want & kWantTangent) {
    out.tangent.setZero();
    out.tangent.diagonal() = lambda_;
  }
}

void Potential::evaluate_pairs(const VectorXd& q, unsigned want, PotentialWorkspace& w,
                               Evaluation& out) const {
  const auto r = static_cast<std::size_t>(size());
  const std::size_t pairs = pair_count(r);
  const PairKernel& kernel = *w.pair_kernel;
  copy(q, w.point);
  kernel.fill_pairs(w.point.data(), w.pairs.data());
  std::fill_n(w.quartic.begin(), kernel.padded_pairs(), 0.0);
  std::fill_n(w.cubic.begin(), kernel.padded_pairs(), 0.0);
  kernel.multiply(w.pairs.data(), 0, w.quartic.data());
  kernel.contract_cubic(w.point.data(), 0, r, 0, w.cubic.data());
  if (want & (kWantForce | kWantEnergy)) {
    (*TREMOLO_BEST(combine))(3.0, w.cubic.data(), 4.0, w.quartic.data(), 0, pairs,
                             w.triangle.data());
    (*TREMOLO_BEST(multiply_packed))(w.triangle.data(), r, w.point.data(),
                                     coefficients_->masks.data(), w.product.data());
  }
  // V3 = q.(3B q)/3 and V4 = q.(4A q)/4.
  if (want & kWantEnergy) {
    const Eigen::Map<const VectorXd> x(w.pairs.data(), static_cast<Index>(pairs));
    const Eigen::Map<const VectorXd> a(w.quartic.data(), x.size()), b(w.cubic.data(), x.size());
    out.energy = 0.5 * q.dot(lambda_.cwiseProduct(q)) + x.dot(b) + x.dot(a);
  }
  if (want & kWantForce)
    out.force = lambda_.cwiseProduct(q) + Eigen::Map<const VectorXd>(w.product.data(), q.size());
  (*TREMOLO_BEST(fill_tangent))(w.cubic.data(), w.quartic.data(), lambda_.data(), 0, r,
                                out.tangent.data());
}

void Potential::begin_trailing(const VectorXd& q, Index held, PotentialWorkspace& w) const {
  if (linear()) return;
  const std::size_t first = pair_count(static_cast<std::size_t>(held));
  const PairKernel& kernel = *w.pair_kernel;
  copy(q, w.point);
  kernel.fill_pairs(w.point.data(), w.pairs.data());
  std::fill(w.pairs.begin() + static_cast<std::ptrdiff_t>(first), w.pairs.end(), 0.0);
  kernel.multiply_leading(w.pairs.data(), first, w.held_quartic.data());
  std::fill(w.held_cubic.begin(), w.held_cubic.end(), 0.0);
  kernel.contract_cubic(w.point.data(), 0, static_cast<std::size_t>(held), first,
                        w.held_cubic.data());
}

void Potential::evaluate_trailing(const VectorXd& q, Index held, unsigned want,
                                  PotentialWorkspace& w, Evaluation& out) const {
  if (linear()) return evaluate_linear(q, want & ~static_cast<unsigned>(kWantEnergy), out);
  const auto r = static_cast<std::size_t>(size());
  const std::size_t first = pair_count(static_cast<std::size_t>(held));
  const std::size_t from = first / lanes::kLanes * lanes::kLanes;
  const PairKernel& kernel = *w.pair_kernel;
  copy(q, w.point);
  kernel.fill_pairs(w.point.data(), w.pairs.data());
  std::fill(w.pairs.begin() + static_cast<std::ptrdiff_t>(from),
            w.pairs.begin() + static_cast<std::ptrdiff_t>(first), 0.0);
  std::copy_n(w.held_quartic.begin() + static_cast<std::ptrdiff_t>(from),
              kernel.padded_pairs() - from, w.quartic.begin() + static_cast<std::ptrdiff_t>(from));
  std::copy_n(w.held_cubic.begin() + static_cast<std::ptrdiff_t>(from),
              kernel.padded_pairs() - from, w.cubic.begin() + static_cast<std::ptrdiff_t>(from));
  kernel.multiply(w.pairs.data(), first, w.quartic.data());
  kernel.contract_cubic(w.point.data(), static_cast<std::size_t>(held), r, first, w.cubic.data());
  if (want & kWantForce) {
    const Index trailing = size() - held;
    (*TREMOLO_BEST(combine))(3.0, w.cubic.data(), 4.0, w.quartic.data(), first, pair_count(r),
                             w.triangle.data());
    (*TREMOLO_BEST(multiply_packed))(w.triangle.data(), r, w.point.data(),
                                     coefficients_->masks.data(), w.product.data());
    out.force.tail(trailing) = lambda_.tail(trailing).cwiseProduct(q.tail(trailing)) +
                               Eigen::Map<const VectorXd>(w.product.data() + held, trailing);
  }
  if (want & kWantTangent)
    (*TREMOLO_BEST(fill_tangent))(w.cubic.data(), w.quartic.data(), lambda_.data(),
                                  static_cast<std::size_t>(held), r, out.tangent.data());
}

void Potential::averaged_gradient(const VectorXd& q0, const VectorXd& q1, PotentialWorkspace& w,
                                  VectorXd& out, Eigen::MatrixXd* tangent) const {
  if (linear()) {
    out = 0.5 * lambda_.cwiseProduct(q0 + q1);
    if (tangent != nullptr) *tangent = lambda_.asDiagonal();
    return;
  }
  const auto r = static_cast<std::size_t>(size());
  const std::size_t pairs = pair_count(r);
  const PairKernel& kernel = *w.pair_kernel;
  Eigen::Map<VectorXd> mean(w.point.data(), size()), half(w.second.data(), size());
  Eigen::Map<VectorXd> product(w.product.data(), size());
  mean = 0.5 * (q0 + q1);
  half = 0.5 * (q1 - q0);
  if (tangent == nullptr && size() >= kTwoForces) {
    // Gauss's two points integrate a cubic exactly.
    const double node = 1.0 / std::sqrt(3.0);
    product = mean + node * half;
    half = mean - node * half;
    unique_.gradient_pair(product.data(), half.data(), w.unique, w.unique_second, out.data(),
                          w.triangle.data());
    out = lambda_.cwiseProduct(mean) +
          0.5 * (out + Eigen::Map<const VectorXd>(w.triangle.data(), size()));
    return;
  }
  // A of m m^T + d d^T, and B of m and of d.
  kernel.fill_pairs(mean.data(), half.data(), 1.0, w.pairs.data());
  std::fill_n(w.quartic.begin(), kernel.padded_pairs(), 0.0);
  kernel.multiply(w.pairs.data(), 0, w.quartic.data());
  kernel.contract_cubic_twice(mean.data(), half.data(), w.cubic.data(), w.held_cubic.data());
  (*TREMOLO_BEST(combine))(3.0, w.cubic.data(), 4.0, w.quartic.data(), 0, pairs, w.triangle.data());
  (*TREMOLO_BEST(multiply_packed))(w.triangle.data(), r, mean.data(), coefficients_->masks.data(),
                                   product.data());
  out = lambda_.cwiseProduct(mean) + product;
  if (tangent != nullptr)
    (*TREMOLO_BEST(fill_tangent))(w.cubic.data(), w.quartic.data(), lambda_.data(), 0, r,
                                  tangent->data());
  (*TREMOLO_BEST(multiply_packed))(w.held_cubic.data(), r, half.data(), coefficients_->masks.data(),
                                   product.data());
  out += product;
}

void Potential::averaged_jacobian(const VectorXd& q0, const VectorXd& q1, PotentialWorkspace& w,
                                  Eigen::MatrixXd& out) const {
  if (linear()) {
    out = (0.5 * lambda_).asDiagonal();
    return;
  }
  const auto r = static_cast<std::size_t>(size());
  const PairKernel& kernel = *w.pair_kernel;
  Eigen::Map<VectorXd> mean(w.point.data(), size()), half(w.second.data(), size());
  half = 0.5 * (q1 - q0);
  // Half of fill_tangent's Lambda + 6 C[m + d/3] + 12 Q[X], with
  // X = m m^T + d d^T/3 + (m d^T + d m^T)/3 = (m + d/3)(m + d/3)^T + 2/9 d d^T.
  mean = 0.5 * (q0 + q1) + half / 3.0;
  kernel.fill_pairs(mean.data(), half.data(), 2.0 / 9.0, w.pairs.data());
  std::fill_n(w.quartic.begin(), kernel.padded_pairs(), 0.0);
  std::fill_n(w.cubic.begin(), kernel.padded_pairs(), 0.0);
  kernel.multiply(w.pairs.data(), 0, w.quartic.data());
  kernel.contract_cubic(mean.data(), 0, r, 0, w.cubic.data());
  (*TREMOLO_BEST(fill_tangent))(w.cubic.data(), w.quartic.data(), lambda_.data(), 0, r, out.data());
  out *= 0.5;
}

}  // namespace tremolo
