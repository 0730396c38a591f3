// A file of tetrahedra of two cells, with two materials, a fixed side, a drawn surface and a grid.
#pragma once

#include <string>

#include "common/mesh/surface_mesh.h"
#include "formats/tets/tets_file.h"
#include "tests/support/distance_fields.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo::testing {

inline TetsData small_tets() {
  TetsData data;
  data.mesh = box_mesh({2, 1, 1}, {0.2, 0.1, 0.1});
  Material grained{1e5, 0.3, 900.0};
  OrthotropicElasticity fibres;
  fibres.young = {2e5, 1e5, 1e5};
  fibres.poisson = {0.3, 0.3, 0.15};
  fibres.shear = {4e4, 4e4, 4e4};
  grained.orthotropic = fibres;
  data.materials.materials = {{"plain", {1e5, 0.4, 1000.0}}, {"grained", grained}};
  data.materials.of_tet.assign(data.mesh.tetrahedra.size(), 0);
  data.materials.of_tet.back() = 1;
  data.held = vertices_on_plane(data.mesh, 0, 0.0);
  TetsSurface& drawn = data.surface;
  for (const Eigen::Vector4d& w :
       {Eigen::Vector4d(1, 0, 0, 0), Eigen::Vector4d(0, 1, 0, 0), Eigen::Vector4d(0, 0, 0.5, 0.5),
        Eigen::Vector4d(-0.1, 0.5, 0.3, 0.3)}) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int c = 0; c < 4; ++c) x += w[c] * data.mesh.vertices[data.mesh.tetrahedra[5][c]];
    drawn.vertices.push_back(x);
    drawn.weights.push_back(w);
    drawn.tetrahedra.push_back(5);
    drawn.uvs.push_back(Eigen::Vector2f(0.25F, 0.5F));
  }
  drawn.triangles = {{0, 1, 2}, {1, 3, 2}};
  data.nodes = cube_of_nodes(1.5, 4);
  data.distances = values_at_nodes(data.nodes, sphere_formula(1.0));
  data.provenance = "{\"generator\": \"a test\"}";
  return data;
}

// All of the mesh's boundary is drawn, with its own vertices.
inline TetsSurface drawn_boundary(const TetMesh& mesh) {
  const BoundarySurface boundary = boundary_surface(mesh);
  TetsSurface drawn;
  drawn.triangles = boundary.triangles;
  for (const VertexId v : boundary.vertex_ids) {
    drawn.vertices.push_back(mesh.vertices[v]);
    for (std::uint32_t tet = 0; drawn.tetrahedra.size() < drawn.vertices.size(); ++tet)
      for (int c = 0; c < 4; ++c)
        if (mesh.tetrahedra[tet][c] == v && drawn.tetrahedra.size() < drawn.vertices.size()) {
          drawn.tetrahedra.push_back(tet);
          drawn.weights.push_back(Eigen::Vector4d::Unit(c));
        }
  }
  return drawn;
}

}  // namespace tremolo::testing
