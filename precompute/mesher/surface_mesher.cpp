#include "precompute/mesher/surface_mesher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <optional>
#include <random>

#include "precompute/mesher/cgal_mesher.h"
#include "precompute/mesher/polyhedral_mesher.h"
#include "precompute/mesher/size_field.h"
#include "precompute/mesher/surface_distance.h"
#include "precompute/mesher/triangle_tree.h"
#include "precompute/mesher/winding_number.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

// Everything below is in units of the bounding box's diagonal.
constexpr double kError = 0.003;      // between the surfaces, unless asked
constexpr double kWorstError = 0.01;  // beyond it a finer mesh is tried
constexpr double kDefaultTets = 10'000;
constexpr double kMostTets = 4 * kDefaultTets;  // that thin walls may ask for
constexpr double kCountTolerance = 0.1;
constexpr int kTries = 6;
constexpr std::size_t kWallSamples = 6'000;
constexpr std::size_t kDistanceSamples = 20'000;
constexpr std::size_t kVolumeSamples = 40'000;
// Holes of more than this share of the surface are not closed without being asked to.
constexpr double kMostHoles = 0.12;
// An edge is sharp if the surface bends by more degrees there.
constexpr double kSharp = 45.0;
// Sharp edges are kept if they are few: length times size over area.
constexpr double kMostSharp = 1.2;
constexpr double kGoodAngle = 8.0;
// A part with less than this share of the largest one's volume is a crumb.
constexpr double kCrumb = 0.01;
// Queries of the size or the solid that a mesh of that many tetrahedra may take.
constexpr double kQueriesPerTet = 4'000;
constexpr double kQueriesAtLeast = 4e6;

template <class... Values>
std::string text(const char* format, Values... values) {
  char buffer[400];
  std::snprintf(buffer, sizeof(buffer), format, values...);
  return buffer;
}

struct Scaling {
  Point centre = Point::Zero();
  double diagonal = 1;  // m
  Point in(const Point& x) const { return (x - centre) / diagonal; }
  Point out(const Point& x) const { return diagonal * x + centre; }
};

// The surface with a diagonal of 1 about the origin; vertices that nothing uses do not count.
SurfaceMesh scale(const RenderSurface& given, Scaling& scaling) {
  std::vector<Point> used;
  for (const Triangle& t : given.triangles)
    for (const VertexId v : t) used.push_back(given.vertices[static_cast<std::size_t>(v)]);
  const BoundingBox box = bounding_box(used);
  scaling.centre = 0.5 * (box.low + box.high);
  scaling.diagonal = box.diagonal();
  SurfaceMesh surface;
  surface.triangles = given.triangles;
  if (!(scaling.diagonal > 0)) return surface;
  for (const Point& x : given.vertices) surface.vertices.push_back(scaling.in(x));
  return surface;
}

// The solid that a surface stands for.
struct Solid {
  SurfaceMesh surface;
  TriangleTree tree;
  WindingNumber winding;
  double half_thickness = 0;  // above 0: a sheet

  explicit Solid(SurfaceMesh mesh, double thickness)
      : surface(std::move(mesh)),
        tree(surface),
        winding(surface),
        half_thickness(0.5 * thickness) {}

  bool inside(const Point& x) const {
    if (half_thickness > 0) return tree.nearest(x).distance < half_thickness;
    return winding.at(x) > 0.5;
  }
};

// Share of the surface behind which the solid is.
double backed_share(const Solid& solid) {
  constexpr std::size_t kPoints = 2'000;
  constexpr double kStep = 1e-5;
  std::size_t backed = 0;
  for (const SurfacePoint& at : spread_points(solid.surface, kPoints)) {
    const Point normal =
        doubled_area(solid.surface, solid.surface.triangles[at.triangle]).normalized();
    backed += solid.inside(at.point - kStep * normal);
  }
  return static_cast<double>(backed) / kPoints;
}

double volume(const Solid& solid, bool clean) {
  if (clean) {
    double sum = 0;
    for (const Triangle& t : solid.surface.triangles) {
      const auto at = [&](std::size_t i) -> const Point& {
        return solid.surface.vertices[static_cast<std::size_t>(t[i])];
      };
      sum += at(0).dot(at(1).cross(at(2))) / 6.0;
    }
    return sum;
  }
  const BoundingBox box = bounding_box(solid.surface.vertices);
  const Point low = box.low.array() - solid.half_thickness;
  const Point high = box.high.array() + solid.half_thickness;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::size_t hits = 0;
  for (std::size_t i = 0; i < kVolumeSamples; ++i) {
    const Point share(uniform(random), uniform(random), uniform(random));
    hits += solid.inside(low + share.cwiseProduct(high - low));
  }
  return (high - low).prod() * static_cast<double>(hits) / kVolumeSamples;
}

