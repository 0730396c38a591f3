#include "precompute/problem/element_order.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "common/mesh/mesh_check.h"
#include "common/text.h"
#include "precompute/problem/wall_layers.h"
#include "precompute/system/failure.h"

namespace tremolo {
namespace {

// Part of an edge's length by which its point may lie off its middle without a word.
constexpr double kStraight = 1e-6;
// This is the bound for the most curved edge that is straightened: half a circle. What lies farther
// off is no point of its edge.
constexpr double kMostCurved = 0.5;

// The number of tetrahedra after refinement.
std::size_t refined_count(const ElementRequest& request, const TetMesh& mesh) {
  return mesh.tetrahedra.size() << (3 * request.refine);
}

void merge_into(std::vector<VertexId>& ids, const std::vector<VertexId>& more) {
  std::vector<VertexId> merged;
  std::set_union(ids.begin(), ids.end(), more.begin(), more.end(), std::back_inserter(merged));
  ids = std::move(merged);
}

// The most curved edge of a file, and how far its point lies off the middle, in edge lengths.
struct Curvature {
  MeshEdge edge;
  double share = 0;
};
Curvature most_curved(const TetMesh& mesh) {
  Curvature most;
  for (const MeshEdge& edge : mesh.edges) {
    const Eigen::Vector3d &a = mesh.vertices[edge.a], &b = mesh.vertices[edge.b];
    const double off = (mesh.vertices[edge.point] - 0.5 * (a + b)).norm() / (b - a).norm();
    if (off > most.share) most = {edge, off};
  }
  return most;
}

void refuse_misplaced(const Curvature& most) {
  if (most.share <= kMostCurved) return;
  throw Failure(content_error(
      text("vertex %d stands for the edge between vertices %d and %d, but lies %.3g of its lengths "
           "off its middle: expected the points of edges on their edges, at most %g off",
           most.edge.point, most.edge.a, most.edge.b, most.share, kMostCurved)));
}

// Linear elements for a mesh of many tetrahedra, unless they bend too badly: one layer of them
// across a wall is too stiff by a multiple. Adds a note.
void choose_order_of_many(const ElementRequest& elements, Problem& problem) {
  constexpr double kFewLayers = 1.5;
  const std::optional<WallLayers> walls = find_wall_layers(problem.mesh);
  const double layers = walls ? std::ldexp(walls->layers, elements.refine) : kFewLayers;
  const std::string many = std::to_string(kMostAutomaticQuadratic) + " tetrahedra";
  if (layers >= kFewLayers) {
    problem.notes.push_back("linear elements, as the mesh has more than " + many +
                            "; --order 2 makes them quadratic");
    return;
  }
  problem.order = 2;
  problem.notes.push_back(text(
      "quadratic elements, although the mesh has more than %s: its thinnest walls, %.3g m, are "
      "%.2g layers thick, and one layer of linear tetrahedra is far too stiff in bending. "
      "Fewer elements that are long along the wall are as accurate and much faster: an extruded "
      "mesh, as of tremolo.box() in Python (docs/meshes.md). --order 1 makes them linear",
      many.c_str(), walls->thickness, layers));
}

}  // namespace

int choose_order(const ElementRequest& request, bool imported, const TetMesh& mesh) {
  const bool lumped = request.mass == MassKind::kLumped;
  const auto refuse = [](const char* what) { throw Failure({ErrorKind::kUsage, what}); };
  if (request.order == 2 && lumped)
    refuse(
        "--order 2 with --mass lumped: quadratic elements have no lumped mass; leave out one of "
        "them");
  if (request.order == 2 && imported)
    refuse("--order 2 with --import-basis: VegaFEM's bases are of linear elements");
  if (request.order) return *request.order;
  if (lumped || imported) return 1;
  const bool small = refined_count(request, mesh) <= kMostAutomaticQuadratic;
  return !mesh.edges.empty() || small ? 2 : 1;
}

void prepare_edges(const ProblemRequest& request, Problem& problem) {
  TetMesh& mesh = problem.mesh;
  const ElementRequest& elements = request.elements;
  problem.order = choose_order(elements, request.imported, mesh);
  problem.subdivide = elements.subdivide;
  const bool automatic = !elements.order && elements.mass != MassKind::kLumped && !request.imported;
  if (automatic && problem.order == 1) choose_order_of_many(elements, problem);
  if (mesh.edges.empty()) return;
  const Curvature most = most_curved(mesh);
  const std::size_t curved = unwrap(straighten_edges(mesh, kStraight));
  if (problem.order == 1) {
    const std::size_t removed = remove_edge_points(mesh);
    std::vector<int>& labels = problem.report.part_of_vertex;
    labels = mesh_parts(mesh).part_of_vertex;
    problem.notes.push_back("--order 1: the file's " + std::to_string(removed) +
                            " edge points are left out, the other vertices are renumbered");
  } else if (curved > 0) {
    refuse_misplaced(most);
    problem.notes.push_back(text(
        "%zu of %zu edges of the file are curved, by up to %.2g %% of their length (vertex %d): "
        "they are straightened, as elements have straight edges here",
        curved, mesh.edges.size(), 100.0 * most.share, most.edge.point));
  }
}

void add_edge_points(Problem& problem) {
  if (problem.order == 1) return;
  TetMesh& mesh = problem.mesh;
  unwrap(add_edge_points(mesh));
  std::vector<int>& part = problem.report.part_of_vertex;
  part.resize(mesh.vertices.size(), -1);
  for (const MeshEdge& edge : mesh.edges) part[edge.point] = part[edge.a];
  const std::vector<VertexId> fixed = problem.fixed;
  if (!fixed.empty())
    merge_into(problem.fixed, held_edge_points(mesh, fixed, problem.by_place.fixed));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (problem.held[axis].empty()) continue;
    std::vector<VertexId> held = problem.held[axis], placed = problem.by_place.along[axis];
    merge_into(held, fixed);
    merge_into(placed, problem.by_place.fixed);
    merge_into(problem.held[axis], held_edge_points(mesh, held, placed));
  }
}

}  // namespace tremolo
