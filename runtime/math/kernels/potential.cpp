#include "runtime/math/kernels/potential.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <string>
#include <utility>

#include "common/packed_index.h"
#include "runtime/math/kernels/lanes.h"

namespace tremolo {
namespace {

// A and B of potential.h, in the order of pair_index.
struct PairSums {
  const double* a;
  const double* b;
};

}  // namespace
}  // namespace tremolo

#define TREMOLO_KERNEL "runtime/math/kernels/potential.inc"
#include "runtime/math/kernels/every_instruction_set.inc"

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

// Below this r the pair kernel's tangent is the faster one: it has no second stage.
constexpr Index kPairTangent = 20;
// From this r on two forces in one pass over the unique coefficients cost less than the pair
// matrix.
constexpr Index kTwoForces = 22;

void copy(const VectorXd& q, AlignedDoubles& point) {
  std::copy(q.data(), q.data() + q.size(), point.begin());
}

}  // namespace

// Unique tensor entries, and the pair matrices from their first use on.
struct Potential::Coefficients {
  std::vector<double> cubic;
  std::vector<double> quartic;
  mutable std::once_flag once;
  mutable PairKernel pairs;
};

Result<Potential> Potential::create(VectorXd lambda, std::span<const double> cubic,
                                    std::span<const double> quartic) {
  const std::size_t r = lambda.size();
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
  const std::size_t r = size();
  if (linear()) return workspace;
  workspace.unique = unique_.make_workspace();
  if (!(uses & kUseSegment) && !((uses & kUseTangent) && size() < kPairTangent)) return workspace;
  workspace.pair_kernel = &pair_kernel();
  const std::size_t length = padded(r);
  if ((uses & kUseSegment) && size() >= kTwoForces)
    workspace.unique_second = unique_.make_workspace();
  for (AlignedDoubles* vector : {&workspace.q, &workspace.second, &workspace.product})
    vector->assign(length + kVectorLanes, 0.0);
  // Whole groups of eight columns are read.
  const std::size_t pairs = padded(pair_count(length)) + kVectorLanes;
  for (AlignedDoubles* vector : {&workspace.x, &workspace.a, &workspace.b, &workspace.held_a,
                                 &workspace.held_b, &workspace.triangle})
    vector->assign(pairs, 0.0);
  return workspace;
}

Evaluation Potential::make_evaluation() const {
  return {0.0, VectorXd::Zero(size()), Eigen::MatrixXd::Zero(size(), size())};
}

