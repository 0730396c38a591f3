#include <span>
#include <string>
#include <utility>

#include "common/hash.h"
#include "common/mesh/edge_points.h"
#include "common/mesh/mesh_check.h"
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

void refine(int times, unsigned threads, Problem& problem) {
  if (times == 0) return;
  for (int n = 0; n < times; ++n) {
    Problem fine = refined_problem(problem);
    problem.mesh = std::move(fine.mesh);
    problem.fixed = std::move(fine.fixed);
    problem.held = std::move(fine.held);
    problem.by_place = std::move(fine.by_place);
    problem.materials = std::move(fine.materials);
    problem.report.part_of_vertex = std::move(fine.report.part_of_vertex);
  }
  const std::string name = problem.mesh_hash + " refined " + std::to_string(times);
  problem.mesh_hash = hash_text(hash_bytes(std::as_bytes(std::span(name))));
  if (problem.render) problem.embedding = embed_surface(*problem.render, problem.mesh, threads);
  problem.notes.push_back("--refine " + std::to_string(times) + ": " +
                          std::to_string(problem.mesh.tetrahedra.size()) +
                          " tetrahedra; what selectors chose on the mesh as it is given holds");
}

}  // namespace tremolo
