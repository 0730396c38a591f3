// A small body for tests of the reference.
#pragma once

#include <memory>
#include <random>

#include "precompute/reference/full/full_order_solver.h"
#include "precompute/system/failure.h"
#include "tests/support/meshes/box_mesh.h"

namespace tremolo::testing {

// A problem as load_problem would make it of a box.
inline Problem box_problem(const std::array<int, 3>& cells, const Eigen::Vector3d& size,
                           const Material& material) {
  Problem problem;
  problem.mesh = box_mesh(cells, size);
  problem.report = unwrap(check_mesh(problem.mesh));
  problem.materials = {{{"default", material}}, {}};
  return problem;
}

// Held where x = 0.
inline Problem bar_problem(const Material& material = {2e5, 0.3, 1000.0}) {
  Problem problem = box_problem({4, 1, 2}, {0.4, 0.05, 0.1}, material);
  problem.fixed = vertices_on_plane(problem.mesh, 0, 0.0);
  return problem;
}

inline Material wood() {
  Material material;
  material.density = 700.0;
  material.orthotropic = OrthotropicElasticity{{3e5, 1e5, 0.8e5},
                                               {0.3, 0.25, 0.1},
                                               {0.6e5, 0.4e5, 0.5e5},
                                               unwrap(material_axes({1, 0.3, 0}, {0, 1, 0.5}))};
  return material;
}

// A body with its solver and its system; none of them moves.
struct ReferenceBody {
  Problem problem;
  FullOrder body;
  FullOrderSolver solver;
  SecondOrderSystem system;

  explicit ReferenceBody(Problem given, MassKind kind = MassKind::kConsistent, unsigned threads = 1)
      : problem(std::move(given)), body(make_full_order(problem, kind, threads)) {
    solver.body = &body;
    system = make_system(solver);
  }
  ReferenceBody(const ReferenceBody&) = delete;
  ReferenceBody& operator=(const ReferenceBody&) = delete;

  Vector random(double size, unsigned seed) const {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> uniform(-size, size);
    Vector x(body.size());
    for (double& value : x) value = uniform(engine);
    return x;
  }
  // A force of (0, 0, newton) shared by the vertices where x is largest.
  Vector tip_load(double newton) const {
    const double end = bounding_box(problem.mesh.vertices).high.x();
    const std::vector<VertexId> ids = vertices_on_plane(problem.mesh, 0, end);
    const double share = newton / static_cast<double>(ids.size());
    return point_load(body, {ids, std::vector<Eigen::Vector3d>(ids.size(), {0, 0, share})});
  }
};

// A pressure-like load: traction (Pa) on the faces of the boundary that lie on a plane across an
// axis, to the vertices by equal thirds, which is consistent.
inline DefaultLoad traction_load(const TetMesh& mesh, int axis, double value,
                                 const Eigen::Vector3d& traction) {
  DefaultLoad load;
  for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v) {
    load.vertices.push_back(v);
    load.forces.push_back(Eigen::Vector3d::Zero());
  }
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (std::size_t out = 0; out < 4; ++out) {
      const Triangle face = {tet[(out + 1) % 4], tet[(out + 2) % 4], tet[(out + 3) % 4]};
      bool on = true;
      for (VertexId v : face) on = on && std::abs(mesh.vertices[v][axis] - value) < 1e-9;
      if (!on) continue;
      const Eigen::Vector3d a = mesh.vertices[face[1]] - mesh.vertices[face[0]];
      const Eigen::Vector3d b = mesh.vertices[face[2]] - mesh.vertices[face[0]];
      for (VertexId v : face) load.forces[v] += a.cross(b).norm() / 6.0 * traction;
    }
  return load;
}

}  // namespace tremolo::testing
