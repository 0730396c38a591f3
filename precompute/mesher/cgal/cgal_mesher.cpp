#include "precompute/mesher/cgal/cgal_mesher.h"

#include <cmath>
#include <exception>
#include <stdexcept>
#include <string>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>

#include "common/mesh/mesh_quality.h"
#include "precompute/mesher/cgal/cgal_complex.h"
#include "precompute/mesher/surface/surface_points.h"

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

}  // namespace tremolo
