#include "precompute/mesher/surface/surface_repair.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include "common/mesh/winding_number.h"
#include "precompute/mesher/surface/repair_steps.h"
#include "precompute/mesher/surface/surface_geometry.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

// A closed patch. parent: the smallest shell around it, an index of shells.
struct Shell {
  std::size_t patch = 0;
  BoundingBox box = {};
  double volume = 0;  // over the diagonal cubed; negative if the shell faces inwards
  bool cavity = false;
  std::optional<std::size_t> parent = {};
};

bool contains(const BoundingBox& outer, const BoundingBox& inner) {
  return (outer.low.array() <= inner.low.array()).all() &&
         (outer.high.array() >= inner.high.array()).all();
}

SurfaceMesh part_of(const SurfaceMesh& surface, const SurfacePatch& patch) {
  SurfaceMesh part;
  part.vertices = surface.vertices;
  for (const std::size_t t : patch.triangles) part.triangles.push_back(surface.triangles[t]);
  return part;
}

// The closed patches, the largest one first, and their nesting. CGAL's
// volume_connected_components() accepts neither open patches in addition nor shells that touch.
std::vector<Shell> nested_shells(const SurfaceMesh& surface,
                                 const std::vector<SurfacePatch>& patches) {
  std::vector<Shell> shells;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (patches[p].open || patches[p].branching) continue;
    std::vector<Point> points;
    for (const std::size_t t : patches[p].triangles)
      for (const Point& x : corners(surface, surface.triangles[t])) points.push_back(x);
    shells.push_back({p, bounding_box(points), signed_volume(surface, patches[p])});
  }
  std::sort(shells.begin(), shells.end(),
            [](const Shell& a, const Shell& b) { return std::abs(a.volume) > std::abs(b.volume); });
  for (std::size_t outer = 0; outer < shells.size(); ++outer) {
    std::optional<WindingNumber> winding;
    for (std::size_t inner = outer + 1; inner < shells.size(); ++inner) {
      if (!contains(shells[outer].box, shells[inner].box)) continue;
      if (!winding) winding.emplace(part_of(surface, patches[shells[outer].patch]));
      const std::size_t first = patches[shells[inner].patch].triangles.front();
      const Point x = corners(surface, surface.triangles[first])[0];
      if (std::abs(winding->at(x)) > 0.5) shells[inner].parent = outer;
    }
  }
  return shells;
}

// Orients outermost shells outwards. A shell inside another is a cavity if its orientation in the
// file is opposite to that of the outer one, and superfluous if it is the same.
void settle_closed_shells(SurfaceMesh& surface, const std::vector<SurfacePatch>& patches,
                          SurfaceFindings& findings, std::vector<bool>& dropped) {
  std::vector<Shell> shells = nested_shells(surface, patches);
  for (Shell& shell : shells) {
    const bool inverted = shell.volume < 0;
    if (shell.parent) {
      const Shell& parent = shells[*shell.parent];
      if (dropped[parent.patch])
        dropped[shell.patch] = true;
      else if (inverted == (parent.volume < 0))
        dropped[shell.patch] = !parent.cavity;
      else
        shell.cavity = !parent.cavity;
    }
    if (dropped[shell.patch]) {
      ++findings.inner_shells;
      continue;
    }
    findings.cavities += shell.cavity;
    if (inverted != shell.cavity) turn_patch(surface, patches[shell.patch]);
  }
}

// Closed shells that only cross each other, as one surface of one patch. They are turned outwards
// in `surface`. Nothing if they cannot be united.
std::optional<SurfaceMesh> unite(SurfaceMesh& surface, const std::vector<SurfacePatch>& patches,
                                 const std::vector<std::size_t>& patch_of) {
  SurfaceMesh outwards = surface;
  std::size_t inwards = 0;
  for (const SurfacePatch& patch : patches) {
    if (signed_volume(surface, patch) >= 0) continue;
    ++inwards;
    turn_patch(outwards, patch);
  }
  // Some of each: cavities, perhaps.
  if (inwards > 0 && inwards < patches.size()) return std::nullopt;
  std::optional<SurfaceMesh> united = unite_shells(outwards, patch_of);
  if (united) surface = std::move(outwards);
  return united;
}

// Marks the given triangles that were turned: those of `turned` unlike those of `welded`, in
// counts.origin's order, and their twins.
std::vector<char> turned_triangles(std::size_t given, const std::vector<Triangle>& welded,
                                   const std::vector<Triangle>& turned, const WeldCounts& counts) {
  std::vector<char> result(given, 0);
  for (std::size_t t = 0; t < welded.size(); ++t) result[counts.origin[t]] = welded[t] != turned[t];
  for (const WeldedTwin& twin : counts.twins) result[twin.dropped] = result[twin.first];
  return result;
}

