#include "precompute/fem/matrices.h"

#include <algorithm>
#include <limits>

#include "precompute/system/failure.h"

namespace tremolo {
namespace {

void require_assembly(PetscErrorCode code) {
  check_petsc(code, "assemble the matrices");
}

// The rows of this rank in compressed form, with the pattern of the node graph: each node and
// neighbour stand for three rows and `per_node` columns (3: a full block, 1: its diagonal).
struct Rows {
  std::vector<PetscInt> start, column;
  std::vector<double> value;
};

// Returns the neighbours of a node and the node itself, ascending: the columns of its blocks.
std::vector<int> row_nodes(const DofMap& map, int node) {
  std::vector<int> nodes(map.graph.neighbours.begin() + map.graph.start[node],
                         map.graph.neighbours.begin() + map.graph.start[node + 1]);
  nodes.insert(std::lower_bound(nodes.begin(), nodes.end(), node), node);
  return nodes;
}

Rows make_pattern(const DofMap& map, const LocalDofs& local, int per_node) {
  Rows rows;
  rows.start.push_back(0);
  for (int node = local.first_node; node < local.first_node + local.nodes; ++node) {
    const std::vector<int> nodes = row_nodes(map, node);
    if (rows.column.size() + 9 * nodes.size() > std::numeric_limits<PetscInt>::max())
      throw Failure(
          system_error("the stiffness has more than 2^31 entries on one rank: use more "
                       "ranks"));
    for (int axis = 0; axis < 3; ++axis) {
      for (int other : nodes)
        for (int k = 0; k < per_node; ++k)
          rows.column.push_back(3 * other + (per_node == 1 ? axis : k));
      rows.start.push_back(static_cast<PetscInt>(rows.column.size()));
    }
  }
  rows.value.assign(rows.column.size(), 0.0);
  return rows;
}

// Returns the position of `other` among the nodes of the row.
int position(const DofMap& map, int node, int other) {
  const auto begin = map.graph.neighbours.begin() + map.graph.start[node];
  const auto end = map.graph.neighbours.begin() + map.graph.start[node + 1];
  const auto found = std::lower_bound(begin, end, other);
  return static_cast<int>(found - begin) + (other > node ? 1 : 0);
}

// Creates a distributed matrix; PETSc copies the rows.
PetscMatrix make_sparse(const LocalDofs& local, Rows rows) {
  PetscMatrix matrix;
  require_assembly(MatCreate(PETSC_COMM_WORLD, matrix.out()));
  require_assembly(
      MatSetSizes(matrix.get(), local.dofs(), local.dofs(), PETSC_DETERMINE, PETSC_DETERMINE));
  require_assembly(MatSetBlockSize(matrix.get(), 3));
  require_assembly(MatSetType(matrix.get(), MATAIJ));
  require_assembly(MatSeqAIJSetPreallocationCSR(matrix.get(), rows.start.data(), rows.column.data(),
                                                rows.value.data()));
  require_assembly(MatMPIAIJSetPreallocationCSR(matrix.get(), rows.start.data(), rows.column.data(),
                                                rows.value.data()));
  require_assembly(MatSetOption(matrix.get(), MAT_SYMMETRIC, PETSC_TRUE));
  require_assembly(MatSetOption(matrix.get(), MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  return matrix;
}

}  // namespace

Matrices assemble(const Solid& solid, const DofMap& map, const LocalDofs& local, MassKind kind) {
  Matrices matrices;
  Rows stiffness = make_pattern(map, local, 3);
  for_each_stiffness_block(solid, local, [&](int row, int column, const Eigen::Matrix3d& block) {
    const int at = 3 * position(map, row, column);
    for (int axis = 0; axis < 3; ++axis) {
      double* entry =
          stiffness.value.data() + stiffness.start[3 * (row - local.first_node) + axis] + at;
      for (int k = 0; k < 3; ++k) entry[k] += block(axis, k);
    }
  });
  matrices.stiffness = make_sparse(local, std::move(stiffness));

  Rows mass = make_pattern(map, local, 1);
  for_each_mass_entry(solid, local, kind, [&](int row, int column, double value) {
    const int at = position(map, row, column);
    for (int axis = 0; axis < 3; ++axis)
      mass.value[mass.start[3 * (row - local.first_node) + axis] + at] += value;
  });
  matrices.mass = make_sparse(local, std::move(mass));
  return matrices;
}

PetscMatrix shifted_stiffness(const Matrices& matrices, double shift) {
  PetscMatrix shifted;
  require_assembly(MatDuplicate(matrices.stiffness.get(), MAT_COPY_VALUES, shifted.out()));
  // The pattern of M is a subset of that of K.
  require_assembly(MatAXPY(shifted.get(), -shift, matrices.mass.get(), SUBSET_NONZERO_PATTERN));
  return shifted;
}

}  // namespace tremolo
