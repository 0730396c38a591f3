#include "precompute/problem/model_geometry.h"

#include <algorithm>

#include "precompute/fem/stvk.h"

namespace tremolo {
namespace {

VertexBlock make_block(const TetMesh& mesh, const std::vector<VertexId>& ids) {
  VertexBlock block;
  block.vertex_ids = ids;
  for (const VertexId id : ids) block.rest.push_back(mesh.vertices[id]);
  return block;
}

// True if the drawn boundary of a quadratic mesh uses the edge points.
bool subdivides(const Problem& problem, const BoundarySurface& boundary) {
  if (problem.order == 1) return false;
  return problem.subdivide.value_or(boundary.triangles.size() < kCoarseBoundary);
}

}  // namespace

void add_geometry(const Problem& problem, BasisData& data) {
  const TetMesh& mesh = problem.mesh;
  BoundarySurface boundary = boundary_surface(mesh);
  if (subdivides(problem, boundary)) boundary = subdivided(boundary, mesh);
  std::vector<VertexId> interior;
  for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v)
    if (!std::binary_search(boundary.vertex_ids.begin(), boundary.vertex_ids.end(), v))
      interior.push_back(v);
  data.surface = make_block(mesh, boundary.vertex_ids);
  data.interior = make_block(mesh, interior);
  data.triangles = boundary.triangles;
  if (problem.render)
    data.render =
        RenderBlock{*problem.render, BasisRows(), heaviest_vertices(problem.embedding, mesh), {}};
  data.vertex_count = mesh.vertices.size();
  data.tetrahedron_count = mesh.tetrahedra.size();
  data.fixed_vertices = problem.fixed;
  data.fixed_vertex_count = problem.fixed.size();
  data.load = problem.load;
  data.edges = mesh.edges;
}

void add_elements(const Problem& problem, BasisData& data) {
  const Solid solid = make_solid(problem.mesh, problem.materials);
  data.elements.corners = problem.mesh.tetrahedra;
  data.elements.masses.clear();
  for (std::size_t e = 0; e < solid.elements.size(); ++e)
    data.elements.masses.push_back(solid.density(e) * solid.elements[e].volume);
}

}  // namespace tremolo
