// A closed surface without crossings -> tetrahedral mesh, by CGAL's Mesh_3.
#pragma once

#include <functional>

#include "common/mesh/surface_mesh.h"
#include "common/mesh/tet_mesh.h"
#include "common/result.h"
#include "precompute/mesher/cgal/refinement_watch.h"
#include "precompute/mesher/surface/triangle_tree.h"

namespace tremolo {

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
