// A body with everything up to its matrices.
#pragma once

#include "common/mesh/mesh_check.h"
#include "precompute/fem/matrices.h"

namespace tremolo::testing {

struct AssembledBody {
  TetMesh mesh;
  MeshReport report;
  std::vector<VertexId> fixed;
  DofMap map;
  LocalDofs local;
  Solid solid;
  Matrices matrices;

  AssembledBody(TetMesh source, const MaterialTable& table, std::vector<VertexId> held,
                std::vector<double> point_mass = {}, MassKind kind = MassKind::kConsistent)
      : mesh(std::move(source)),
        report(*check_mesh(mesh)),
        fixed(std::move(held)),
        map(make_dof_map(mesh, fixed, 1)),
        local(local_dofs(mesh, map, 0)),
        solid(make_solid(mesh, table)) {
    solid.point_mass = std::move(point_mass);
    matrices = assemble(solid, map, local, kind);
  }
  Eigen::MatrixXd dense(const PetscMatrix& matrix) const {
    return multiply(matrix.get(), Eigen::MatrixXd::Identity(local.dofs(), local.dofs()));
  }
};

}  // namespace tremolo::testing
