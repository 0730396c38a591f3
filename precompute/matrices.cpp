#include "precompute/matrices.h"

namespace tremolo {
namespace {

void require(PetscErrorCode code) {
  check_petsc(code, "assemble the matrices");
}

// Rows of `per_neighbour` entries for each neighbour and the node itself.
PetscMatrix make_sparse(const DofMap& map, const LocalDofs& local, int per_neighbour) {
  std::vector<PetscInt> own, other;
  const int first = local.first_node;
  const int last = first + local.nodes;
  for (int node = first; node < last; ++node) {
    PetscInt inside = 1, outside = 0;
    for (int at = map.graph.start[node]; at < map.graph.start[node + 1]; ++at) {
      const int neighbour = map.graph.neighbours[at];
      (neighbour >= first && neighbour < last ? inside : outside) += 1;
    }
    own.insert(own.end(), 3, per_neighbour * inside);
    other.insert(other.end(), 3, per_neighbour * outside);
  }
  PetscMatrix matrix;
  require(MatCreate(PETSC_COMM_WORLD, matrix.out()));
  require(MatSetSizes(matrix.get(), local.dofs(), local.dofs(), PETSC_DETERMINE, PETSC_DETERMINE));
  require(MatSetBlockSize(matrix.get(), 3));
  require(MatSetType(matrix.get(), MATAIJ));
  require(MatSeqAIJSetPreallocation(matrix.get(), 0, own.data()));
  require(MatMPIAIJSetPreallocation(matrix.get(), 0, own.data(), 0, other.data()));
  // Every rank inserts only its own rows: nothing travels.
  require(MatSetOption(matrix.get(), MAT_NO_OFF_PROC_ENTRIES, PETSC_TRUE));
  return matrix;
}

void finish(PetscMatrix& matrix) {
  require(MatAssemblyBegin(matrix.get(), MAT_FINAL_ASSEMBLY));
  require(MatAssemblyEnd(matrix.get(), MAT_FINAL_ASSEMBLY));
  require(MatSetOption(matrix.get(), MAT_SYMMETRIC, PETSC_TRUE));
  require(MatSetOption(matrix.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
}

}  // namespace

Matrices assemble(const Solid& solid, const DofMap& map, const LocalDofs& local, MassKind kind) {
  Matrices matrices;
  matrices.stiffness = make_sparse(map, local, 3);
  for_each_stiffness_block(solid, map, local,
                           [&](int row, int column, const Eigen::Matrix3d& block) {
                             // PETSc wants blocks row by row.
                             const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> values = block;
                             require(MatSetValuesBlocked(matrices.stiffness.get(), 1, &row, 1,
                                                         &column, values.data(), ADD_VALUES));
                           });
  finish(matrices.stiffness);

  matrices.mass = make_sparse(map, local, 1);
  for_each_mass_entry(solid, map, local, kind, [&](int row, int column, double value) {
    for (int axis = 0; axis < 3; ++axis)
      require(
          MatSetValue(matrices.mass.get(), 3 * row + axis, 3 * column + axis, value, ADD_VALUES));
  });
  finish(matrices.mass);
  return matrices;
}

Eigen::MatrixXd expand_to_vertices(const DofMap& map, const LocalDofs& local,
                                   const Columns& columns) {
  Eigen::MatrixXd all(3 * map.nodes(), columns.cols());
  if (mpi_ranks() == 1) {
    all = columns;
  } else {
    std::vector<int> counts, starts;
    for (int rank = 0; rank < mpi_ranks(); ++rank) {
      counts.push_back(3 * (map.rank_begin[rank + 1] - map.rank_begin[rank]));
      starts.push_back(3 * map.rank_begin[rank]);
    }
    for (Eigen::Index c = 0; c < columns.cols(); ++c)
      MPI_Allgatherv(columns.col(c).data(), local.dofs(), MPI_DOUBLE, all.col(c).data(),
                     counts.data(), starts.data(), MPI_DOUBLE, PETSC_COMM_WORLD);
  }
  const auto vertices = static_cast<Eigen::Index>(map.node_of_vertex.size());
  Eigen::MatrixXd expanded = Eigen::MatrixXd::Zero(3 * vertices, columns.cols());
  for (int node = 0; node < map.nodes(); ++node)
    expanded.middleRows(3 * Eigen::Index{map.vertex_of_node[node]}, 3) =
        all.middleRows(3 * Eigen::Index{node}, 3);
  return expanded;
}

}  // namespace tremolo