RepairedSurface as_one_body(UnitedBodies united, std::size_t triangles) {
  RepairedSurface result;
  result.findings.triangles = triangles;
  result.findings.welded = united.counts.welded;
  result.findings.degenerate = united.counts.degenerate;
  result.findings.repeated = united.counts.repeated;
  result.findings.cancelled = united.counts.cancelled;
  result.findings.united = united.bodies;
  result.findings.shells = united.bodies;
  result.mesh = std::move(united.mesh);
  result.shell_of.assign(result.mesh.triangles.size(), 0);
  result.turned = std::move(united.turned);
  result.findings.turned = std::count(result.turned.begin(), result.turned.end(), 1);
  return result;
}

}  // namespace

RepairedSurface repair_surface(const SurfaceMesh& given,
                               const std::vector<std::uint32_t>& object_of) {
  RepairedSurface result;
  SurfaceFindings& findings = result.findings;
  SurfaceMesh surface = given;
  findings.triangles = surface.triangles.size();
  const WeldCounts counts = weld(surface);
  findings.welded = counts.welded;
  findings.degenerate = counts.degenerate;
  findings.repeated = counts.repeated;
  findings.cancelled = counts.cancelled;
  result.turned.assign(given.triangles.size(), 0);
  if (surface.triangles.empty()) return result;

  const std::vector<Triangle> welded = surface.triangles;
  std::vector<std::size_t> patch_of;
  std::vector<SurfacePatch> patches = orient_within_patches(surface, patch_of, findings);
  find_holes(surface, patch_of, patches, findings);
  findings.shells = patches.size();
  if (findings.branching_edges == 0 && findings.one_sided_edges == 0)
    findings.crossings = count_crossings(surface);
  std::vector<bool> dropped(patches.size(), false);
  std::optional<SurfaceMesh> united;
  if (findings.crossings == 0)
    settle_closed_shells(surface, patches, findings, dropped);
  else if (findings.holes == 0)
    united = unite(surface, patches, patch_of);
  if (united) {
    findings.united = patches.size();
    findings.crossings = 0;
  }
  if (!findings.clean()) {
    if (findings.branching_edges + findings.repeated + findings.cancelled > 0)
      if (std::optional<UnitedBodies> bodies = unite_bodies(given, object_of))
        return as_one_body(std::move(*bodies), given.triangles.size());
    if (findings.branching_edges > 0) findings.hinges = count_hinges(surface);
    for (SurfacePatch& patch : patches) patch.branching = patch.branching || findings.crossings > 0;
    orient_open_patches(surface, patches);
  }
  result.turned = turned_triangles(given.triangles.size(), welded, surface.triangles, counts);
  findings.turned = std::count(result.turned.begin(), result.turned.end(), 1);
  if (united) {
    surface = std::move(*united);
    patch_of.assign(surface.triangles.size(), 0);
    dropped.assign(1, false);
  }
  result.mesh.vertices = surface.vertices;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    if (dropped[patch_of[t]]) continue;
    result.mesh.triangles.push_back(surface.triangles[t]);
    result.shell_of.push_back(patch_of[t]);
  }
  drop_unused_vertices(result.mesh);
  return result;
}

std::vector<std::string> describe(const SurfaceFindings& f) {
  std::vector<std::string> lines;
  const auto say = [&](std::size_t count, const char* one, const char* many) {
    if (count > 0) lines.push_back(std::to_string(count) + (count == 1 ? one : many));
  };
  say(f.welded, " vertex welded to another at its place",
      " vertices welded to others at their place");
  say(f.degenerate, " triangle without an area left out", " triangles without an area left out");
  say(f.repeated, " repeated triangle left out", " repeated triangles left out");
  say(f.cancelled, "", " triangles that lay back to back in pairs left out: an inner wall");
  say(f.turned, " triangle turned to face outwards", " triangles turned to face outwards");
  say(f.united, "", " bodies that overlap or touch united");
  say(f.inner_shells, " inner shell left out (it faces the same way as the one around it)",
      " inner shells left out (they face the same way as those around them)");
  say(f.cavities, " cavity kept", " cavities kept");
  if (f.holes > 0) {
    char text[160];
    std::snprintf(text, sizeof(text), "%zu hole%s, %.2g %% of the surface: closed by solid angle",
                  f.holes, f.holes == 1 ? "" : "s", 100.0 * f.hole_share);
    lines.emplace_back(text);
  }
  say(f.branching_edges, " edge where three or more triangles meet",
      " edges where three or more triangles meet");
  if (f.hinges > 0)
    lines.push_back("warning: bodies touch along " + std::to_string(f.hinges) +
                    (f.hinges == 1 ? " edge" : " edges") +
                    " only: a few tetrahedra join them there, and how stiff that hinge is depends "
                    "on the mesh. Give the bodies a common face, or move them apart");
  say(f.one_sided_edges, " edge across which no side is the outside",
      " edges across which no side is the outside");
  say(f.crossings, " pair of triangles that cross each other",
      " pairs of triangles that cross each other");
  return lines;
}

}  // namespace tremolo
