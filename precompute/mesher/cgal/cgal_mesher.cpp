#include "precompute/mesher/cgal/cgal_mesher.h"

#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>

#include "common/mesh/mesh_quality.h"
#include "common/mesh/point_cells.h"
#include "common/text.h"
#include "precompute/mesher/cgal/cgal_complex.h"

namespace tremolo {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = WatchedComplex<CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

// Distance of the first points over the requested size: a little large, so that refinement decides.
constexpr double kFirstSpacing = 1.2;
// Grid cells along the diagonal in which the first points are searched for.
constexpr int kFirstCells = 220;
// Accuracy of the intersection of a segment with the surface, over the radius of the bounding
// sphere.
constexpr double kIntersectionError = 1e-5;

// Newton's steps of a recipe's vertex to the surface, and the required accuracy, over the error.
constexpr int kProjections = 6;
constexpr double kOffSurface = 0.05;

Eigen::Vector3d plain(const Kernel::Point_3& p) {
  return {p.x(), p.y(), p.z()};
}

Domain make_domain(const ImplicitRequest& request, CGAL::Random& random, std::size_t& queries) {
  const Eigen::Vector3d& low = request.bounds.low;
  const Eigen::Vector3d& high = request.bounds.high;
  const auto side = [&request, &queries](const Kernel::Point_3& p) {
    if (++queries > request.most_queries)
      throw std::runtime_error("refinement does not come to an end");
    return request.inside(plain(p)) ? -1.0 : 1.0;
  };
  return Domain::create_implicit_mesh_domain(
      side, CGAL::Bbox_3(low[0], low[1], low[2], high[0], high[1], high[2]),
      CGAL::parameters::p_rng = &random,
      CGAL::parameters::relative_error_bound = kIntersectionError);
}

void insert_first_points(const ImplicitRequest& request, const Domain& domain, Complex& complex) {
  const Domain::Index surface =
      domain.index_from_surface_patch_index(Domain::Surface_patch_index(0, 1));
  for (const Eigen::Vector3d& x : request.first_points) {
    const auto vertex =
        complex.triangulation().insert(Triangulation::Point(Kernel::Point_3(x[0], x[1], x[2])));
    complex.set_dimension(vertex, 2);
    complex.set_index(vertex, surface);
  }
}

void refine(const ImplicitRequest& request, const Domain& domain, Complex& complex) {
  using namespace CGAL::parameters;
  const Sizing<Domain> sizing{&request.size};
  const Criteria criteria(facet_angle = kFacetAngle, facet_size = sizing,
                          facet_distance = request.surface_error,
                          cell_radius_edge_ratio = kRadiusEdge, cell_size = sizing);
  RefinementWatch watch(request.watch);
  complex.watch = &watch;
  CGAL::refine_mesh_3(complex, domain, criteria, request.manifold ? manifold() : non_manifold(),
                      no_perturb(), no_exude());
  complex.watch = nullptr;
  if (request.perturb)
    CGAL::perturb_mesh_3(complex, domain, sliver_bound = kSliverBound, time_limit = 0);
  exude(complex);
}

// Newton's steps along the gradient of the distance; false if they do not arrive.
bool step_onto(const Recipe& recipe, Eigen::Vector3d& x) {
  const double h = 1e-3 * recipe.surface_error;
  for (int i = 0; i < kProjections; ++i) {
    const double value = recipe.distance(x);
    if (std::abs(value) < kOffSurface * recipe.surface_error) return true;
    Eigen::Vector3d gradient;
    for (int axis = 0; axis < 3; ++axis)
      gradient[axis] = (recipe.distance(x + h * Eigen::Vector3d::Unit(axis)) - value) / h;
    if (gradient.squaredNorm() < 0.01) return false;
    x -= value / gradient.squaredNorm() * gradient;
  }
  return false;
}

}  // namespace

Result<TetMesh> mesh_implicit(const ImplicitRequest& request) {
  try {
    CGAL::Random random(kSeed);
    CGAL::get_default_random() = CGAL::Random(kSeed);
    std::size_t queries = 0;
    const Domain domain = make_domain(request, random, queries);
    Complex complex;
    insert_first_points(request, domain, complex);
    refine(request, domain, complex);
    TetMesh mesh = extract(complex);
    repair_slivers(mesh, request.onto_surface, {}, kSliverBound);
    return mesh;
  } catch (const std::exception& failure) {
    return Error{ErrorKind::kSolver, std::string("the mesher failed: ") + failure.what()};
  }
}

