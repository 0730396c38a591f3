#include "precompute/embedding/embedding.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include <Eigen/LU>

#include "common/mesh/surface_mesh.h"
#include "common/parallel.h"
#include "precompute/embedding/box_tree.h"
#include "precompute/embedding/closest_point.h"

namespace tremolo {
namespace {

// A point on the boundary counts as inside: rounding leaves weights of 1e-16 over the aspect ratio.
constexpr double kInside = -1e-9;

BoundingBox box_of(const TetMesh& mesh, const Tetrahedron& tet) {
  BoundingBox box{mesh.vertices[tet[0]], mesh.vertices[tet[0]]};
  for (const VertexId v : tet) {
    box.low = box.low.cwiseMin(mesh.vertices[v]);
    box.high = box.high.cwiseMax(mesh.vertices[v]);
  }
  const double margin = 1e-8 * box.diagonal();
  box.low.array() -= margin;
  box.high.array() += margin;
  return box;
}

// Search trees over the tetrahedra of a mesh and the faces of its boundary.
class Locator {
 public:
  explicit Locator(const TetMesh& mesh)
      : mesh_(mesh), boundary_(boundary_surface(mesh)), tets_(tet_boxes()), faces_(face_boxes()) {}

  struct Place {
    std::size_t tet = 0;
    Eigen::Vector4d weights = Eigen::Vector4d::Zero();
    double distance = 0;  // outside
    bool clamped = false;
  };

  Place find(const Eigen::Vector3d& x) const {
    Place place = find_inside(x);
    return place.weights.isZero(0.0) ? find_outside(x) : place;
  }

 private:
  std::vector<BoundingBox> tet_boxes() const {
    std::vector<BoundingBox> boxes;
    boxes.reserve(mesh_.tetrahedra.size());
    for (const Tetrahedron& tet : mesh_.tetrahedra) boxes.push_back(box_of(mesh_, tet));
    return boxes;
  }

  std::array<Eigen::Vector3d, 3> corners(std::size_t face) const {
    const Triangle& t = boundary_.triangles[face];
    const auto at = [&](VertexId v) { return mesh_.vertices[boundary_.vertex_ids[v]]; };
    return {at(t[0]), at(t[1]), at(t[2])};
  }

  // Also fills owner_: the boundary's triangles are in the order of their tetrahedra.
  std::vector<BoundingBox> face_boxes() {
    std::size_t tet = 0;
    std::vector<BoundingBox> boxes;
    for (std::size_t face = 0; face < boundary_.triangles.size(); ++face) {
      const auto has = [&](VertexId v) {
        const Tetrahedron& corners = mesh_.tetrahedra[tet];
        return std::find(corners.begin(), corners.end(), boundary_.vertex_ids[v]) != corners.end();
      };
      const Triangle& t = boundary_.triangles[face];
      while (!(has(t[0]) && has(t[1]) && has(t[2]))) ++tet;
      owner_.push_back(tet);
      const auto at = corners(face);
      boxes.push_back(
          {at[0].cwiseMin(at[1]).cwiseMin(at[2]), at[0].cwiseMax(at[1]).cwiseMax(at[2])});
    }
    return boxes;
  }

  Eigen::Vector4d weights_in(std::size_t tet, const Eigen::Vector3d& x) const {
    const Tetrahedron& t = mesh_.tetrahedra[tet];
    const Eigen::Vector3d& origin = mesh_.vertices[t[0]];
    Eigen::Matrix3d edges;
    for (int c = 0; c < 3; ++c) edges.col(c) = mesh_.vertices[t[c + 1]] - origin;
    const Eigen::Vector3d w = edges.inverse() * (x - origin);
    return {1.0 - w.sum(), w[0], w[1], w[2]};
  }

  // All weights are zero if no tetrahedron contains x.
  Place find_inside(const Eigen::Vector3d& x) const {
    Place best;
    double least = kInside;
    tets_.visit_near(x, 0.0, [&](std::size_t tet) {
      const Eigen::Vector4d weights = weights_in(tet, x);
      if (!(weights.minCoeff() >= least)) return;
      least = weights.minCoeff();
      best = {tet, weights, 0.0, false};
    });
    return best;
  }

  Place find_outside(const Eigen::Vector3d& x) const {
    const auto squared = [&](std::size_t face) {
      return closest_on_triangle(x, corners(face)).squared_distance;
    };
    const BoxTree::Nearest nearest = faces_.nearest(x, squared);
    // Several faces may be equally near, at an edge or a corner; the one with the least
    // extrapolation is taken.
    const double reach = nearest.squared_distance * (1.0 + 1e-9);
    Place best;
    std::size_t face = nearest.item;
    double least = -std::numeric_limits<double>::infinity();
    faces_.visit_near(x, reach, [&](std::size_t candidate) {
      if (squared(candidate) > reach) return;
      const Eigen::Vector4d weights = weights_in(owner_[candidate], x);
      if (!(weights.minCoeff() > least)) return;
      least = weights.minCoeff();
      best = {owner_[candidate], weights, 0.0, false};
      face = candidate;
    });
    best.distance = std::sqrt(nearest.squared_distance);
    best.clamped =
        !(best.weights.minCoeff() >= kLeastWeight && best.weights.maxCoeff() <= kLargestWeight);
    if (best.clamped) follow_face(x, face, best);
    return best;
  }

