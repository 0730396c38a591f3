#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "common/mesh/mesh_quality.h"
#include "common/mesh/point_cells.h"
#include "common/text.h"
#include "precompute/mesher/cgal/cgal_mesher.h"
#include "precompute/mesher/surface/surface_geometry.h"
#include "precompute/mesher/surface_plan.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

constexpr double kCountTolerance = 0.1;
constexpr int kTries = 6;
// Where the walls are lost, numbers up to so many times that requested are tried, or up to one that
// takes some ten seconds.
constexpr double kMostOver = 4, kOftenAffordable = 60'000;
// An edge is sharp if the surface bends by more degrees there.
constexpr double kSharp = 45.0;
// Sharp edges are kept if they are few: length times size over area.
constexpr double kMostSharp = 1.2;
// Queries that a mesh of so many tetrahedra may make: of the size, where 4 a tetrahedron are usual,
// and of the side of the solid's border, where up to 80 are.
constexpr double kSizesPerTet = 20, kSizesAtLeast = 2e5;
constexpr double kSidesPerTet = 80, kSidesAtLeast = 1e6;
// Queries about facets, where 10 a tetrahedron are usual, and vertices.
constexpr double kStepsPerTet = 200, kStepsAtLeast = 2e6;
constexpr double kVerticesPerTet = 0.25;
// Vertices that a surface rough below its size may take, over those expected, and at least.
constexpr double kMostVertices = 2, kVerticesAtLeast = 25'000;
// Budgets of the second and the last attempt by solid angle, over that of the first, and the least
// factor by which the tetrahedra of the last one are larger.
constexpr double kSecondQueries = 0.3, kLastQueries = 0.6, kLastSize = 1.4;
// The largest cost of an attempt's queries about the solid (side_cost), about 12 s, and the fewest
// queries per tetrahedron for which an attempt is worth its time.
constexpr double kMostCost = 1.2e9, kFewSidesPerTet = 20;
// Queries a tetrahedron of the last attempt, by which its size is chosen where they are expensive.
constexpr double kLastSidesPerTet = 60;

// The mean cost of a query on which side of the border a point near the surface lies.
double side_cost(const SurfaceSolid& solid) {
  constexpr std::size_t kPoints = 500;
  double sum = 0;
  for (const SurfacePoint& at : spread_points(solid.surface, kPoints))
    sum += static_cast<double>(solid.winding.cost_at(at.point));
  return sum / kPoints;
}

// Points on the border of the solid that keep a distance from each other: 1.2 times the size, less
// on shells that would get only a few.
std::vector<Seed> border_points(const SurfaceSolid& solid, const SizeField& sizes) {
  constexpr double kSpacing = 1.2;
  constexpr double kPoints = 60'000, kCost = 2e8;  // two queries each
  const auto points =
      static_cast<std::size_t>(std::min(kPoints, 0.5 * kCost / std::max(1.0, side_cost(solid))));
  constexpr std::size_t kLeast = 12;
  constexpr double kStep = 1e-4;
  std::vector<Seed> candidates;
  std::vector<std::size_t> shell_of;
  const auto propose = [&](const Point& x, const SurfacePoint& at) {
    candidates.push_back({x, 0.0});
    shell_of.push_back(solid.shell_of[at.triangle]);
  };
  for (const SurfacePoint& at : spread_points(solid.surface, points)) {
    if (solid.half_thickness > 0) {
      for (const double side : {1.0, -1.0}) {
        const Point x = at.point + side * solid.half_thickness * at.normal;
        if (std::abs(solid.tree.nearest(x).distance - solid.half_thickness) <= 1e-9) propose(x, at);
      }
    } else if (solid.closed || (!solid.inside(at.point + kStep * at.normal) &&
                                solid.inside(at.point - kStep * at.normal))) {
      propose(at.point, at);
    }
  }
  std::vector<Seed> kept;
  PointCells cells(kSpacing * sizes.coarsest());
  std::map<std::size_t, std::size_t> count;
  double factor = kSpacing;
  for (int pass = 0; pass < 3; ++pass, factor *= 0.5)
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      std::size_t& here = count[shell_of[i]];
      if (pass > 0 && here >= kLeast) continue;
      const Point& x = candidates[i].point;
      const double apart = factor * sizes.at(x);
      if (!cells.add_if_apart(x, apart)) continue;
      ++here;
      kept.push_back({x, apart});
    }
  return kept;
}