Result<TetMesh> mesh_recipe(const Recipe& recipe) {
  const std::string name(recipe.name);
  ImplicitRequest request;
  request.bounds = recipe.bounds;
  request.inside = [&recipe](const Eigen::Vector3d& x) { return recipe.distance(x) < 0.0; };
  request.size = recipe.size;
  request.surface_error = recipe.surface_error;
  request.first_points = surface_points(recipe, kFirstSpacing, kFirstCells);
  request.onto_surface = [&recipe](Eigen::Vector3d& x) { return step_onto(recipe, x); };
  request.most_queries = static_cast<std::size_t>(-1);
  request.perturb = true;  // as when the sample meshes were made
  Result<TetMesh> mesh = mesh_implicit(request);
  if (!mesh) return Error{mesh.error().kind, name + ": " + mesh.error().message};
  if (mesh->tetrahedra.empty())
    return content_error(name + ": no tetrahedra: the solid is empty or far thinner than the size");
  const std::size_t parts = mesh_quality(*mesh).parts;
  if (parts != 1)
    return content_error(name + ": the mesh falls into " + std::to_string(parts) +
                         " parts: the solid is not connected or too thin for the size");
  return mesh;
}

namespace {

using Point = Eigen::Vector3d;
using Cell = Eigen::Vector3i;

Point crossing(const Recipe& recipe, Point inside, Point outside) {
  const double enough = 1e-9 * recipe.bounds.diagonal();
  while ((outside - inside).norm() > enough) {
    const Point middle = 0.5 * (inside + outside);
    (recipe.distance(middle) < 0.0 ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

struct Grid {
  Point low;
  double step;
  Cell count;
  Point at(const Cell& c) const { return low + step * c.cast<double>(); }
  std::size_t index(const Cell& c) const {
    return (static_cast<std::size_t>(c[2]) * count[1] + c[1]) * count[0] + c[0];
  }
};

template <class Visit>
void for_each(const Grid& grid, const Visit& visit) {
  Cell c;
  for (c[2] = 0; c[2] < grid.count[2]; ++c[2])
    for (c[1] = 0; c[1] < grid.count[1]; ++c[1])
      for (c[0] = 0; c[0] < grid.count[0]; ++c[0]) visit(c);
}

std::vector<Point> crossings(const Recipe& recipe, const Grid& grid) {
  std::vector<double> values(static_cast<std::size_t>(grid.count[0]) * grid.count[1] *
                             grid.count[2]);
  for_each(grid, [&](const Cell& c) { values[grid.index(c)] = recipe.distance(grid.at(c)); });
  std::vector<Point> points;
  for_each(grid, [&](const Cell& c) {
    for (int axis = 0; axis < 3; ++axis) {
      const Cell next = c + Cell::Unit(axis);
      if (next[axis] == grid.count[axis]) continue;
      const bool here = values[grid.index(c)] < 0.0;
      const bool there = values[grid.index(next)] < 0.0;
      if (here == there) continue;
      points.push_back(here ? crossing(recipe, grid.at(c), grid.at(next))
                            : crossing(recipe, grid.at(next), grid.at(c)));
    }
  });
  return points;
}

}  // namespace

std::vector<Point> surface_points(const Recipe& recipe, double spacing, int cells) {
  const double step = recipe.bounds.diagonal() / cells;
  const Cell count =
      ((recipe.bounds.high - recipe.bounds.low) / step).array().ceil().cast<int>() + 2;
  const Grid grid{recipe.bounds.low - Point::Constant(0.5 * step), step, count};
  const std::vector<Point> all = crossings(recipe, grid);
  double widest = step;
  for (const Point& x : all) widest = std::max(widest, spacing * recipe.size(x));
  PointCells kept(widest);
  for (const Point& x : all) kept.add_if_apart(x, spacing * recipe.size(x));
  return kept.points();
}

namespace {

// Queries without a new vertex before refinement counts as stuck. Of 300 surfaces none that could
// be meshed made more than 3 700 in a row, or seven for each vertex.
constexpr std::uint64_t kStillAtLeast = 20'000;
constexpr std::uint64_t kStillPerVertex = 60;

}  // namespace

RefinementWatch::RefinementWatch(const WatchLimits& limits)
    : limits_(limits), start_(std::chrono::steady_clock::now()), next_report_(limits.seconds) {}

void RefinementWatch::check() {
  if (steps_ - still_since_ > kStillAtLeast + kStillPerVertex * vertices_)
    throw std::runtime_error("refinement makes no progress");
  if ((limits_.most_steps > 0 && steps_ > limits_.most_steps) ||
      (limits_.most_vertices > 0 && vertices_ > limits_.most_vertices))
    throw std::runtime_error("refinement does not come to an end");
  const auto passed = std::chrono::steady_clock::now() - start_;
  const double seconds = std::chrono::duration<double>(passed).count();
  if (seconds < next_report_) return;
  next_report_ = 2 * seconds;
  std::fprintf(stderr, "  %s\n", progress_text(vertices_, limits_.expected, seconds).c_str());
}

std::string progress_text(std::size_t vertices, std::size_t expected, double seconds) {
  if (expected == 0) return text("meshing: %zu vertices, %.0f s", vertices, seconds);
  const std::string so_far =
      text("meshing: %zu of about %zu vertices, %.0f s", vertices, expected, seconds);
  if (vertices == 0 || vertices >= expected) return so_far + ", more of them than usual";
  const double left = seconds * static_cast<double>(expected - vertices);
  return so_far + text(", about %.0f s more", left / static_cast<double>(vertices));
}

}  // namespace tremolo
