#include <exception>
#include <stdexcept>
#include <string>

#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/make_mesh_3.h>

#include "precompute/mesher/cgal/cgal_complex.h"
#include "precompute/mesher/cgal/cgal_mesher.h"
#include "precompute/mesher/surface/cgal_surface.h"

namespace tremolo {
namespace {

using cgal::Kernel;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel, cgal::SurfaceMesh>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex =
    WatchedComplex<CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index,
                                                           Domain::Curve_index>>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

// Seeds keep this share of their distance from vertices on sharp edges.
constexpr double kNearSeed = 0.8;
// Half the length of the segment that finds a seed's position on the surface, over that distance.
constexpr double kProbe = 0.05;

// True if a point is too close to an existing vertex, or in the ball that protects a sharp edge.
bool is_taken(const Triangulation& triangulation, const Kernel::Point_3& p, double apart) {
  if (triangulation.number_of_vertices() == 0) return false;
  const auto& near = triangulation.nearest_power_vertex(Triangulation::Bare_point(p))->point();
  constexpr double kOverBall = 1.2;
  return CGAL::squared_distance(near.point(), p) <
         std::max(kNearSeed * kNearSeed * apart * apart, kOverBall * near.weight());
}

void insert_seeds(const PolyhedralRequest& request, const Domain& domain, Complex& complex) {
  const auto intersect = domain.construct_intersection_object();
  for (const auto& [x, apart] : request.seeds) {
    const Kernel::Point_3 p(x[0], x[1], x[2]);
    if (is_taken(complex.triangulation(), p, apart)) continue;
    // A skew segment meets a surface along any axis.
    const Eigen::Vector3d half = kProbe * apart * Eigen::Vector3d(0.53, 0.61, 0.59);
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d other(half[0], sign * half[1], half[2]);
      const Eigen::Vector3d from = x - other, to = x + other;
      const auto hit = intersect(Kernel::Segment_3(Kernel::Point_3(from[0], from[1], from[2]),
                                                   Kernel::Point_3(to[0], to[1], to[2])));
      if (std::get<2>(hit) == 0) continue;
      const auto vertex = complex.triangulation().insert(Triangulation::Point(std::get<0>(hit)));
      if (vertex != Complex::Vertex_handle()) {
        complex.set_dimension(vertex, 2);
        complex.set_index(vertex, std::get<1>(hit));
      }
      break;
    }
  }
}

TetMesh refine(const cgal::SurfaceMesh& polyhedron, const PolyhedralRequest& request,
               std::vector<bool>& on_edge) {
  using namespace CGAL::parameters;
  CGAL::Random random(kSeed);
  CGAL::get_default_random() = CGAL::Random(kSeed);
  Domain domain(polyhedron, &random);
  const bool edges = request.sharp_angle > 0;
  domain.detect_features(edges ? request.sharp_angle : 180.0);
  std::size_t queries = 0;
  const std::function<double(const Eigen::Vector3d&)> size = [&](const Eigen::Vector3d& x) {
    if (++queries > request.most_queries)
      throw std::runtime_error("refinement does not come to an end");
    return request.size(x);
  };
  const Sizing<Domain> sizing{&size};
  const Criteria criteria(edge_size = sizing, facet_angle = kFacetAngle, facet_size = sizing,
                          facet_distance = request.surface_error,
                          cell_radius_edge_ratio = kRadiusEdge, cell_size = sizing);
  Complex complex;
  if (edges) {
    CGAL::Mesh_error_code error{};
    constexpr bool kNonlinear = false;
    CGAL::Mesh_3::internal::init_c3t3_with_features(complex, domain, criteria, kNonlinear,
                                                    request.most_on_edges, &error);
    if (error != CGAL::Mesh_error_code{})
      throw std::runtime_error("sharp edges stand too close to be kept");
  }
  insert_seeds(request, domain, complex);
  RefinementWatch watch(request.watch);
  complex.watch = &watch;
  CGAL::refine_mesh_3(complex, domain, criteria, manifold(), no_perturb(), no_exude());
  exude(complex);
  return extract(complex, &on_edge);
}

}  // namespace

Result<TetMesh> mesh_polyhedron(const SurfaceMesh& surface, const TriangleTree& tree,
                                const PolyhedralRequest& request) {
  cgal::SurfaceMesh polyhedron;
  if (!cgal::copy(surface, polyhedron))
    return Error{ErrorKind::kSolver, "the surface is not a two-manifold"};
  try {
    std::vector<bool> on_edge;
    TetMesh mesh = refine(polyhedron, request, on_edge);
    const auto onto_surface = [&](Eigen::Vector3d& x) {
      const NearestPoint near = tree.nearest(x);
      const bool moved = near.distance < request.size(x);
      if (moved) x = near.point;
      return moved;
    };
    repair_slivers(mesh, onto_surface, on_edge, kSliverBound);
    return mesh;
  } catch (const std::exception& failure) {
    return Error{ErrorKind::kSolver, failure.what()};
  }
}

double sharp_length(const SurfaceMesh& surface, double angle) {
  namespace PMP = CGAL::Polygon_mesh_processing;
  cgal::SurfaceMesh polyhedron;
  if (!cgal::copy(surface, polyhedron)) return 0;
  const auto sharp = polyhedron.add_property_map<cgal::SurfaceMesh::Edge_index, bool>().first;
  PMP::detect_sharp_edges(polyhedron, angle, sharp);
  double length = 0;
  for (const auto edge : polyhedron.edges())
    if (sharp[edge]) length += PMP::edge_length(edge, polyhedron);
  return length;
}

}  // namespace tremolo