std::size_t budget(const MeshPlan& plan, double a_tet, double at_least) {
  return static_cast<std::size_t>(at_least + a_tet * estimated_count(plan));
}

WatchLimits watch_limits(const MeshPlan& plan) {
  return {.most_steps = budget(plan, kStepsPerTet, kStepsAtLeast),
          .most_vertices = plan.error_asked
                               ? 0
                               : budget(plan, kMostVertices * kVerticesPerTet, kVerticesAtLeast),
          .expected = budget(plan, kVerticesPerTet, 0)};
}

Result<TetMesh> mesh_as_polyhedron(const SurfaceSolid& solid, const MeshPlan& plan,
                                   const SizeField& sizes, std::string& method) {
  PolyhedralRequest request;
  request.size = [&sizes](const Point& x) { return sizes.at(x); };
  request.surface_error = plan.error;
  request.seeds = border_points(solid, sizes);
  request.most_queries = budget(plan, kSizesPerTet, kSizesAtLeast);
  request.watch = watch_limits(plan);
  const double sharp = sharp_length(solid.surface, kSharp);
  std::optional<Result<TetMesh>> with_edges;
  if (sharp > 0 && sharp * plan.coarse < kMostSharp * area(solid.surface)) {
    method = "as a polyhedron, its sharp edges kept";
    request.sharp_angle = kSharp;
    // A cube of 10 000 tetrahedra has 160.
    request.most_on_edges = 1'000 + static_cast<std::size_t>(0.2 * estimated_count(plan));
    with_edges = mesh_polyhedron(solid.surface, solid.tree, request);
    if (*with_edges && mesh_quality(**with_edges).min_dihedral_deg >= kGoodAngle)
      return *with_edges;
  }
  request.sharp_angle = 0;
  Result<TetMesh> smooth = mesh_polyhedron(solid.surface, solid.tree, request);
  const bool better = smooth && (!with_edges || !*with_edges ||
                                 mesh_quality(*smooth).min_dihedral_deg >
                                     mesh_quality(**with_edges).min_dihedral_deg);
  if (better || !with_edges || !*with_edges) {
    method = sharp > 0 ? "as a polyhedron, its sharp edges rounded" : "as a polyhedron";
    return smooth;
  }
  return *with_edges;
}

// Meshes at the requested sizes; if that exceeds or would exceed its budget, without the
// requirement of a two-manifold, and at last with larger tetrahedra, which `method` then says.
// cost: of a query; count: the expected number of tetrahedra.
Result<TetMesh> mesh_in_tries(ImplicitRequest& request, const SizeField& sizes, double cost,
                              double count, std::string& method) {
  const auto most = static_cast<double>(request.most_queries);
  const double affordable = kMostCost / cost;
  if (affordable > kFewSidesPerTet * count) {
    request.most_queries = static_cast<std::size_t>(std::min(most, affordable));
    Result<TetMesh> mesh = mesh_implicit(request);
    if (mesh) return mesh;
    request.manifold = false;
    request.surface_error *= 2.0;
    request.most_queries = static_cast<std::size_t>(kSecondQueries * std::min(most, affordable));
    mesh = mesh_implicit(request);
    if (mesh) return mesh;
  }
  const double factor = std::max(kLastSize, std::cbrt(kLastSidesPerTet * count / affordable));
  request.manifold = false;
  request.surface_error *= factor;
  request.most_queries = static_cast<std::size_t>(std::min(kLastQueries * most, affordable));
  request.size = [&sizes, factor](const Point& x) { return factor * sizes.at(x); };
  method +=
      text(", with tetrahedra %.2g times as large as wanted, since those came to no end", factor);
  return mesh_implicit(request);
}

