// Recipe, implicit solid or closed surface -> tetrahedral mesh, by CGAL's Mesh_3.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "assets/recipes/recipe.h"
#include "common/mesh/surface_mesh.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {

// Limits of refinement. Time has no influence on the mesh.
struct WatchLimits {
  std::size_t most_steps = 0;     // queries about facets in all; 0: no limit
  std::size_t most_vertices = 0;  // inserted vertices; 0: no limit
  std::size_t expected = 0;       // number of vertices that the mesh is likely to get; 0: unknown
  double seconds =
      5;  // elapsed time until the first line on stderr; it doubles for each further one
};

// Mesh_3 (CGAL 5.5) may query the same facets repeatedly without a new vertex, or insert vertices
// ever closer to a corner whose neighbours increase in number; the watch ends both after a count of
// queries that is the same on every machine.
class RefinementWatch {
 public:
  explicit RefinementWatch(const WatchLimits& limits);

  // Counts one query while the mesh has so many vertices. Throws std::runtime_error beyond the
  // bounds.
  void step(std::size_t vertices) {
    ++steps_;
    if (vertices != vertices_) {
      vertices_ = vertices;
      still_since_ = steps_;
    }
    if ((steps_ & kCheckMask) == 0) check();
  }

  std::uint64_t steps() const { return steps_; }

 private:
  // A mask: the bounds are checked at every 1024th query.
  static constexpr std::uint64_t kCheckMask = 1023;
  void check();

  WatchLimits limits_;
  std::uint64_t steps_ = 0;
  std::uint64_t still_since_ = 0;
  std::size_t vertices_ = 0;
  std::chrono::steady_clock::time_point start_;
  double next_report_;  // s after start_
};

// "meshing: 1200 of about 4000 vertices, 5 s, about 12 s more"
std::string progress_text(std::size_t vertices, std::size_t expected, double seconds);

// Raises the smallest dihedral angles of a mesh by moving vertices. CGAL's perturb_mesh_3() takes
// up to thirty times as long for the same angles.

// Moves a point onto the surface; false if none is close enough.
using OntoSurface = std::function<bool(Eigen::Vector3d&)>;

// Moves the vertices of tetrahedra with a dihedral angle below `wanted` degrees, one at a time and
// only if the smallest angle of all tetrahedra around the vertex grows. Vertices of the boundary
// stay on the surface, and vertices flagged in `held` (one per vertex, or empty) stay in place. The
// mesh must be positively oriented and stays so. The same mesh gives the same result. Returns the
// number of tetrahedra still below.
std::size_t repair_slivers(TetMesh& mesh, const OntoSurface& onto_surface,
                           const std::vector<bool>& held, double wanted);

// A first sample of an implicit surface, for the mesher to start from. Points on the surface (to
// 1e-9 of the bounds' diagonal), no two closer than `spacing` times the requested size there. They
// are the sign changes along the edges of a grid of `cells` cells along the diagonal, so a member
// thinner than a cell may be missed. The same recipe gives the same points.
std::vector<Eigen::Vector3d> surface_points(const Recipe& recipe, double spacing, int cells);

// Delaunay refinement of the implicit solid, then perturbation and exudation of slivers. The same
// recipe gives the same mesh. Errors: kContent if the solid is empty or not in one piece at the
// requested size; kSolver if the mesher fails.
Result<TetMesh> mesh_recipe(const Recipe& recipe);

// The same for any implicit solid. inside: called very often. first_points: on the surface, at
// least one for each of its parts. onto_surface: for the repair of slivers. size: as in Recipe.
struct ImplicitRequest {
  BoundingBox bounds;
  std::function<bool(const Eigen::Vector3d&)> inside;
  std::function<double(const Eigen::Vector3d&)> size;
  double surface_error = 0;
  std::vector<Eigen::Vector3d> first_points;
  OntoSurface onto_surface;
  WatchLimits watch;
  std::size_t most_queries = 0;  // of `inside`, beyond which the mesher gives up
  // CGAL's perturbation of slivers before ours: up to thirty times the time for the same angles.
  bool perturb = false;
  // The boundary must be a two-manifold. This is impossible if the solid touches itself in an edge
  // or a point.
  bool manifold = true;
};

// The mesh may be empty or in several parts. Errors: kSolver if the mesher fails or gives up.
Result<TetMesh> mesh_implicit(const ImplicitRequest& request);

// A closed surface without crossings -> tetrahedral mesh, by CGAL's Mesh_3.

struct Seed {
  Eigen::Vector3d point;  // of the surface
  double apart = 0;       // from the others
};

// A request to the mesher.
struct PolyhedralRequest {
  std::function<double(const Eigen::Vector3d&)> size;  // requested edge length at a point
  double surface_error = 0;                            // requested distance to the surface
  // Degrees: edges at which the surface bends by more are kept as edges of the mesh; 0: none.
  double sharp_angle = 0;
  std::vector<Seed> seeds;       // first points, some on every shell
  std::size_t most_queries = 0;  // of `size`, beyond which the mesher gives up
  WatchLimits watch;
  std::size_t most_on_edges = 0;  // vertices on sharp edges, beyond which it gives up
};

// surface: a closed two-manifold, oriented outwards, without crossings; tree: over it. The same
// input gives the same mesh. Errors: kSolver if the mesher fails or gives up.
Result<TetMesh> mesh_polyhedron(const SurfaceMesh& surface, const TriangleTree& tree,
                                const PolyhedralRequest& request);

// Total length of the edges at which the surface bends by more than `angle` degrees; 0 for one that
// is no two-manifold.
double sharp_length(const SurfaceMesh& surface, double angle);

}  // namespace tremolo