  // Sets the weights to those of the face's point that is closest to x.
  void follow_face(const Eigen::Vector3d& x, std::size_t face, Place& place) const {
    const ClosestPoint closest = closest_on_triangle(x, corners(face));
    place.tet = owner_[face];
    place.weights.setZero();
    const Tetrahedron& tet = mesh_.tetrahedra[place.tet];
    for (int k = 0; k < 3; ++k) {
      const VertexId id = boundary_.vertex_ids[boundary_.triangles[face][k]];
      place.weights[std::find(tet.begin(), tet.end(), id) - tet.begin()] = closest.weights[k];
    }
  }

  const TetMesh& mesh_;
  BoundarySurface boundary_;
  std::vector<std::size_t> owner_;
  BoxTree tets_;
  BoxTree faces_;
};

}  // namespace

namespace {

// used: which points the counts and distances are of; empty: all.
Embedding embed_points(const std::vector<Eigen::Vector3d>& points, const std::vector<bool>& used,
                       const TetMesh& mesh, unsigned threads) {
  const Locator locator(mesh);
  std::vector<Locator::Place> places(points.size());
  constexpr std::size_t kChunk = 1024;
  parallel_for((points.size() + kChunk - 1) / kChunk, threads, [&](std::size_t chunk) {
    const std::size_t end = std::min(points.size(), kChunk * (chunk + 1));
    for (std::size_t v = kChunk * chunk; v < end; ++v) places[v] = locator.find(points[v]);
  });
  Embedding embedding;
  embedding.tetrahedra.reserve(points.size());
  embedding.weights.reserve(points.size());
  for (std::size_t v = 0; v < places.size(); ++v) {
    const Locator::Place& place = places[v];
    embedding.tetrahedra.push_back(place.tet);
    embedding.weights.push_back(place.weights);
    if (!used.empty() && !used[v]) continue;
    ++embedding.counted;
    if (place.distance > 0.0) ++embedding.outside;
    embedding.largest_distance = std::max(embedding.largest_distance, place.distance);
    if (!place.clamped) continue;
    ++embedding.clamped;
    embedding.clamped_distance = std::max(embedding.clamped_distance, place.distance);
  }
  return embedding;
}

}  // namespace

Embedding embed(const std::vector<Eigen::Vector3d>& points, const TetMesh& mesh, unsigned threads) {
  return embed_points(points, {}, mesh, threads);
}

Embedding embed_surface(const RenderSurface& surface, const TetMesh& mesh, unsigned threads) {
  std::vector<bool> used(surface.vertices.size(), false);
  for (const Triangle& triangle : surface.triangles)
    for (const VertexId id : triangle) used[id] = true;
  return embed_points(surface.vertices, used, mesh, threads);
}

BasisRows embedded_rows(const Embedding& embedding, const TetMesh& mesh, const BasisRows& basis) {
  const Eigen::Index count = embedding.weights.size();
  BasisRows rows = BasisRows::Zero(3 * count, basis.cols());
  for (Eigen::Index v = 0; v < count; ++v)
    for (int c = 0; c < 4; ++c) {
      const VertexId id = mesh.tetrahedra[embedding.tetrahedra[v]][c];
      rows.middleRows(3 * v, 3) +=
          embedding.weights[v][c] * basis.middleRows(3 * Eigen::Index{id}, 3);
    }
  return rows;
}

std::vector<VertexId> heaviest_vertices(const Embedding& embedding, const TetMesh& mesh) {
  std::vector<VertexId> ids;
  ids.reserve(embedding.weights.size());
  for (std::size_t v = 0; v < embedding.weights.size(); ++v) {
    int heaviest = 0;
    embedding.weights[v].maxCoeff(&heaviest);
    ids.push_back(mesh.tetrahedra[embedding.tetrahedra[v]][heaviest]);
  }
  return ids;
}

std::vector<std::string> describe(const Embedding& embedding, const TetMesh& mesh) {
  const double size = bounding_box(mesh.vertices).diagonal();
  char text[300];
  std::vector<std::string> notes;
  std::snprintf(text, sizeof(text),
                "render surface: %zu vertices inside the tetrahedra, %zu outside, the farthest by "
                "%.3g m (%.2g %% of the size)",
                embedding.counted - embedding.outside, embedding.outside,
                embedding.largest_distance, 100.0 * embedding.largest_distance / size);
  notes.emplace_back(text);
  if (embedding.clamped > 0) {
    std::snprintf(text, sizeof(text),
                  "render surface: %zu vertices are too far outside to be carried along (up to "
                  "%.3g m): they follow the nearest point of the boundary",
                  embedding.clamped, embedding.clamped_distance);
    notes.emplace_back(text);
  }
  if (embedding.largest_distance > 0.2 * size)
    notes.emplace_back(
        "warning: the render surface and the mesh are not at the same place or of the same size; "
        "is --unit right?");
  return notes;
}

}  // namespace tremolo
