#include "runtime/bodies/tets/solve/active_solve.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace tremolo {

ActiveSolve::ActiveSolve(BlockPatternPointer pattern, std::shared_ptr<const SmoothSpace> smooth)
    : pattern_(std::move(pattern)), smooth_space_(smooth), floats_(*pattern_, std::move(smooth)) {
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
  std::fill(rank_.begin(), rank_.end(), kNoRank);
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
  floats_.choose(*pattern_, nodes_, rank_);
}

FoldedPoint ActiveSolve::folded(std::span<const std::uint32_t> nodes,
                                std::span<const double> shares) const {
  FoldedPoint point;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (shares[i] == 0.0 || rank_[nodes[i]] == kNoRank) continue;
    point.nodes[point.count] = rank_[nodes[i]];
    point.shares[point.count++] = shares[i];
  }
  return point;
}

void ActiveSolve::take_diagonal(const BlockMatrix& a) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) inverse_[i] = a.diagonal(nodes_[i]);
  has_smooth_ = added_ = false;
}

FloatTarget ActiveSolve::begin_single() {
  return floats_.begin();
}

void ActiveSolve::take_diagonal() {
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) inverse_[i] = floats_.diagonal(i);
  has_smooth_ = false;
  added_ = true;
}

void ActiveSolve::take_smooth(const Eigen::Matrix3d& turn, double mass, double stiffness) {
  smooth_ = smooth_matrix(*smooth_space_, turn, mass, stiffness);
  has_smooth_ = true;
}

void ActiveSolve::add_diagonal(const FoldedPoint& point, const Eigen::Matrix3d& block) {
  for (std::uint32_t i = 0; i < point.count; ++i)
    inverse_[point.nodes[i]] += point.shares[i] * point.shares[i] * block;
  if (!has_smooth_) return;
  Eigen::Matrix<double, kSmoothFields, 1> fields;
  fields.setZero();
  for (std::uint32_t i = 0; i < point.count; ++i)
    for (std::size_t k = 0; k < kSmoothFields; ++k)
      fields[k] += point.shares[i] * smooth_space_->at[nodes_[point.nodes[i]]][k];
  for (int k = 0; k < kSmoothFields; ++k)
    for (int l = 0; l < kSmoothFields; ++l)
      smooth_.block<3, 3>(3 * k, 3 * l) += (fields[k] * fields[l]) * block;
}

// A_c^-1; zero if there is none, or if it is not positive.
SmoothMatrix ActiveSolve::smooth_inverse() const {
  if (!has_smooth_) return SmoothMatrix::Zero();
  const Eigen::LLT<SmoothMatrix> factor(smooth_);
  if (factor.info() != Eigen::Success) return SmoothMatrix::Zero();
  SmoothMatrix inverse = factor.solve(SmoothMatrix::Identity());
  return inverse.allFinite() ? inverse : SmoothMatrix::Zero();
}

SearchSizes ActiveSolve::start(const BlockMatrix& a, const Eigen::VectorXd& b, bool single) {
  SearchSizes sizes;
  single_ = single;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    inverse_[i] = Eigen::Matrix3d(inverse_[i].inverse());
    if (!inverse_[i].allFinite()) inverse_[i].setIdentity();
    r_[i] = b.segment<3>(3 * Eigen::Index{nodes_[i]});
    x_[i].setZero();
    z_[i].noalias() = inverse_[i] * r_[i];
    p_[i] = z_[i];
    sizes.square += r_[i].squaredNorm();
    sizes.product += r_[i].dot(z_[i]);
  }
  if (single_ && !added_) floats_.take(a);
  if (single_) sizes.product = floats_.start(inverse_, smooth_inverse(), r_);
  return sizes;
}

double ActiveSolve::multiply(const BlockMatrix& a) {
  if (single_) return floats_.multiply();
  double product = 0.0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const Eigen::Vector3d own = p_[i];
    const Eigen::Vector3d diagonal = a.diagonal(nodes_[i]) * own;
    Eigen::Vector3d lower = Eigen::Vector3d::Zero();
    for (std::size_t k = first_[i]; k < first_[i + 1]; ++k) {
      const Eigen::Matrix3d& block = a.block(entries_[k].place);
      lower.noalias() += block * p_[entries_[k].column];
      q_[entries_[k].column].noalias() += block.transpose() * own;
    }
    q_[i] = diagonal + lower;
    // Both triangles contribute equally to p.q.
    product += own.dot(diagonal) + 2.0 * own.dot(lower);
  }
  return product;
}

SearchSizes ActiveSolve::advance(double length) {
  SearchSizes sizes;
  if (single_) {
    std::tie(sizes.square, sizes.product) = floats_.advance(length);
    return sizes;
  }
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    x_[i] += length * p_[i];
    r_[i] -= length * q_[i];
    z_[i].noalias() = inverse_[i] * r_[i];
    sizes.square += r_[i].squaredNorm();
    sizes.product += r_[i].dot(z_[i]);
  }
  return sizes;
}

void ActiveSolve::turn(double share) {
  if (single_) return floats_.turn(share);
  for (std::size_t i = 0; i < nodes_.size(); ++i) p_[i] = z_[i] + share * p_[i];
}

void ActiveSolve::finish(Eigen::VectorXd& x) const {
  x.setZero();
  for (std::uint32_t i = 0; i < nodes_.size(); ++i)
    x.segment<3>(3 * Eigen::Index{nodes_[i]}) = single_ ? floats_.solution(i) : x_[i];
}

Eigen::Vector3d ActiveSolve::direction_at(const FoldedPoint& point) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::uint32_t i = 0; i < point.count; ++i)
    sum += point.shares[i] * (single_ ? floats_.direction(point.nodes[i]) : p_[point.nodes[i]]);
  return sum;
}

void ActiveSolve::add_image(const FoldedPoint& point, const Eigen::Vector3d& value) {
  for (std::uint32_t i = 0; i < point.count; ++i) {
    if (single_)
      floats_.add_image(point.nodes[i], point.shares[i] * value);
    else
      q_[point.nodes[i]] += point.shares[i] * value;
  }
}

ActiveReport ActiveSolve::solve(const BlockMatrix& a, const Eigen::VectorXd& b, double tolerance,
                                int most_iterations, Eigen::VectorXd& x) {
  ActiveReport report;
  take_diagonal(a);
  SearchSizes now = start(a, b, tolerance >= kSingleTolerance);
  const double first = now.square, stop = tolerance * tolerance * first;
  while (now.square > stop && report.iterations < most_iterations) {
    const double along = multiply(a);
    report.positive = along > 0.0;
    if (!report.positive) break;
    const double before = now.product;
    now = advance(before / along);
    turn(now.product / before);
    ++report.iterations;
  }
  report.residual = first > 0.0 ? std::sqrt(now.square / first) : 0.0;
  finish(x);
  return report;
}

std::size_t ActiveSolve::bytes() const {
  const std::size_t nodes = pattern_->size();
  return nodes * (5 * sizeof(Eigen::Vector3d) + sizeof(Eigen::Matrix3d) + 12) +
         pattern_->blocks() * sizeof(Entry) + floats_.bytes();
}

}  // namespace tremolo
