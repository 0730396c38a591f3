#include "precompute/vega/reduced_tensors.h"

#include <algorithm>
#include <cmath>

#include "common/packed_index.h"

namespace tremolo {
namespace {

// Accumulates the values that rows give for each entry and compares them with their mean.
class Mean {
 public:
  explicit Mean(std::size_t count) : sum_(count, 0.0), low_(count), high_(count), rows_(count, 0) {}

  void add(std::size_t entry, double value) {
    low_[entry] = rows_[entry] == 0 ? value : std::min(low_[entry], value);
    high_[entry] = rows_[entry] == 0 ? value : std::max(high_[entry], value);
    sum_[entry] += value;
    ++rows_[entry];
  }

  std::vector<double> take(double& asymmetry) {
    double largest = 0, deviation = 0;
    for (std::size_t e = 0; e < sum_.size(); ++e) {
      // Equal values are kept exactly; their mean could be rounded.
      sum_[e] = low_[e] == high_[e] ? low_[e] : sum_[e] / rows_[e];
      largest = std::max({largest, std::abs(low_[e]), std::abs(high_[e])});
      deviation = std::max({deviation, high_[e] - sum_[e], sum_[e] - low_[e]});
    }
    if (largest > 0) asymmetry = std::max(asymmetry, deviation / largest);
    return std::move(sum_);
  }

 private:
  std::vector<double> sum_, low_, high_;
  std::vector<int> rows_;
};

std::size_t size_of(const ReducedTensors& tensors) {
  return tensors.quadratic.rows();
}

// Returns the symmetric matrix with packed entries entry(i, j), i <= j.
template <class Entry>
Eigen::MatrixXd unpack(std::size_t r, const Entry& entry) {
  Eigen::MatrixXd matrix(r, r);
  for (std::size_t j = 0; j < r; ++j)
    for (std::size_t i = 0; i <= j; ++i) matrix(i, j) = matrix(j, i) = entry(i, j);
  return matrix;
}

std::vector<double> change_cubic(const ReducedTensors& tensors, const Eigen::MatrixXd& change) {
  const std::size_t r = size_of(tensors);
  const auto size = change.rows();
  // half(ab, k): two indices transformed; the third follows below.
  Eigen::MatrixXd half(pair_count(r), size);
  for (std::size_t k = 0; k < r; ++k) {
    const Eigen::MatrixXd slice =
        change.transpose() *
        unpack(r, [&](std::size_t i,
                      std::size_t j) { return tensors.cubic[triple_index_any(i, j, k)]; }) *
        change;
    for (std::size_t b = 0; b < r; ++b)
      for (std::size_t a = 0; a <= b; ++a) half(pair_index(a, b), k) = slice(a, b);
  }
  const Eigen::MatrixXd whole = half * change;
  std::vector<double> cubic(triple_count(r));
  for (std::size_t c = 0; c < r; ++c)
    for (std::size_t b = 0; b <= c; ++b)
      for (std::size_t a = 0; a <= b; ++a)
        cubic[triple_index(a, b, c)] = whole(pair_index(a, b), c);
  return cubic;
}

std::vector<double> change_quartic(const ReducedTensors& tensors, const Eigen::MatrixXd& change) {
  const std::size_t r = size_of(tensors);
  const Eigen::Index pairs = pair_count(r);
  // half(kl, ab): the first two indices transformed to a, b.
  Eigen::MatrixXd half(pairs, pairs);
  for (std::size_t l = 0; l < r; ++l)
    for (std::size_t k = 0; k <= l; ++k) {
      const Eigen::MatrixXd slice =
          change.transpose() *
          unpack(r, [&](std::size_t i,
                        std::size_t j) { return tensors.quartic[quad_index_any(i, j, k, l)]; }) *
          change;
      for (std::size_t b = 0; b < r; ++b)
        for (std::size_t a = 0; a <= b; ++a) half(pair_index(k, l), pair_index(a, b)) = slice(a, b);
    }
  std::vector<double> quartic(quad_count(r));
  for (std::size_t b = 0; b < r; ++b)
    for (std::size_t a = 0; a <= b; ++a) {
      const double* column = half.col(pair_index(a, b)).data();
      const Eigen::MatrixXd slice =
          change.transpose() *
          unpack(r, [&](std::size_t k, std::size_t l) { return column[pair_index(k, l)]; }) *
          change;
      for (std::size_t d = b; d < r; ++d)
        for (std::size_t c = b; c <= d; ++c) quartic[quad_index(a, b, c, d)] = slice(c, d);
    }
  return quartic;
}

}  // namespace

SymmetrisedForces symmetrise(const ReducedForces& forces) {
  const std::size_t r = forces.size;
  Mean pairs(pair_count(r)), triples(triple_count(r)), quads(quad_count(r));
  const double* linear = forces.linear.data();
  const double* quadratic = forces.quadratic.data();
  const double* cubic = forces.cubic.data();
  // Row i contains d/dq_i of the tensors: the order times the number of orderings of the other
  // indices.
  for (std::size_t i = 0; i < r; ++i)
    for (std::size_t j = 0; j < r; ++j) {
      pairs.add(pair_index_any(i, j), *linear++);
      for (std::size_t k = j; k < r; ++k) {
        triples.add(triple_index_any(i, j, k), *quadratic++ / (j == k ? 3.0 : 6.0));
        for (std::size_t l = k; l < r; ++l)
          quads.add(quad_index_any(i, j, k, l), *cubic++ / (4.0 * orderings(j, k, l)));
      }
    }
  SymmetrisedForces result;
  const std::vector<double> packed = pairs.take(result.asymmetry);
  result.tensors.quadratic =
      unpack(r, [&](std::size_t i, std::size_t j) { return packed[pair_index(i, j)]; });
  result.tensors.cubic = triples.take(result.asymmetry);
  result.tensors.quartic = quads.take(result.asymmetry);
  return result;
}

ReducedTensors change_coordinates(const ReducedTensors& tensors, const Eigen::MatrixXd& change) {
  return {change.transpose() * tensors.quadratic * change, change_cubic(tensors, change),
          change_quartic(tensors, change)};
}

Eigen::VectorXd gradient(const ReducedTensors& tensors, const Eigen::VectorXd& q) {
  const std::size_t r = size_of(tensors);
  Eigen::VectorXd result = tensors.quadratic * q;
  const auto at = [&](std::size_t i) { return q[i]; };
  for (std::size_t i = 0; i < r; ++i)
    for (std::size_t j = 0; j < r; ++j)
      for (std::size_t k = j; k < r; ++k) {
        double inner = 3.0 * (j == k ? 1.0 : 2.0) * tensors.cubic[triple_index_any(i, j, k)];
        for (std::size_t l = k; l < r; ++l)
          inner += 4.0 * orderings(j, k, l) * tensors.quartic[quad_index_any(i, j, k, l)] * at(l);
        result[i] += inner * at(j) * at(k);
      }
  return result;
}

}  // namespace tremolo
