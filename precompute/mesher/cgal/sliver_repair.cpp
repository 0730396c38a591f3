#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "common/mesh/surface_mesh.h"
#include "precompute/mesher/cgal/cgal_mesher.h"

namespace tremolo {
namespace {

using Point = Eigen::Vector3d;

constexpr int kPasses = 60;
constexpr int kTrials = 40;            // positions tried for a vertex in a pass
constexpr double kLargestMove = 0.35;  // over the mean edge around the vertex
constexpr double kSmallestMove = 0.01;

// Smallest dihedral angle in radians; -1 for one that is flat or inverted.
double smallest_angle(const std::array<Point, 4>& x) {
  if ((x[1] - x[0]).dot((x[2] - x[0]).cross(x[3] - x[0])) <= 0.0) return -1.0;
  // Outward normals of the faces opposite the corners; the angle is pi minus that between two.
  const std::array<Point, 4> normals = {
      (x[2] - x[1]).cross(x[3] - x[1]).normalized(), (x[3] - x[0]).cross(x[2] - x[0]).normalized(),
      (x[1] - x[0]).cross(x[3] - x[0]).normalized(), (x[2] - x[0]).cross(x[1] - x[0]).normalized()};
  double largest = -1.0;  // of minus the cosine of a small angle
  double smallest = 1.0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double cosine = -normals[i].dot(normals[j]);
      largest = std::max(largest, cosine);
      smallest = std::min(smallest, cosine);
    }
  // Angles near 180 degrees are as bad as those near 0.
  return std::min(std::acos(std::min(1.0, largest)),
                  std::numbers::pi - std::acos(std::max(-1.0, smallest)));
}

class Repair {
 public:
  Repair(TetMesh& mesh, const OntoSurface& onto_surface, const std::vector<bool>& held,
         double wanted)
      : mesh_(mesh),
        onto_surface_(onto_surface),
        held_(held),
        wanted_(wanted),
        around_(mesh.vertices.size()),
        on_boundary_(mesh.vertices.size(), false) {
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
      for (VertexId v : mesh.tetrahedra[t]) around_[v].push_back(t);
    for (VertexId v : boundary_surface(mesh).vertex_ids) on_boundary_[v] = true;
  }

  std::vector<std::size_t> bad() const {
    std::vector<std::size_t> list;
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t)
      if (angle(t) < wanted_) list.push_back(t);
    return list;
  }

  void improve(std::size_t t) {
    for (VertexId v : mesh_.tetrahedra[t]) move(v);
  }

 private:
  double angle(std::size_t t) const {
    const Tetrahedron& tet = mesh_.tetrahedra[t];
    return smallest_angle({mesh_.vertices[tet[0]], mesh_.vertices[tet[1]], mesh_.vertices[tet[2]],
                           mesh_.vertices[tet[3]]});
  }

  double worst_around(VertexId v) const {
    double worst = std::numbers::pi;
    for (std::size_t t : around_[v]) worst = std::min(worst, angle(t));
    return worst;
  }

  double mean_edge(VertexId v) const {
    double sum = 0.0;
    for (std::size_t t : around_[v])
      for (VertexId other : mesh_.tetrahedra[t])
        sum += (mesh_.vertices[other] - mesh_.vertices[v]).norm();
    return sum / static_cast<double>(3 * around_[v].size());
  }

  void move(VertexId v) {
    if (!held_.empty() && held_[v]) return;
    double best = worst_around(v);
    if (best >= wanted_) return;
    const double edge = mean_edge(v);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (int trial = 0; trial < kTrials; ++trial) {
      const Point before = mesh_.vertices[v];
      const double share = static_cast<double>(trial) / (kTrials - 1);
      const double reach = edge * kLargestMove * std::pow(kSmallestMove / kLargestMove, share);
      Point place = before + reach * Point(uniform(random_), uniform(random_), uniform(random_));
      if (on_boundary_[v] && !onto_surface_(place)) continue;
      mesh_.vertices[v] = place;
      const double now = worst_around(v);
      if (now > best)
        best = now;
      else
        mesh_.vertices[v] = before;
    }
  }

  TetMesh& mesh_;
  const OntoSurface& onto_surface_;
  const std::vector<bool>& held_;
  double wanted_;
  std::vector<std::vector<std::size_t>> around_;
  std::vector<bool> on_boundary_;
  std::mt19937_64 random_{1};
};

}  // namespace

std::size_t repair_slivers(TetMesh& mesh, const OntoSurface& onto_surface,
                           const std::vector<bool>& held, double wanted) {
  Repair repair(mesh, onto_surface, held, wanted * std::numbers::pi / 180.0);
  std::vector<std::size_t> bad = repair.bad();
  for (int pass = 0; pass < kPasses && !bad.empty(); ++pass) {
    for (std::size_t t : bad) repair.improve(t);
    bad = repair.bad();
  }
  return bad.size();
}

}  // namespace tremolo
