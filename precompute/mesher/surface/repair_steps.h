// The steps of the repair of a surface: weld, orient, unite.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <vector>

#include "common/mesh/surface_mesh.h"
#include "precompute/mesher/surface/surface_repair.h"

namespace tremolo {

// Connects triangles that only touch. CGAL merges equal points. Equal triangles are merged here,
// since merge_duplicate_polygons_in_polygon_soup() changes the order of the others and with it the
// mesh, and so are gaps: stitch_borders() joins only points at the same position.

// A triangle that was taken out, since it has the corners of `first`. Both are given triangles.
struct WeldedTwin {
  std::size_t dropped = 0;
  std::size_t first = 0;
};

struct WeldCounts {
  std::size_t welded = 0;                // vertices at the position of another
  std::size_t degenerate = 0;            // triangles without an area
  std::size_t repeated = 0;              // triangles that were there already
  std::size_t cancelled = 0;             // triangles back to back with another one
  std::vector<std::size_t> origin = {};  // the given triangle that each remaining one is
  std::vector<WeldedTwin> twins = {};
};

// Joins vertices at one position; if edges with a single triangle remain, also vertices closer than
// 3e-5 (less where edges are short), provided that this closes some. Of triangles back to back both
// are removed if that leaves fewer open edges than keeping one of them.
WeldCounts weld(SurfaceMesh& surface);

// Removes the vertices that no triangle uses. The order of the others, and with it the mesh, stays
// as it was; CGAL's remove_isolated_points_in_polygon_soup() swaps the last ones into the gaps.
void drop_unused_vertices(SurfaceMesh& surface);

// An edge of a triangle.
struct SurfaceEdge {
  VertexId low, high;
  std::size_t triangle;
  bool forward;  // from low to high in the triangle's order
  bool operator<(const SurfaceEdge& other) const {
    return std::tie(low, high, triangle) < std::tie(other.low, other.high, other.triangle);
  }
  bool same(const SurfaceEdge& other) const { return low == other.low && high == other.high; }
};

std::vector<SurfaceEdge> sorted_edges(const std::vector<Triangle>& triangles);

// Calls visit(uses) for each edge with a span of its uses, one for each of its triangles.
template <class Visit>
void for_each_edge(const std::vector<SurfaceEdge>& edges, const Visit& visit) {
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t next = i;
    while (next < edges.size() && edges[next].same(edges[i])) ++next;
    visit(std::span(edges).subspan(i, next - i));
    i = next;
  }
}

// Edges with an odd number of triangles.
std::size_t odd_edges(const SurfaceMesh& surface);

// Parts of a surface that are connected by edges, and their orientation. CGAL's
// orient_polygon_soup() orients by the first triangle of a part, not by the larger area, so that
// one reversed triangle makes a cavity a superfluous shell; it also cuts the surface open where a
// sheet is one-sided or three triangles meet; the numbers of both are findings. Its boundary cycles
// are those of a two-manifold.

// Triangles that are connected by edges with exactly two triangles. open: has an edge with one
// triangle. branching: meets others at an edge.
struct SurfacePatch {
  std::vector<std::size_t> triangles;
  bool open = false;
  bool branching = false;
};

// Finds the patches and orients the triangles of each consistently, keeping the file's orientation
// of the larger area. patch_of: one per triangle. Counts the edges where no orientation agrees.
std::vector<SurfacePatch> orient_within_patches(SurfaceMesh& surface,
                                                std::vector<std::size_t>& patch_of,
                                                SurfaceFindings& findings);

// Sets open and branching; counts closed chains of open edges and the area of the flattest caps
// over them, and edges where three triangles or more meet.
void find_holes(const SurfaceMesh& surface, const std::vector<std::size_t>& patch_of,
                std::vector<SurfacePatch>& patches, SurfaceFindings& findings);

// A patch with a boundary, or with an edge where others end, has no inside: the side from which
// rays reach infinity is outside. One that is equally open in front and behind is unchanged.
void orient_open_patches(SurfaceMesh& surface, const std::vector<SurfacePatch>& patches);

// Turns all triangles of a patch: their second and third corner change places.
void turn_patch(SurfaceMesh& surface, const SurfacePatch& patch);

// The volume below a patch, from the origin; negative if it faces inwards.
double signed_volume(const SurfaceMesh& surface, const SurfacePatch& patch);

// Triangles of a surface that run through each other, and shells that overlap: found and united by
// CGAL's exact arithmetic.

// Pairs of triangles that meet elsewhere than in the corners and edges they share. Exact. Every
// edge must belong to one or two triangles that agree on its direction, or the count is 1.
std::size_t count_crossings(const SurfaceMesh& surface);

// The surface of the union of overlapping closed shells; its sharp edges are theirs. shell_of: the
// shell of each triangle, from 0. Nothing if a shell is open, intersects itself or faces inwards,
// if there are more than 200 of them, or if the result is not valid.
std::optional<SurfaceMesh> unite_shells(const SurfaceMesh& surface,
                                        const std::vector<std::size_t>& shell_of);

// Closed bodies that touch or overlap, where they have corners, edges or whole triangles in common,
// so that welding them together leaves edges of three triangles or more.

struct UnitedBodies {
  SurfaceMesh mesh;
  std::size_t bodies = 0;
  WeldCounts counts;         // of all bodies; `origin` and `twins` are empty
  std::vector<char> turned;  // one per given triangle
};

// The union of the bodies of a surface as given. Bodies are the objects, or the parts whose
// triangles use the same vertices; where four triangles or more of one of them meet at an edge,
// those that enclose the inside between them belong together. object_of: one per triangle, or
// none. Nothing if a body is not closed, or for the reasons of unite_shells().
std::optional<UnitedBodies> unite_bodies(const SurfaceMesh& given,
                                         const std::vector<std::uint32_t>& object_of);

// Edges that four triangles or more have in common, as where two closed bodies touch along an edge;
// 0 if there are other edges of more or less than two triangles, or triangles that lie on each
// other at one.
std::size_t count_hinges(const SurfaceMesh& surface);

}  // namespace tremolo