struct Plan {
  std::vector<WallSample> walls;
  double volume = 0;
  double coarse = 0;
  double fine = 0;
  double error = kError;
};

double median_thickness(const std::vector<WallSample>& walls) {
  std::vector<double> values;
  for (const WallSample& wall : walls) values.push_back(wall.thickness);
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The largest size with which walls of at least that size are cut into no more than `most`.
double fine_enough(const Plan& plan, double most) {
  double low = 0.02 * plan.coarse, high = plan.coarse;
  if (estimated_count(plan.walls, plan.volume, plan.coarse, low) <= most) return low;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (estimated_count(plan.walls, plan.volume, plan.coarse, middle) > most ? low : high) = middle;
  }
  return high;
}

double thinner_share(const std::vector<WallSample>& walls, double bound) {
  std::size_t count = 0;
  for (const WallSample& wall : walls) count += wall.thickness < bound;
  return walls.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(walls.size());
}

Result<Plan> make_plan(const Solid& solid, bool clean, const SurfaceMeshOptions& options,
                       const Scaling& scaling) {
  Plan plan;
  plan.volume = volume(solid, clean);
  if (solid.half_thickness > 0) {
    // A sheet is as thick as it was asked to be.
    for (const SurfacePoint& at : spread_points(solid.surface, kWallSamples))
      plan.walls.push_back({at.point, 2.0 * solid.half_thickness, 1.0});
  } else {
    const Inside inside =
        clean ? Inside() : Inside([&solid](const Point& x) { return solid.inside(x); });
    plan.walls = wall_samples(solid.surface, solid.tree, inside, kWallSamples);
  }
  const double wanted = options.tets > 0 ? options.tets : kDefaultTets;
  const double most = options.tets > 0 ? 1.5 * options.tets : kMostTets;
  if (options.size > 0) {
    plan.coarse = options.size / scaling.diagonal;
    plan.fine = 0.25 * plan.coarse;
  } else {
    plan.coarse = size_for_count(plan.volume, wanted);
    plan.fine = fine_enough(plan, most);
  }
  plan.error = options.error > 0 ? options.error / scaling.diagonal
                                 : std::clamp(0.05 * plan.coarse, kError, 0.1);
  if (options.size > 0 || options.tets > 0) return plan;
  // Cut with edges of three times their thickness, walls still bend; beyond, the angles are bad.
  if (thinner_share(plan.walls, plan.fine / 3.0) > 0.1) {
    const double thin = median_thickness(plan.walls);
    return content_error(
        text("its walls are about %.3g m thick at a size of %.3g m: about %.1g tetrahedra would be "
             "needed "
             "for good ones. Make the walls thicker, or ask for that many by --tets or for their "
             "size by "
             "--size",
             thin * scaling.diagonal, scaling.diagonal,
             estimated_count(plan.walls, plan.volume, plan.coarse, thin)));
  }
  return plan;
}

