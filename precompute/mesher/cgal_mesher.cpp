#include "precompute/mesher/cgal_mesher.h"

#include <exception>
#include <string>
#include <unordered_map>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Random.h>
#include <CGAL/refine_mesh_3.h>

#include "common/mesh_quality.h"
#include "precompute/mesher/sliver_repair.h"
#include "precompute/mesher/surface_points.h"

namespace tremolo {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

// Smallest angle of a surface triangle, degrees. Refinement is proved to end up to 30.
constexpr double kFacetAngle = 27.0;
// Circumradius over shortest edge of a tetrahedron. Refinement is proved to end above 2.
constexpr double kRadiusEdge = 2.2;
// Tetrahedra whose smallest dihedral angle is below this many degrees are worked on; thin members
// keep some below it. Higher costs time and helps little.
constexpr double kSliverBound = 15.0;
// The first points stand a little wider than the wanted size, so that refinement has the last word.
constexpr double kFirstSpacing = 1.2;
// Grid cells along the diagonal in which the first points are looked for.
constexpr int kFirstCells = 220;
constexpr unsigned kSeed = 1;
// Where a segment meets the surface, over the radius of the bounding sphere.
constexpr double kIntersectionError = 1e-5;

Eigen::Vector3d plain(const Kernel::Point_3& p) {
  return {p.x(), p.y(), p.z()};
}

// The sizing field in the shape that Mesh_3 wants.
struct Sizing {
  using FT = Kernel::FT;
  using Index = Domain::Index;
  const Recipe* recipe;
  template <class AnyPoint>
  FT operator()(const AnyPoint& p, int /*dimension*/, const Index& /*index*/) const {
    return recipe->size({p.x(), p.y(), p.z()});
  }
};

Domain make_domain(const Recipe& recipe, CGAL::Random& random) {
  const Eigen::Vector3d& low = recipe.bounds.low;
  const Eigen::Vector3d& high = recipe.bounds.high;
  const auto inside = [&recipe](const Kernel::Point_3& p) { return recipe.distance(plain(p)); };
  return Domain::create_implicit_mesh_domain(
      inside, CGAL::Bbox_3(low[0], low[1], low[2], high[0], high[1], high[2]),
      CGAL::parameters::p_rng = &random,
      CGAL::parameters::relative_error_bound = kIntersectionError);
}

void insert_first_points(const Recipe& recipe, const Domain& domain, Complex& complex) {
  const Domain::Index surface =
      domain.index_from_surface_patch_index(Domain::Surface_patch_index(0, 1));
  for (const Eigen::Vector3d& x : surface_points(recipe, kFirstSpacing, kFirstCells)) {
    const auto vertex =
        complex.triangulation().insert(Triangulation::Point(Kernel::Point_3(x[0], x[1], x[2])));
    complex.set_dimension(vertex, 2);
    complex.set_index(vertex, surface);
  }
}

void refine(const Recipe& recipe, const Domain& domain, Complex& complex) {
  using namespace CGAL::parameters;
  const Sizing sizing{&recipe};
  const Criteria criteria(facet_angle = kFacetAngle, facet_size = sizing,
                          facet_distance = recipe.surface_error,
                          cell_radius_edge_ratio = kRadiusEdge, cell_size = sizing);
  CGAL::refine_mesh_3(complex, domain, criteria, manifold(),
                      perturb(sliver_bound = kSliverBound, time_limit = 0),
                      exude(sliver_bound = kSliverBound, time_limit = 0));
}

TetMesh extract(const Complex& complex) {
  TetMesh mesh;
  std::unordered_map<std::size_t, VertexId> ids;  // by Mesh_3's time stamp: no addresses
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end();
       ++cell) {
    Tetrahedron tet{};
    for (int i = 0; i < 4; ++i) {
      const auto vertex = cell->vertex(i);
      const auto [found, fresh] =
          ids.try_emplace(vertex->time_stamp(), static_cast<VertexId>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back(plain(vertex->point().point()));
      tet[static_cast<std::size_t>(i)] = found->second;
    }
    if (signed_volume(mesh, tet) < 0.0) std::swap(tet[2], tet[3]);
    mesh.tetrahedra.push_back(tet);
  }
  return mesh;
}

}  // namespace

Result<TetMesh> mesh_recipe(const Recipe& recipe) {
  const std::string name(recipe.name);
  TetMesh mesh;
  try {
    CGAL::Random random(kSeed);
    CGAL::get_default_random() = CGAL::Random(kSeed);
    const Domain domain = make_domain(recipe, random);
    Complex complex;
    insert_first_points(recipe, domain, complex);
    refine(recipe, domain, complex);
    mesh = extract(complex);
    repair_slivers(mesh, recipe, kSliverBound);
  } catch (const std::exception& failure) {
    return Error{ErrorKind::kSolver, name + ": the mesher failed: " + failure.what()};
  }
  if (mesh.tetrahedra.empty())
    return content_error(name + ": no tetrahedra: the solid is empty or far thinner than the size");
  const std::size_t parts = mesh_quality(mesh).parts;
  if (parts != 1)
    return content_error(name + ": the mesh falls into " + std::to_string(parts) +
                         " parts: the solid is not connected or too thin for the size");
  return mesh;
}

}  // namespace tremolo
