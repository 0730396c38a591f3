// Finds defects of a surface and repairs those with a unique repair. CGAL's
// orient_to_bound_a_volume() makes every inner shell a cavity; here an inner shell with the same
// orientation as the shell around it is superfluous and left out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/mesh/render_surface.h"
#include "common/mesh/surface_mesh.h"

namespace tremolo {

// Counts of triangles unless said otherwise. The first group has been repaired, the second remains.
struct SurfaceFindings {
  std::size_t triangles = 0;  // as given
  std::size_t welded = 0;     // vertices at the position of another
  std::size_t degenerate = 0;
  std::size_t repeated = 0;
  std::size_t cancelled = 0;  // back to back with another: both were taken out
  std::size_t turned = 0;     // of the given triangles, those whose orientation was reversed
  std::size_t united = 0;     // closed shells that overlapped or touched

  std::size_t holes = 0;            // closed chains of edges with one triangle
  double hole_share = 0;            // area of the flattest caps over that of the surface
  std::size_t branching_edges = 0;  // edges with three triangles or more
  std::size_t hinges = 0;           // of these, edges along which closed bodies touch
  std::size_t one_sided_edges = 0;  // where a sheet cannot be oriented, as on a Moebius strip
  std::size_t crossings = 0;        // pairs of triangles
  std::size_t shells = 0;           // parts that are connected by edges
  std::size_t inner_shells = 0;     // inside another one and oriented like it: no cavity
  std::size_t cavities = 0;
  double open_share = 0;  // area of shells that have a hole over the whole area

  // True if the surface is closed and free of crossings, so that no solid angle is needed.
  bool clean() const {
    return holes == 0 && branching_edges == 0 && one_sided_edges == 0 && crossings == 0;
  }
};

// A repaired surface without repeated vertices and degenerate triangles, oriented outwards where
// possible. shell_of: one per triangle.
struct RepairedSurface {
  SurfaceMesh mesh;
  std::vector<std::size_t> shell_of;
  std::vector<char> turned;  // one per given triangle: 1 if its orientation was reversed
  SurfaceFindings findings;
};

// `surface` is best scaled so that its bounding box has a diagonal of 1: lengths below 3e-5 may be
// closed as gaps. Inner shells are taken out, cavities stay. object_of: one per triangle, or none;
// objects that touch each other are told apart by it.
RepairedSurface repair_surface(const SurfaceMesh& surface,
                               const std::vector<std::uint32_t>& object_of = {});

// One sentence for each finding, "welded 120 vertices"; none for a valid surface.
std::vector<std::string> describe(const SurfaceFindings& findings);

}  // namespace tremolo