void Potential::evaluate(const VectorXd& q, unsigned want, PotentialWorkspace& workspace,
                         Evaluation& out) const {
  if (linear()) return evaluate_linear(q, want, out);
  if (want == kWantEnergy) {
    out.energy = 0.5 * q.dot(lambda_.cwiseProduct(q)) + unique_.value(q.data(), workspace.unique);
    return;
  }
  if ((want & kWantTangent) && workspace.pair_kernel != nullptr && size() < kPairTangent)
    return evaluate_pairs(q, want, workspace, out);
  double* force = want & kWantForce ? out.force.data() : workspace.unique.y.data();
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

// A of the pairs in w.x.
void Potential::set_a(PotentialWorkspace& w) const {
  std::fill_n(w.a.begin(), w.pair_kernel->padded_pairs(), 0.0);
  w.pair_kernel->multiply(w.x.data(), 0, w.a.data());
}

// A of the pairs in w.x and B of w.q.
void Potential::set_a_and_b(PotentialWorkspace& w) const {
  set_a(w);
  std::fill_n(w.b.begin(), w.pair_kernel->padded_pairs(), 0.0);
  w.pair_kernel->contract_cubic(w.q.data(), 0, static_cast<std::size_t>(size()), 0, w.b.data());
}

// w.product = (3B + 4A) w.q, A and B taken from the pair `first` on.
void Potential::multiply_force_matrix(std::size_t first, PotentialWorkspace& w) const {
  const std::size_t r = size();
  TREMOLO_CALL(combine, {w.a.data(), w.b.data()}, first, pair_count(r), w.triangle.data());
  TREMOLO_CALL(multiply_packed, w.triangle.data(), r, w.q.data(), w.product.data());
}

// The block [held, r) of Lambda + 6B + 12A.
void Potential::set_tangent(const PotentialWorkspace& w, Index held, Eigen::MatrixXd& out) const {
  TREMOLO_CALL(set_tangent_block, {w.a.data(), w.b.data()}, lambda_.data(),
               static_cast<std::size_t>(held), static_cast<std::size_t>(size()), out.data());
}

void Potential::evaluate_pairs(const VectorXd& q, unsigned want, PotentialWorkspace& w,
                               Evaluation& out) const {
  copy(q, w.q);
  w.pair_kernel->fill_pairs(w.q.data(), w.x.data());
  set_a_and_b(w);
  if (want & (kWantForce | kWantEnergy)) multiply_force_matrix(0, w);
  // V3 = q.(3B q)/3 and V4 = q.(4A q)/4.
  if (want & kWantEnergy) {
    const Index pairs = pair_count(static_cast<std::size_t>(size()));
    const Eigen::Map<const VectorXd> x(w.x.data(), pairs), a(w.a.data(), pairs),
        b(w.b.data(), pairs);
    out.energy = 0.5 * q.dot(lambda_.cwiseProduct(q)) + x.dot(b) + x.dot(a);
  }
  if (want & kWantForce)
    out.force = lambda_.cwiseProduct(q) + Eigen::Map<const VectorXd>(w.product.data(), q.size());
  set_tangent(w, 0, out.tangent);
}

void Potential::begin_trailing(const VectorXd& q, Index held, PotentialWorkspace& w) const {
  if (linear()) return;
  const std::size_t first = pair_count(static_cast<std::size_t>(held));
  const PairKernel& kernel = *w.pair_kernel;
  copy(q, w.q);
  kernel.fill_pairs(w.q.data(), w.x.data());
  std::fill(w.x.begin() + static_cast<std::ptrdiff_t>(first), w.x.end(), 0.0);
  kernel.multiply_leading(w.x.data(), first, w.held_a.data());
  std::fill(w.held_b.begin(), w.held_b.end(), 0.0);
  kernel.contract_cubic(w.q.data(), 0, static_cast<std::size_t>(held), first, w.held_b.data());
}

void Potential::evaluate_trailing(const VectorXd& q, Index held, unsigned want,
                                  PotentialWorkspace& w, Evaluation& out) const {
  if (linear()) return evaluate_linear(q, want & ~static_cast<unsigned>(kWantEnergy), out);
  const std::size_t r = size();
  const std::size_t first = pair_count(static_cast<std::size_t>(held));
  const std::size_t from = first / kVectorLanes * kVectorLanes;
  const PairKernel& kernel = *w.pair_kernel;
  const std::size_t count = kernel.padded_pairs() - from;
  copy(q, w.q);
  kernel.fill_pairs(w.q.data(), w.x.data());
  std::fill_n(w.x.data() + from, first - from, 0.0);
  std::copy_n(w.held_a.data() + from, count, w.a.data() + from);
  std::copy_n(w.held_b.data() + from, count, w.b.data() + from);
  kernel.multiply(w.x.data(), first, w.a.data());
  kernel.contract_cubic(w.q.data(), static_cast<std::size_t>(held), r, first, w.b.data());
  if (want & kWantForce) {
    const Index trailing = size() - held;
    multiply_force_matrix(first, w);
    out.force.tail(trailing) = lambda_.tail(trailing).cwiseProduct(q.tail(trailing)) +
                               Eigen::Map<const VectorXd>(w.product.data() + held, trailing);
  }
  if (want & kWantTangent) set_tangent(w, held, out.tangent);
}

void Potential::averaged_gradient(const VectorXd& q0, const VectorXd& q1, PotentialWorkspace& w,
                                  VectorXd& out, Eigen::MatrixXd* tangent) const {
  if (linear()) {
    out = 0.5 * lambda_.cwiseProduct(q0 + q1);
    if (tangent != nullptr) *tangent = lambda_.asDiagonal();
    return;
  }
  Eigen::Map<VectorXd> m(w.q.data(), size()), d(w.second.data(), size());
  Eigen::Map<VectorXd> product(w.product.data(), size());
  m = 0.5 * (q0 + q1);
  d = 0.5 * (q1 - q0);
  if (tangent == nullptr && size() >= kTwoForces) {
    // Gauss's two points integrate a cubic exactly.
    const double node = 1.0 / std::sqrt(3.0);
    product = m + node * d;
    d = m - node * d;
    unique_.gradient_pair(product.data(), d.data(), w.unique, w.unique_second, out.data(),
                          w.triangle.data());
    out = lambda_.cwiseProduct(m) +
          0.5 * (out + Eigen::Map<const VectorXd>(w.triangle.data(), size()));
    return;
  }
  // A of m m^T + d d^T, B of m in w.b and of d in w.held_b.
  w.pair_kernel->fill_pairs(m.data(), d.data(), 1.0, w.x.data());
  set_a(w);
  w.pair_kernel->contract_cubic_twice(m.data(), d.data(), w.b.data(), w.held_b.data());
  multiply_force_matrix(0, w);
  out = lambda_.cwiseProduct(m) + product;
  if (tangent != nullptr) set_tangent(w, 0, *tangent);
  TREMOLO_CALL(multiply_packed, w.held_b.data(), static_cast<std::size_t>(size()), d.data(),
               product.data());
  out += product;
}

void Potential::averaged_jacobian(const VectorXd& q0, const VectorXd& q1, PotentialWorkspace& w,
                                  Eigen::MatrixXd& out) const {
  if (linear()) {
    out = (0.5 * lambda_).asDiagonal();
    return;
  }
  Eigen::Map<VectorXd> m(w.q.data(), size()), d(w.second.data(), size());
  d = 0.5 * (q1 - q0);
  // Half of Lambda + 6 C[m + d/3] + 12 Q[X], with
  // X = m m^T + d d^T/3 + (m d^T + d m^T)/3 = (m + d/3)(m + d/3)^T + 2/9 d d^T.
  m = 0.5 * (q0 + q1) + d / 3.0;
  w.pair_kernel->fill_pairs(m.data(), d.data(), 2.0 / 9.0, w.x.data());
  set_a_and_b(w);
  set_tangent(w, 0, out);
  out *= 0.5;
}

}  // namespace tremolo
