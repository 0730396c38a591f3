#include "precompute/reduction/derivatives.h"

#include "common/packed_index.h"
#include "precompute/fem/element_group.h"
#include "precompute/reduction/rest_solve.h"

namespace tremolo {

ModalDerivatives modal_derivatives(const Solid& solid, const LocalDofs& local, const Pencil& pencil,
                                   const ShiftedSolver& solver, const Columns& modes,
                                   const BasisRows& psi) {
  constexpr Eigen::Index kBlock = 28;  // 210 columns are eight blocks, so threads finish together
  std::vector<ColumnPair> pairs;
  for (int j = 0; j < static_cast<int>(psi.cols()); ++j)
    for (int i = 0; i <= j; ++i) pairs.push_back({i, j});
  const Eigen::Index count = pairs.size();
  ModalDerivatives result;
  result.modes = modes.cols();
  result.columns.resize(local.dofs(), result.modes + count);
  result.columns.leftCols(result.modes) = modes;
  const auto fill = [&](Eigen::Index first, Columns& loads) {
    subtract_second_derivatives(solid, local.elements, psi,
                                {pairs.begin() + first, pairs.begin() + first + loads.cols()},
                                local.row_of_vertex, loads.data(), loads.rows());
  };
  result.residual = solve_at_rest(pencil, solver, kBlock, fill, result.columns.rightCols(count));
  return result;
}

}  // namespace tremolo
