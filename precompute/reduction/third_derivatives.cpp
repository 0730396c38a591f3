#include "precompute/reduction/third_derivatives.h"

#include <algorithm>
#include <iterator>

#include "common/packed_index.h"
#include "precompute/fem/element_group.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/rest_solve.h"

namespace tremolo {
namespace {

constexpr int kMost = 3;  // leading modes

}  // namespace

std::vector<std::array<int, 3>> third_orders(Eigen::Index modes, int leading) {
  std::vector<std::array<int, 3>> orders;
  for (int l = 0; l < static_cast<int>(modes); ++l)
    for (int j = 0; j <= std::min(l, leading - 1); ++j)
      for (int i = 0; i <= j; ++i) orders.push_back({i, j, l});
  return orders;
}

std::vector<std::array<int, 3>> third_orders_of(Eigen::Index modes, Eigen::Index columns) {
  const Eigen::Index thirds = columns - modes - static_cast<Eigen::Index>(pair_count(modes));
  int leading = 0;
  while (leading < kMost && std::ssize(third_orders(modes, leading)) < thirds) ++leading;
  return third_orders(modes, leading);
}

int leading_modes(const Eigen::VectorXd& squared_frequencies) {
  constexpr double kAsSoft = 1.05;
  const Eigen::Index count = std::min<Eigen::Index>(kMost, squared_frequencies.size());
  return static_cast<int>(
      (squared_frequencies.head(count).array() <= kAsSoft * squared_frequencies[0]).count());
}

void add_third_derivatives(const BodyAtRest& body, const BasisRows& psi, int leading,
                           ModalDerivatives& derivatives) {
  const LocalDofs& local = body.local;
  const auto k = static_cast<int>(psi.cols());
  const std::vector<std::array<int, 3>> orders = third_orders(k, leading);
  const Eigen::Index before = derivatives.columns.cols(), count = orders.size();

  // The fields of the right-hand sides: Psi_i at column i, Phi_al at column k + a k + l.
  Columns along(local.dofs(), Eigen::Index{leading} * k);
  for (int a = 0; a < leading; ++a)
    for (int l = 0; l < k; ++l)
      along.col(a * k + l) =
          derivatives.columns.col(k + pair_index(std::min(a, l), std::max(a, l)));
  BasisRows fields(psi.rows(), k + along.cols());
  fields << psi, expand_to_vertices(body.map, local, along);
  const auto phi = [k](int a, int l) { return k + a * k + l; };

  const auto fill = [&](Eigen::Index first, Columns& loads) {
    const auto begin = orders.begin() + first, end = begin + loads.cols();
    // One term of the sum for all of the columns.
    const auto subtract = [&](const auto& pair_of) {
      std::vector<ColumnPair> pairs;
      std::transform(begin, end, std::back_inserter(pairs), pair_of);
      subtract_second_derivatives(body.solid, local.elements, fields, pairs, local.row_of_vertex,
                                  loads.data(), loads.rows());
    };
    using Order = std::array<int, 3>;
    subtract([&](const Order& of) { return ColumnPair{of[0], phi(of[1], of[2])}; });
    subtract([&](const Order& of) { return ColumnPair{of[1], phi(of[0], of[2])}; });
    subtract([&](const Order& of) { return ColumnPair{of[2], phi(of[0], of[1])}; });
    Eigen::VectorXd cubic(loads.rows());
    for (Eigen::Index column = 0; column < loads.cols(); ++column) {
      const auto& [i, j, l] = orders[first + column];
      cubic.setZero();
      add_third_derivative(body.solid, local.elements, {psi.col(i), psi.col(j), psi.col(l)},
                           local.row_of_vertex, cubic.data());
      loads.col(column) -= cubic;
    }
  };
  derivatives.columns.conservativeResize(Eigen::NoChange, before + count);
  const Eigen::Index block = 1 + (count - 1) / std::max(1u, body.pencil.threads);
  const double residual =
      solve_at_rest(body.pencil, body.solver, block, fill, derivatives.columns.rightCols(count));
  derivatives.residual = std::max(derivatives.residual, residual);
}

}  // namespace tremolo
