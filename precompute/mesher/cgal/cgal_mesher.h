// Recipe -> tetrahedral mesh, by CGAL's Mesh_3.
#pragma once

#include "assets/recipes/recipe.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "precompute/mesher/cgal/refinement_watch.h"
#include "precompute/mesher/cgal/sliver_repair.h"

namespace tremolo {

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

}  // namespace tremolo