Result<TetMesh> mesh_as_field(const SurfaceSolid& solid, const MeshPlan& plan,
                              const SizeField& sizes, std::string& method) {
  method = solid.half_thickness > 0 ? "as a sheet of the thickness asked for"
                                    : "by solid angle: inside is where it is above one half";
  ImplicitRequest request;
  request.bounds = bounding_box(solid.surface.vertices);
  const double margin = solid.half_thickness + 0.02;
  request.bounds.low.array() -= margin;
  request.bounds.high.array() += margin;
  request.inside = [&solid](const Point& x) { return solid.inside(x); };
  request.size = [&sizes](const Point& x) { return sizes.at(x); };
  request.surface_error = plan.error;
  for (const Seed& seed : border_points(solid, sizes)) request.first_points.push_back(seed.point);
  request.most_queries = budget(plan, kSidesPerTet, kSidesAtLeast);
  request.watch = watch_limits(plan);
  request.onto_surface = [&](Point& x) {
    const NearestPoint near = solid.tree.nearest(x);
    if (solid.half_thickness > 0) {
      if (!(near.distance > 0)) return false;
      x = near.point + solid.half_thickness * (x - near.point) / near.distance;
      return true;
    }
    // Over a hole the border is no triangle's.
    if (near.distance > 0.25 * sizes.at(x)) return false;
    x = near.point;
    return true;
  };
  return mesh_in_tries(request, sizes, side_cost(solid), estimated_count(plan), method);
}

}  // namespace

bool is_met(double share) {
  return std::abs(share - 1.0) <= kCountTolerance;
}

Result<MeshAttempt> attempt_mesh(const SurfaceSolid& solid, const MeshPlan& plan) {
  const SizeField sizes(bounding_box(solid.surface.vertices), plan.walls, plan.coarse, plan.fine);
  MeshAttempt done;
  if (solid.closed && solid.half_thickness == 0) {
    Result<TetMesh> mesh = mesh_as_polyhedron(solid, plan, sizes, done.method);
    if (mesh && !mesh->tetrahedra.empty()) {
      done.mesh = std::move(*mesh);
      return done;
    }
    // By solid angle such walls become crumbs, after a minute.
    if (has_thin_walls(plan)) return done;
  }
  Result<TetMesh> mesh = mesh_as_field(solid, plan, sizes, done.method);
  if (!mesh) return mesh.error();
  done.mesh = std::move(*mesh);
  return done;
}

// Meshes until the requested number of tetrahedra is met; if it never is, the nearest result is
// used.
Result<MeshAttempt> attempt_mesh_to_count(const SurfaceSolid& solid, MeshPlan plan, int wanted) {
  const auto share_of = [wanted](const MeshAttempt& attempt) {
    return static_cast<double>(attempt.mesh.tetrahedra.size()) / wanted;
  };
  Result<MeshAttempt> best = attempt_mesh(solid, plan);
  if (!best || wanted <= 0) return best;
  double share = share_of(*best);
  for (int i = 1; i < kTries && !is_met(share); ++i) {
    const double factor = share > 0 ? std::clamp(std::cbrt(share), 0.4, 2.5) : 0.5;
    plan.coarse *= factor;
    plan.fine *= factor;
    // Walls that are lost at the requested number ask for far more than that.
    if (best->mesh.tetrahedra.empty() &&
        estimated_count(plan) > std::max(kMostOver * wanted, kOftenAffordable))
      break;
    Result<MeshAttempt> next = attempt_mesh(solid, plan);
    if (!next && best->mesh.tetrahedra.empty()) return next;
    if (!next) break;
    share = share_of(*next);
    if (std::abs(std::log(share)) < std::abs(std::log(share_of(*best)))) best = std::move(next);
  }
  return best;
}

}  // namespace tremolo
