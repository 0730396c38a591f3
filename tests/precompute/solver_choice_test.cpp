// The choice of the solver, and the solver that needs no factor.
#include <gtest/gtest.h>

#include "common/mesh/mesh_check.h"
#include "precompute/problem/rigid_motion.h"
#include "precompute/ranks/halo.h"
#include "precompute/reduction/derivatives.h"
#include "precompute/solver/sparse_cholesky.h"
#include "precompute/system/failure.h"
#include "tests/support/meshes/box_mesh.h"
#include "tests/support/solved_pencil.h"

namespace tremolo {
namespace {

using testing::box_mesh;
using testing::vertices_on_plane;

struct ChosenSystem {
  TetMesh mesh;
  MeshReport report;
  DofMap map;
  LocalDofs local;
  Solid solid;
  Matrices matrices;
  Columns rigid;

  ChosenSystem(const std::array<int, 3>& cells, bool clamped)
      : mesh(box_mesh(cells, {1.0, 0.21, 0.26})),
        report(*check_mesh(mesh)),
        map(make_dof_map(mesh, clamped ? vertices_on_plane(mesh, 0, 0.0) : std::vector<VertexId>{},
                         1)),
        local(local_dofs(mesh, map, 0)),
        solid(make_solid(mesh, {1e6, 0.3, 1100.0})),
        matrices(assemble(solid, map, local, MassKind::kConsistent)),
        rigid(clamped ? Columns(local.dofs(), 0)
                      : rigid_modes(mesh, report.part_of_vertex, 1, local, matrices.mass.get())) {}

  std::vector<Eigen::Vector3d> positions() const {
    std::vector<Eigen::Vector3d> x;
    for (const int v : map.vertex_of_node) x.push_back(mesh.vertices[v]);
    return x;
  }
};

TEST(SolverChoice, TheFactorIsAsLargeAsForetold) {
  for (const std::array<int, 3>& cells : {std::array{40, 3, 3}, {20, 8, 7}, {12, 12, 12}}) {
    const ChosenSystem system(cells, true);
    const SparseCholesky factor(sparse_rows(system.matrices.stiffness.get()));
    EXPECT_NEAR(count_factor_entries(system.map), static_cast<double>(factor.entries()),
                0.2 * static_cast<double>(factor.entries()));
  }
}

TEST(SolverChoice, GoesByTheMemoryThereIs) {
  const ChosenSystem system({12, 12, 12}, true);
  SolverRequest request;
  request.linear_modes = 4;
  request.modes = 8;
  const SolverChoice rich = choose_solver(system.map, system.local, request);
  EXPECT_EQ(rich.solver, LinearSolver::kCholmod);
  EXPECT_GT(rich.estimate.direct(), rich.estimate.iterative());
  request.memory = 0.5 * (rich.estimate.direct() + rich.estimate.iterative());
  EXPECT_EQ(choose_solver(system.map, system.local, request).solver, LinearSolver::kIterative);
  request.solver = LinearSolver::kMumps;
  EXPECT_EQ(choose_solver(system.map, system.local, request).solver, LinearSolver::kMumps);
  EXPECT_NE(choose_solver(system.map, system.local, request).reason.find("MAY RUN OUT"),
            std::string::npos);
}

TEST(SolverChoice, SaysWhatWouldFitWhenNothingDoes) {
  const ChosenSystem system({12, 12, 12}, true);
  SolverRequest request;
  request.linear_modes = request.modes = 60;
  SolverRequest less = request;
  less.linear_modes = 20;
  request.memory = choose_solver(system.map, system.local, less).estimate.iterative();
  try {
    choose_solver(system.map, system.local, request);
    FAIL() << "it fits";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.error().kind, ErrorKind::kSystem);
    EXPECT_NE(failure.error().message.find("--linear-modes 20 would fit"), std::string::npos)
        << failure.error().message;
  }
}

TEST(Iterative, ModesAndDerivativesAreThoseOfAFactor) {
  for (const bool clamped : {true, false}) {
    const ChosenSystem system({10, 3, 4}, clamped);
    const double shift = clamped ? 0.0 : -200.0;
    testing::SolvedPencil factor(system.matrices, system.rigid, shift);
    testing::SolvedPencil multigrid(system.matrices, system.rigid, shift, 1,
                                    LinearSolver::kIterative, system.positions());
    const Modes direct = factor.modes(6);
    const Modes iterated = multigrid.modes(6);
    const Columns mass_direct = multiply(system.matrices.mass.get(), direct.vectors);
    for (int i = 0; i < 6; ++i)
      EXPECT_NEAR(iterated.squared_frequencies[i], direct.squared_frequencies[i],
                  1e-11 * direct.squared_frequencies[i]);
    EXPECT_LE(iterated.residuals.maxCoeff(), 1e-7);
    const Columns outside =
        iterated.vectors - direct.vectors * inner_products(mass_direct, iterated.vectors);
    EXPECT_LE(std::sqrt(inner_products(outside, multiply(system.matrices.mass.get(), outside))
                            .diagonal()
                            .maxCoeff()),
              1e-7);
    if (!clamped) {
      const Columns mass_rigid = multiply(system.matrices.mass.get(), system.rigid);
      EXPECT_LE(inner_products(mass_rigid, iterated.vectors).cwiseAbs().maxCoeff(), 1e-9);
    }
    // The same modes, so that the derivatives are those of the same loads.
    const BasisRows psi = expand_to_vertices(system.map, system.local, direct.vectors);
    const ModalDerivatives expected = modal_derivatives(system.solid, system.local, factor.pencil,
                                                        *factor.solver, direct.vectors, psi);
    const ModalDerivatives found = modal_derivatives(system.solid, system.local, multigrid.pencil,
                                                     *multigrid.solver, direct.vectors, psi);
    EXPECT_LE((found.vectors() - expected.vectors()).norm(), 1e-9 * expected.vectors().norm());
    EXPECT_LE(found.residual, 1e-8);
  }
}

}  // namespace
}  // namespace tremolo
