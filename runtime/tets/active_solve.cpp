#include "runtime/tets/active_solve.h"

#include <cmath>
#include <utility>

#include <Eigen/LU>

namespace tremolo {

ActiveSolve::ActiveSolve(BlockPatternPointer pattern) : pattern_(std::move(pattern)) {
  const std::size_t nodes = pattern_->size();
  nodes_.reserve(nodes);
  rank_.resize(nodes);
  first_.reserve(nodes + 1);
  entries_.reserve(pattern_->blocks());
  inverse_.resize(nodes);
  for (Vectors* v : {&x_, &r_, &z_, &p_, &q_}) v->resize(nodes);
  choose(std::vector<std::uint8_t>(nodes, 1));
}

void ActiveSolve::choose(std::span<const std::uint8_t> active) {
  nodes_.clear();
  first_.clear();
  entries_.clear();
  for (std::size_t i = 0; i < active.size(); ++i)
    if (active[i] != 0) {
      rank_[i] = static_cast<std::uint32_t>(nodes_.size());
      nodes_.push_back(static_cast<std::uint32_t>(i));
    }
  const auto first = pattern_->first();
  const auto columns = pattern_->columns();
  first_.push_back(0);
  for (const std::uint32_t node : nodes_) {
    for (std::size_t p = first[node]; p + 1 < first[node + 1]; ++p)
      if (active[columns[p]] != 0)
        entries_.push_back({rank_[columns[p]], static_cast<std::uint32_t>(p)});
    first_.push_back(static_cast<std::uint32_t>(entries_.size()));
  }
}

void ActiveSolve::invert_diagonal(const BlockMatrix& a) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    inverse_[i] = a.diagonal(nodes_[i]).inverse();
    if (!inverse_[i].allFinite()) inverse_[i].setIdentity();
  }
}

double ActiveSolve::multiply(const BlockMatrix& a) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Eigen::Vector3d own = p_[i];
    Eigen::Vector3d sum = a.diagonal(nodes_[i]) * own;
    for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) {
      const Eigen::Matrix3d& block = a.block(entries_[k].place);
      sum.noalias() += block * p_[entries_[k].column];
      q_[entries_[k].column].noalias() += block.transpose() * own;
    }
    q_[i] = sum;
  }
  double product = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) product += p_[i].dot(q_[i]);
  return product;
}

double ActiveSolve::precondition() {
  double product = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    z_[i].noalias() = inverse_[i] * r_[i];
    product += r_[i].dot(z_[i]);
  }
  return product;
}

ActiveReport ActiveSolve::solve(const BlockMatrix& a, const Eigen::VectorXd& b, double tolerance,
                                int most_iterations, Eigen::VectorXd& x) {
  ActiveReport report;
  invert_diagonal(a);
  double squared = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    r_[i] = b.segment<3>(3 * Eigen::Index{nodes_[i]});
    squared += r_[i].squaredNorm();
    x_[i].setZero();
  }
  const double start = squared, stop = tolerance * tolerance * squared;
  double rho = precondition();
  for (std::size_t i = 0; i < nodes_.size(); ++i) p_[i] = z_[i];
  while (squared > stop && report.iterations < most_iterations) {
    const double curvature = multiply(a);
    report.positive = curvature > 0.0;
    if (!report.positive) break;
    const double length = rho / curvature;
    squared = 0.0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      x_[i] += length * p_[i];
      r_[i] -= length * q_[i];
      squared += r_[i].squaredNorm();
    }
    const double before = std::exchange(rho, precondition());
    for (std::size_t i = 0; i < nodes_.size(); ++i) p_[i] = z_[i] + (rho / before) * p_[i];
    ++report.iterations;
  }
  report.residual = start > 0.0 ? std::sqrt(squared / start) : 0.0;
  x.setZero();
  for (std::size_t i = 0; i < nodes_.size(); ++i) x.segment<3>(3 * Eigen::Index{nodes_[i]}) = x_[i];
  return report;
}

std::size_t ActiveSolve::bytes() const {
  const std::size_t nodes = pattern_->size();
  return nodes * (5 * sizeof(Eigen::Vector3d) + sizeof(Eigen::Matrix3d) + 12) +
         pattern_->blocks() * sizeof(Entry);
}

}  // namespace tremolo