// Points that keep a distance from each other, on the border of the solid.
std::vector<Point> border_points(const Solid& solid, const SizeField& sizes, bool clean) {
  constexpr double kSpacing = 1.2;
  constexpr std::size_t kPoints = 60'000;
  constexpr double kStep = 1e-4;
  std::vector<Point> kept;
  // The coarsest size is as wide as a cell, so only neighbours count.
  const double width = kSpacing * sizes.at(Point::Constant(10.0));
  std::map<std::array<int, 3>, std::vector<std::size_t>> cells;
  for (const SurfacePoint& at : spread_points(solid.surface, kPoints)) {
    Point x = at.point;
    const Point normal =
        doubled_area(solid.surface, solid.surface.triangles[at.triangle]).normalized();
    if (solid.half_thickness > 0) {
      x += solid.half_thickness * normal;
      if (std::abs(solid.tree.nearest(x).distance - solid.half_thickness) > 1e-9) continue;
    } else if (!clean && (solid.inside(x + kStep * normal) || !solid.inside(x - kStep * normal))) {
      continue;
    }
    const double apart = kSpacing * sizes.at(x);
    const Eigen::Array3i cell = (x / width).array().floor().cast<int>();
    bool free = true;
    for (int i = 0; i < 27 && free; ++i) {
      const auto near =
          cells.find({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
      if (near == cells.end()) continue;
      for (const std::size_t other : near->second)
        if ((kept[other] - x).squaredNorm() < apart * apart) {
          free = false;
          break;
        }
    }
    if (!free) continue;
    cells[{cell[0], cell[1], cell[2]}].push_back(kept.size());
    kept.push_back(x);
  }
  return kept;
}

std::size_t query_budget(const Plan& plan) {
  return static_cast<std::size_t>(
      kQueriesAtLeast +
      kQueriesPerTet * estimated_count(plan.walls, plan.volume, plan.coarse, plan.fine));
}

Result<TetMesh> mesh_as_polyhedron(const Solid& solid, const Plan& plan, const SizeField& sizes,
                                   std::string& method) {
  PolyhedralRequest request;
  request.size = [&sizes](const Point& x) { return sizes.at(x); };
  request.surface_error = plan.error;
  request.seeds = border_points(solid, sizes, true);
  request.most_queries = query_budget(plan);
  double area = 0;
  for (const Triangle& t : solid.surface.triangles)
    area += 0.5 * doubled_area(solid.surface, t).norm();
  const double sharp = sharp_length(solid.surface, kSharp);
  std::optional<Result<TetMesh>> with_edges;
  if (sharp > 0 && sharp * plan.coarse < kMostSharp * area) {
    method = "as a polyhedron, its sharp edges kept";
    request.sharp_angle = kSharp;
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

Result<TetMesh> mesh_as_field(const Solid& solid, const Plan& plan, const SizeField& sizes) {
  ImplicitRequest request;
  request.bounds = bounding_box(solid.surface.vertices);
  const double margin = solid.half_thickness + 0.02;
  request.bounds.low.array() -= margin;
  request.bounds.high.array() += margin;
  request.inside = [&solid](const Point& x) { return solid.inside(x); };
  request.size = [&sizes](const Point& x) { return sizes.at(x); };
  request.surface_error = plan.error;
  request.first_points = border_points(solid, sizes, false);
  request.most_queries = 10 * query_budget(plan);
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
  return mesh_implicit(request);
}

struct Attempt {
  TetMesh mesh;
  std::string method;
};

Result<Attempt> attempt(const Solid& solid, bool clean, const Plan& plan) {
  const SizeField sizes(bounding_box(solid.surface.vertices), plan.walls, plan.coarse, plan.fine);
  Attempt done;
  if (clean && solid.half_thickness == 0) {
    Result<TetMesh> mesh = mesh_as_polyhedron(solid, plan, sizes, done.method);
    if (mesh && !mesh->tetrahedra.empty()) {
      done.mesh = std::move(*mesh);
      return done;
    }
  }
  Result<TetMesh> mesh = mesh_as_field(solid, plan, sizes);
  if (!mesh) return mesh.error();
  done.mesh = std::move(*mesh);
  done.method = solid.half_thickness > 0 ? "as a sheet of the thickness asked for"
                                         : "by solid angle: inside is where it is above one half";
  return done;
}

// Meshes until the number of tetrahedra asked for is met.
Result<Attempt> attempt_to_count(const Solid& solid, bool clean, Plan plan, int wanted) {
  Result<Attempt> best = attempt(solid, clean, plan);
  for (int i = 1; i < kTries && wanted > 0 && best; ++i) {
    const double share = static_cast<double>(best->mesh.tetrahedra.size()) / wanted;
    if (share > 0 && std::abs(share - 1.0) <= kCountTolerance) break;
    const double factor = share > 0 ? std::clamp(std::cbrt(share), 0.4, 2.5) : 0.5;
    plan.coarse *= factor;
    plan.fine *= factor;
    best = attempt(solid, clean, plan);
  }
  return best;
}

// Keeps the parts of a mesh that are not crumbs; says how many there were.
struct Parts {
  std::size_t kept = 0, dropped = 0;
};
Parts drop_crumbs(TetMesh& mesh, bool keep) {
  std::vector<VertexId> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](VertexId v) {
    while (root[static_cast<std::size_t>(v)] != v)
      v = root[static_cast<std::size_t>(v)] =
          root[static_cast<std::size_t>(root[static_cast<std::size_t>(v)])];
    return v;
  };
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (std::size_t i = 1; i < 4; ++i) root[static_cast<std::size_t>(find(t[i]))] = find(t[0]);
  std::map<VertexId, double> volumes;
  for (const Tetrahedron& t : mesh.tetrahedra) volumes[find(t[0])] += signed_volume(mesh, t);
  double largest = 0;
  for (const auto& [part, value] : volumes) largest = std::max(largest, value);
  Parts parts;
  std::vector<bool> stays(mesh.vertices.size(), false);
  for (const auto& [part, value] : volumes) {
    stays[static_cast<std::size_t>(part)] = keep || value >= kCrumb * largest;
    ++(stays[static_cast<std::size_t>(part)] ? parts.kept : parts.dropped);
  }
  TetMesh result;
  std::vector<VertexId> place(mesh.vertices.size(), -1);
  for (const Tetrahedron& t : mesh.tetrahedra) {
    if (!stays[static_cast<std::size_t>(find(t[0]))]) continue;
    Tetrahedron moved{};
    for (std::size_t i = 0; i < 4; ++i) {
      VertexId& to = place[static_cast<std::size_t>(t[i])];
      if (to < 0) {
        to = static_cast<VertexId>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[static_cast<std::size_t>(t[i])]);
      }
      moved[i] = to;
    }
    result.tetrahedra.push_back(moved);
  }
  mesh = std::move(result);
  return parts;
}

SurfaceMesh boundary_of(const TetMesh& mesh) {
  const BoundarySurface boundary = boundary_surface(mesh);
  SurfaceMesh surface;
  for (const VertexId v : boundary.vertex_ids)
    surface.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
  surface.triangles = boundary.triangles;
  return surface;
}

// The largest distance from the mesh's boundary to the surface. Where a hole was closed there is no
// surface: there the solid angle goes steadily through one half, and only there.
double mesh_to_surface(const Solid& solid, bool clean, const SurfaceMesh& boundary, double error,
                       double& largest_cap) {
  const double step = 3.0 * error;
  double largest = 0;
  for (const SurfacePoint& at : spread_points(boundary, kDistanceSamples)) {
    const double distance = solid.tree.nearest(at.point).distance;
    if (!clean && distance > error) {
      const Point normal = doubled_area(boundary, boundary.triangles[at.triangle]).normalized();
      const double before = solid.winding.at(at.point + step * normal);
      const double behind = solid.winding.at(at.point - step * normal);
      constexpr double kSteady = 0.25;
      if (std::abs(before - 0.5) < kSteady && std::abs(behind - 0.5) < kSteady) {
        largest_cap = std::max(largest_cap, distance);
        continue;
      }
    }
    largest = std::max(largest, distance);
  }
  return largest;
}

// The way back, from those points of the surface that part inside from outside.
double surface_to_mesh(const Solid& solid, bool clean, const TriangleTree& boundary) {
  constexpr double kStep = 1e-4;
  double largest = 0;
  for (const SurfacePoint& at : spread_points(solid.surface, kDistanceSamples)) {
    const Point normal =
        doubled_area(solid.surface, solid.surface.triangles[at.triangle]).normalized();
    const bool border =
        solid.inside(at.point - kStep * normal) && !solid.inside(at.point + kStep * normal);
    if (clean || border) largest = std::max(largest, boundary.nearest(at.point).distance);
  }
  return largest;
}

// In units of the diagonal.
void measure(const Solid& solid, bool clean, double error, const TetMesh& mesh,
             SurfaceMeshReport& report) {
  report.quality = mesh_quality(mesh);
  const SurfaceMesh boundary = boundary_of(mesh);
  const TriangleTree tree(boundary);
  report.cap_to_surface = 0;
  if (solid.half_thickness > 0) {
    // The faces of a sheet are half its thickness off on purpose.
    report.mesh_to_surface =
        distance_from(boundary, solid.tree, kDistanceSamples) - solid.half_thickness;
    report.surface_to_mesh =
        distance_from(solid.surface, tree, kDistanceSamples) - solid.half_thickness;
    return;
  }
  report.mesh_to_surface = mesh_to_surface(solid, clean, boundary, error, report.cap_to_surface);
  report.surface_to_mesh = surface_to_mesh(solid, clean, tree);
}

Status refuse_hopeless(const RepairedSurface& repaired, const SurfaceMeshOptions& options,
                       const Scaling& scaling) {
  const SurfaceFindings& findings = repaired.findings;
  if (!(scaling.diagonal > 0) || repaired.mesh.triangles.empty())
    return content_error(
        "no triangle of the surface has an area: is it a drawing of points or "
        "lines? Export faces");
  if (options.thicken > 0) return Success{};
  const std::string sheet = text(
      "If it is a sheet, give it a thickness by --thicken, say --thicken "
      "%.2g (m)",
      0.02 * scaling.diagonal);
  if (findings.one_sided_edges > 0 &&
      findings.holes + findings.branching_edges + findings.crossings < findings.one_sided_edges)
    return content_error("the surface is one-sided, like a Moebius strip: it has no inside. " +
                         sheet);
  if (findings.hole_share > kMostHoles && !options.fill_holes)
    return content_error(text("the surface is open: %zu hole%s of %.0f %% of its area. Close %s in "
                              "the modelling program, or by --fill-holes. ",
                              findings.holes, findings.holes == 1 ? "" : "s",
                              100.0 * findings.hole_share, findings.holes == 1 ? "it" : "them") +
                         sheet);
  return Success{};
}

}  // namespace

Result<MeshedSurface> mesh_surface(const RenderSurface& given, const SurfaceMeshOptions& options) {
  MeshedSurface result;
  SurfaceMeshReport& report = result.report;
  Scaling scaling;
  RepairedSurface repaired = repair_surface(scale(given, scaling));
  report.findings = repaired.findings;
  report.diagonal = scaling.diagonal;
  if (Status status = refuse_hopeless(repaired, options, scaling); !status) return status.error();

  const bool clean = report.findings.clean();
  const Solid solid(std::move(repaired.mesh), options.thicken / scaling.diagonal);
  constexpr double kLeastBacked = 0.3;
  if (solid.half_thickness == 0 && backed_share(solid) < kLeastBacked)
    return content_error(
        text("the surface encloses no volume. If it is a sheet, give it a "
             "thickness by --thicken, say --thicken %.2g (m)",
             0.02 * scaling.diagonal));
  Result<Plan> plan = make_plan(solid, clean, options, scaling);
  if (!plan) return plan.error();

  for (int pass = 0;; ++pass) {
    Result<Attempt> done = attempt_to_count(solid, clean, *plan, options.tets);
    if (!done) return done.error();
    if (done->mesh.tetrahedra.empty())
      return content_error(
          "no tetrahedra came out: the solid is far thinner than the size. Ask for "
          "smaller ones by --size, or for more by --tets");
    const Parts parts = drop_crumbs(done->mesh, options.keep_crumbs);
    measure(solid, clean, plan->error, done->mesh, report);
    report.method = done->method;
    result.mesh = std::move(done->mesh);
    report.notes.clear();
    if (parts.dropped > 0)
      report.notes.push_back(
          text("%zu part%s of less than 1 %% of the largest one's volume left "
               "out; --keep-crumbs keeps them",
               parts.dropped, parts.dropped == 1 ? "" : "s"));
    if (parts.kept > 1)
      report.notes.push_back(
          text("%zu separate bodies: each must be held, or none (--fix none)", parts.kept));
    constexpr int kRefinements = 2;
    const bool asked = options.size > 0 || options.tets > 0 || options.error > 0;
    if (asked || report.mesh_to_surface <= kWorstError || pass == kRefinements) break;
    plan->error *= 0.6;
    plan->coarse *= 0.75;
    plan->fine *= 0.75;
  }
  const double far = std::max(report.mesh_to_surface, report.surface_to_mesh);
  if (far > kWorstError)
    report.notes.push_back(
        text("the surfaces are up to %.2g %% of the diagonal apart: holes that "
             "were closed, or details below the size",
             100.0 * far));
  if (report.quality.min_dihedral_deg < kGoodAngle)
    report.notes.push_back(
        text("the smallest dihedral angle is %.2g degrees: thin walls or edges; "
             "more tetrahedra (--tets) help",
             report.quality.min_dihedral_deg));
  report.mesh_to_surface *= scaling.diagonal;
  report.surface_to_mesh *= scaling.diagonal;
  report.cap_to_surface *= scaling.diagonal;
  for (Point& x : result.mesh.vertices) x = scaling.out(x);
  report.quality = mesh_quality(result.mesh);
  return result;
}

std::vector<std::string> describe(const SurfaceMeshReport& report) {
  std::vector<std::string> lines = describe(report.findings);
  lines.push_back(std::string(report.findings.clean() ? "closed and without crossings: " : "") +
                  "meshed " + report.method);
  lines.insert(lines.end(), report.notes.begin(), report.notes.end());
  lines.push_back(
      text("mesh to surface at most %.3g m (%.2g %% of the diagonal), surface to mesh "
           "%.3g m (%.2g %%)",
           report.mesh_to_surface, 100.0 * report.mesh_to_surface / report.diagonal,
           report.surface_to_mesh, 100.0 * report.surface_to_mesh / report.diagonal));
  return lines;
}

}  // namespace tremolo
