#include "runtime/contact/islands/block_solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/SparseLU>

namespace tremolo {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

void BlockSolver::find_neighbours() {
  neighbours_.resize(std::max(neighbours_.size(), system_->bodies()));
  for (std::vector<Neighbour>& all : neighbours_) all.clear();
  for (const BlockLink& link : system_->links) {
    neighbours_[link.a].push_back({link.b, link.ab, link.ba});
    neighbours_[link.b].push_back({link.a, link.ba, link.ab});
  }
}

// Eliminates bodies one after the other: always the one with the fewest remaining neighbours, and
// among equals the first.
void BlockSolver::find_order() {
  const std::size_t count = system_->bodies();
  order_.clear();
  rank_.assign(count, count);
  degree_.resize(count);
  for (std::size_t i = 0; i < count; ++i) degree_[i] = neighbours_[i].size();
  while (order_.size() < count) {
    std::size_t next = count;
    for (std::size_t i = 0; i < count; ++i)
      if (rank_[i] == count && (next == count || degree_[i] < degree_[next])) next = i;
    rank_[next] = order_.size();
    order_.push_back(next);
    for (const Neighbour& other : neighbours_[next])
      if (rank_[other.body] == count) --degree_[other.body];
  }
}

bool BlockSolver::decompose() {
  inverse_.resize(std::max(inverse_.size(), system_->bodies()));
  for (const std::size_t k : order_) {
    const Index n = system_->first[k + 1] - system_->first[k];
    d_ = system_->diagonal[k]->topLeftCorner(n, n);
    for (const Neighbour& other : neighbours_[k]) {
      if (rank_[other.body] > rank_[k]) continue;
      through_.noalias() = inverse_[other.body] * *other.back;
      d_.noalias() -= *other.block * through_;
    }
    factor_.compute(d_);
    inverse_[k].setIdentity(n, n);
    factor_.solve_in_place(inverse_[k]);
    if (!inverse_[k].allFinite()) return false;
  }
  return true;
}

void BlockSolver::multiply(const VectorXd& x, Eigen::Ref<VectorXd> y) const {
  const auto& first = system_->first;
  for (std::size_t k = 0; k < system_->bodies(); ++k) {
    const Index n = first[k + 1] - first[k];
    auto row = y.segment(first[k], n);
    row.noalias() = system_->diagonal[k]->topLeftCorner(n, n) * x.segment(first[k], n);
    for (const Neighbour& other : neighbours_[k])
      row.noalias() +=
          *other.block * x.segment(first[other.body], first[other.body + 1] - first[other.body]);
  }
}

// x = M^-1 b.
void BlockSolver::precondition(const Eigen::Ref<const VectorXd>& b, VectorXd& x) {
  const auto& first = system_->first;
  const auto of = [&](std::size_t k) { return x.segment(first[k], first[k + 1] - first[k]); };
  for (const std::size_t k : order_) {
    part_ = b.segment(first[k], first[k + 1] - first[k]);
    for (const Neighbour& other : neighbours_[k])
      if (rank_[other.body] < rank_[k]) part_.noalias() -= *other.block * of(other.body);
    of(k).noalias() = inverse_[k] * part_;
  }
  for (std::size_t back = order_.size(); back-- > 0;) {
    const std::size_t k = order_[back];
    part_.setZero(first[k + 1] - first[k]);
    for (const Neighbour& other : neighbours_[k])
      if (rank_[other.body] > rank_[k]) part_.noalias() += *other.block * of(other.body);
    of(k).noalias() -= inverse_[k] * part_;
  }
}

bool BlockSolver::iterate(const VectorXd& b, VectorXd& x, double tolerance) {
  const Index n = system_->unknowns();
  constexpr Index m = kMostIterations;
  const auto scale = system_->scale->head(n);
  if (basis_.rows() < n) {
    basis_.resize(n, m + 1);
    image_.resize(n);
  }
  hessenberg_.resize(m + 1, m);
  turned_.setZero(m + 1);
  cosine_.resize(m);
  sine_.resize(m);
  const auto v = [&](Index j) { return basis_.col(j).head(n); };
  v(0) = scale.cwiseProduct(b.head(n));
  const double size = v(0).norm();
  x.head(n).setZero();
  if (size == 0.0) return true;
  v(0) /= size;
  turned_[0] = size;
  Index used = 0;
  bool reached = false;
  while (used < m && !reached) {
    const Index j = used++;
    image_.head(n) = v(j).cwiseQuotient(scale);
    precondition(image_.head(n), x);
    multiply(x, v(j + 1));
    v(j + 1).array() *= scale.array();
    for (Index i = 0; i <= j; ++i) {
      hessenberg_(i, j) = v(i).dot(v(j + 1));
      v(j + 1) -= hessenberg_(i, j) * v(i);
    }
    const double left = v(j + 1).norm();
    if (!std::isfinite(left)) return false;
    if (left > 0.0) v(j + 1) /= left;
    // Givens rotations keep the matrix triangular, and the residual's size in turned_.
    for (Index i = 0; i < j; ++i) {
      const double above = hessenberg_(i, j), below = hessenberg_(i + 1, j);
      hessenberg_(i, j) = cosine_[i] * above + sine_[i] * below;
      hessenberg_(i + 1, j) = cosine_[i] * below - sine_[i] * above;
    }
    const double length = std::hypot(hessenberg_(j, j), left);
    if (length == 0.0) return false;
    cosine_[j] = hessenberg_(j, j) / length;
    sine_[j] = left / length;
    hessenberg_(j, j) = length;
    turned_[j + 1] = -sine_[j] * turned_[j];
    turned_[j] *= cosine_[j];
    reached = std::abs(turned_[j + 1]) <= tolerance * size;
  }
  iterations_ = static_cast<int>(used);
  if (!reached) return false;
  auto y = turned_.head(used);
  hessenberg_.topLeftCorner(used, used).triangularView<Eigen::Upper>().solveInPlace(y);
  image_.head(n).noalias() = basis_.topLeftCorner(n, used) * y;
  image_.head(n).array() /= scale.array();
  precondition(image_.head(n), x);
  return x.head(n).allFinite();
}

bool BlockSolver::solve_sparse(const VectorXd& b, VectorXd& x) const {
  const Index n = system_->unknowns();
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&entries](Index row, Index column, const auto& block) {
    for (Index j = 0; j < block.cols(); ++j)
      for (Index i = 0; i < block.rows(); ++i)
        entries.emplace_back(static_cast<int>(row + i), static_cast<int>(column + j), block(i, j));
  };
  const auto& first = system_->first;
  for (std::size_t k = 0; k < system_->bodies(); ++k) {
    const Index size = first[k + 1] - first[k];
    add(first[k], first[k], system_->diagonal[k]->topLeftCorner(size, size));
    for (const Neighbour& other : neighbours_[k]) add(first[k], first[other.body], *other.block);
  }
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success) return false;
  x.head(n) = factor.solve(b.head(n));
  return x.head(n).allFinite();
}

bool BlockSolver::solve(const BlockSystem& system, const VectorXd& b, VectorXd& x,
                        double tolerance) {
  system_ = &system;
  find_neighbours();
  find_order();
  if (decompose() && iterate(b, x, tolerance)) return true;
  iterations_ = kMostIterations + 1;
  return solve_sparse(b, x);
}

}  // namespace tremolo
