#include "precompute/budget/refined_problem.h"

#include "common/mesh/mesh_parts.h"
#include "common/mesh/refined_mesh.h"
#include "precompute/problem/element_order.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// Adds the middles of edges between two of these vertices.
void add_middles(const TetMesh& mesh, std::vector<VertexId>& ids) {
  std::vector<bool> chosen(mesh.vertices.size(), false);
  for (const VertexId v : ids) chosen[v] = true;
  for (const MeshEdge& edge : mesh.edges)
    if (chosen[edge.a] && chosen[edge.b]) chosen[edge.point] = true;
  ids.clear();
  for (std::size_t v = 0; v < chosen.size(); ++v)
    if (chosen[v]) ids.push_back(static_cast<VertexId>(v));
}

}  // namespace

Problem refined_problem(const Problem& problem) {
  Problem coarse = problem;
  coarse.order = 2;
  if (problem.order == 1) add_edge_points(coarse);
  Problem fine;
  fine.mesh = refined_mesh(coarse.mesh);
  fine.order = problem.order;
  fine.fixed = coarse.fixed;
  fine.held = coarse.held;
  fine.by_place = problem.by_place;
  add_middles(coarse.mesh, fine.by_place.fixed);
  for (std::vector<VertexId>& along : fine.by_place.along) add_middles(coarse.mesh, along);
  fine.free_body = problem.free_body;
  fine.load = problem.load;
  fine.materials.materials = problem.materials.materials;
  for (const std::int32_t of : problem.materials.of_tet)
    fine.materials.of_tet.insert(fine.materials.of_tet.end(), 8, of);
  fine.point_masses = problem.point_masses;
  MeshParts parts = mesh_parts(fine.mesh);
  fine.report.parts = parts.count;
  fine.report.part_of_vertex = std::move(parts.part_of_vertex);
  add_edge_points(fine);
  return fine;
}

}  // namespace tremolo
