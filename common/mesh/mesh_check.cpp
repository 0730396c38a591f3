#include "common/mesh/mesh_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "common/mesh/point_cells.h"
#include "common/packed_index.h"
#include "common/union_find.h"

namespace tremolo {
namespace {

constexpr std::size_t kNamed = 5;  // how many culprits an error names

// "PROBLEM: tetrahedra 3, 8, 9, 12, 40 and 7 more"
class Culprits {
 public:
  Culprits(const char* one, const char* many) : one_(one), many_(many) {}
  void add(std::size_t index, const std::string& detail = "") {
    if (++count_ > kNamed) return;
    list_ += (count_ > 1 ? ", " : "") + std::to_string(index) + detail;
  }
  bool any() const { return count_ > 0; }
  Error error(const std::string& problem) const {
    return content_error(
        problem + ": " + (count_ == 1 ? one_ : many_) + " " + list_ +
        (count_ > kNamed ? " and " + std::to_string(count_ - kNamed) + " more" : ""));
  }

 private:
  const char* one_;
  const char* many_;
  std::size_t count_ = 0;
  std::string list_;
};

Culprits tetrahedra() {
  return {"tetrahedron", "tetrahedra"};
}

bool is_vertex(const TetMesh& mesh, VertexId id) {
  return is_index(id, mesh.vertices.size());
}

Status check_coordinates(const TetMesh& mesh) {
  Culprits culprits("vertex", "vertices");
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (!mesh.vertices[v].allFinite()) culprits.add(v);
  if (culprits.any()) return culprits.error("coordinates are not finite");
  return Success{};
}

Status check_indices(const TetMesh& mesh) {
  Culprits outside = tetrahedra();
  Culprits repeated = tetrahedra();
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    Tetrahedron tet = mesh.tetrahedra[t];
    for (VertexId id : tet) {
      if (is_vertex(mesh, id)) continue;
      outside.add(t, " (vertex " + std::to_string(id) + ")");
      break;
    }
    std::sort(tet.begin(), tet.end());
    const auto twice = std::adjacent_find(tet.begin(), tet.end());
    if (twice != tet.end()) repeated.add(t, " (vertex " + std::to_string(*twice) + ")");
  }
  if (outside.any())
    return outside.error("vertex index out of range, the mesh has " +
                         std::to_string(mesh.vertices.size()) + " vertices");
  if (repeated.any()) return repeated.error("a vertex is repeated within a tetrahedron");
  if (!mesh.region_of.empty() && mesh.region_of.size() != mesh.tetrahedra.size())
    return content_error("the mesh has " + std::to_string(mesh.tetrahedra.size()) +
                         " tetrahedra and regions of " + std::to_string(mesh.region_of.size()));
  for (std::int32_t region : mesh.region_of)
    if (region != -1 && !is_index(region, mesh.region_names.size()))
      return content_error("a tetrahedron is in region " + std::to_string(region) +
                           ", the mesh has " + std::to_string(mesh.region_names.size()));
  for (const auto& [name, ids] : mesh.node_sets)
    for (VertexId id : ids)
      if (!is_vertex(mesh, id))
        return content_error("set `" + name + "` names vertex " + std::to_string(id) +
                             ", the mesh has " + std::to_string(mesh.vertices.size()) +
                             " vertices");
  return Success{};
}

double longest_edge(const TetMesh& mesh, const Tetrahedron& tet) {
  double squared = 0;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < a; ++b)
      squared = std::max(squared, (mesh.vertices[tet[a]] - mesh.vertices[tet[b]]).squaredNorm());
  return std::sqrt(squared);
}

Status check_volumes(const TetMesh& mesh) {
  Culprits culprits = tetrahedra();
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const double edge = longest_edge(mesh, mesh.tetrahedra[t]);
    const double volume = std::abs(signed_volume(mesh, mesh.tetrahedra[t]));
    // This form also refuses overflow to infinity or NaN.
    if (!(volume > kDegenerateVolume * edge * edge * edge) || !std::isfinite(volume))
      culprits.add(t);
  }
  if (culprits.any()) return culprits.error("no volume (degenerate)");
  return Success{};
}

Status check_duplicates(const TetMesh& mesh) {
  std::vector<std::pair<Tetrahedron, std::size_t>> keys;
  keys.reserve(mesh.tetrahedra.size());
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    keys.emplace_back(mesh.tetrahedra[t], t);
    std::sort(keys.back().first.begin(), keys.back().first.end());
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  // {repeat, first}
  std::size_t first = 0;
  for (std::size_t n = 1; n < keys.size(); ++n) {
    if (keys[n].first == keys[first].first)
      pairs.emplace_back(keys[n].second, keys[first].second);
    else
      first = n;
  }
  std::sort(pairs.begin(), pairs.end());
  Culprits culprits = tetrahedra();
  for (const auto& [repeat, original] : pairs)
    culprits.add(repeat, " (same vertices as " + std::to_string(original) + ")");
  if (culprits.any()) return culprits.error("duplicate tetrahedra");
  return Success{};
}

// A face of a tetrahedron, its corners ascending. side: on which of the face's two sides the
// tetrahedron lies.
struct Face {
  std::array<VertexId, 3> corners;
  bool side;
  std::size_t tet;
  // The arrays of the compiler for pages have no <=>.
  bool operator<(const Face& other) const {
    return std::tie(corners, side, tet) < std::tie(other.corners, other.side, other.tet);
  }
};

Face face_of(const TetMesh& mesh, std::size_t t, std::size_t opposite) {
  const Tetrahedron& tet = mesh.tetrahedra[t];
  Face face{{}, (opposite % 2 == 1) != (signed_volume(mesh, tet) < 0), t};
  for (std::size_t i = 0, k = 0; i < 4; ++i)
    if (i != opposite) face.corners[k++] = tet[i];
  // Each exchange turns the face over.
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {0, 1}}) {
    if (face.corners[a] <= face.corners[b]) continue;
    std::swap(face.corners[a], face.corners[b]);
    face.side = !face.side;
  }
  return face;
}

// Inverted by their numbering alone, tetrahedra do not overlap. In a mesh that is folded, two of
// them lie on one side of a common face, and their volumes count double.
Status check_folds(const TetMesh& mesh) {
  const auto inverted = [&mesh](std::size_t t) {
    return signed_volume(mesh, mesh.tetrahedra[t]) < 0;
  };
  std::vector<bool> near_inverted(mesh.vertices.size(), false);
  bool any = false;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    if (!inverted(t)) continue;
    any = true;
    for (const VertexId v : mesh.tetrahedra[t]) near_inverted[v] = true;
  }
  if (!any) return Success{};
  std::vector<Face> faces;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (std::size_t i = 0; i < 4; ++i) {
      const Face face = face_of(mesh, t, i);
      if (std::all_of(face.corners.begin(), face.corners.end(),
                      [&](VertexId v) { return near_inverted[v]; }))
        faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end());
  Culprits culprits = tetrahedra();
  for (std::size_t n = 1; n < faces.size(); ++n) {
    const Face &one = faces[n - 1], &other = faces[n];
    if (one.corners != other.corners || one.side != other.side) continue;
    if (!inverted(one.tet) && !inverted(other.tet)) continue;
    const bool first = inverted(one.tet);
    culprits.add(first ? one.tet : other.tet,
                 " (over " + std::to_string(first ? other.tet : one.tet) + ")");
  }
  if (culprits.any())
    return culprits.error(
        "the mesh is folded: inverted tetrahedra lie on the same side of a face as their "
        "neighbours. Undo the motion that turned them inside out, or mesh the body again");
  return Success{};
}

std::size_t orient(TetMesh& mesh, double& volume) {
  std::size_t flipped = 0;
  for (Tetrahedron& tet : mesh.tetrahedra) {
    const double signed_value = signed_volume(mesh, tet);
    volume += std::abs(signed_value);
    if (signed_value > 0) continue;
    std::swap(tet[2], tet[3]);
    ++flipped;
  }
  return flipped;
}

void label_parts(const TetMesh& mesh, MeshReport& report) {
  MeshParts parts = mesh_parts(mesh);
  report.parts = parts.count;
  report.part_of_vertex = std::move(parts.part_of_vertex);
  for (const MeshEdge& edge : mesh.edges)
    report.part_of_vertex[edge.point] = report.part_of_vertex[edge.a];
  report.unreferenced_vertices =
      std::count(report.part_of_vertex.begin(), report.part_of_vertex.end(), -1);
}

void add_notes(MeshReport& report) {
  if (report.flipped > 0)
    report.notes.push_back(std::to_string(report.flipped) + " inverted tetrahedra were repaired");
  if (report.unreferenced_vertices > 0)
    report.notes.push_back(std::to_string(report.unreferenced_vertices) +
                           " vertices belong to no tetrahedron and are kept");
  if (report.parts > 1)
    report.notes.push_back("the mesh has " + std::to_string(report.parts) +
                           " parts that do not touch");
}

}  // namespace

Result<MeshReport> check_mesh(TetMesh& mesh) {
  if (mesh.tetrahedra.empty()) return content_error("the mesh has no tetrahedra");
  if (!std::in_range<VertexId>(mesh.vertices.size()))
    return content_error("the mesh has 2^31 vertices or more");
  for (const auto& check :
       {check_coordinates, check_indices, check_volumes, check_duplicates, check_folds}) {
    const Status status = check(mesh);
    if (!status) return status.error();
  }
  MeshReport report;
  report.flipped = orient(mesh, report.volume);
  if (!std::isfinite(report.volume))
    return content_error("the volume of the mesh is beyond what a number can hold");
  label_parts(mesh, report);
  add_notes(report);
  return report;
}

MeshParts mesh_parts(const TetMesh& mesh) {
  std::vector<VertexId> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), VertexId{0});
  MeshParts parts;
  parts.part_of_vertex.assign(mesh.vertices.size(), -1);
  constexpr int kUsed = 0;
  for (const Tetrahedron& tet : mesh.tetrahedra) {
    for (VertexId id : tet) {
      parts.part_of_vertex[id] = kUsed;
      join_sets(parent, tet[0], id);
    }
  }
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (parts.part_of_vertex[v] != kUsed) continue;
    // The root is the smallest vertex of its part, so it has its label before the others ask.
    const VertexId root = root_of(parent, static_cast<VertexId>(v));
    parts.part_of_vertex[v] = root == static_cast<VertexId>(v) ? static_cast<int>(parts.count++)
                                                               : parts.part_of_vertex[root];
  }
  return parts;
}

namespace {

constexpr double kOfShortestEdge = 1e-3;

std::vector<bool> used_vertices(const TetMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size(), false);
  const auto use = [&](VertexId v) {
    if (is_index(v, used.size())) used[v] = true;
  };
  for (const Tetrahedron& tet : mesh.tetrahedra) std::for_each(tet.begin(), tet.end(), use);
  for (const MeshEdge& edge : mesh.edges) use(edge.point);
  return used;
}

// Zero if an edge has no length.
double shortest_edge(const TetMesh& mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (const auto& [a, b] : kTetEdges)
      if (is_index(tet[a], mesh.vertices.size()) && is_index(tet[b], mesh.vertices.size()))
        shortest = std::min(shortest, (mesh.vertices[tet[a]] - mesh.vertices[tet[b]]).norm());
  return shortest;
}

}  // namespace

Coincidences find_coincidences(const TetMesh& mesh) {
  Coincidences found;
  found.first_at.resize(mesh.vertices.size());
  std::iota(found.first_at.begin(), found.first_at.end(), VertexId{0});
  const std::vector<bool> used = used_vertices(mesh);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v]) points.push_back(mesh.vertices[v]);
  const BoundingBox box = bounding_box(points);
  const double width =
      std::min(kCoincident * box.diagonal(), kOfShortestEdge * shortest_edge(mesh));
  // Cells are counted from the corner of the box, at most 1e9 of them unless edges are absurdly
  // short.
  if (!(width > 1e-15 * box.diagonal()) || !std::isfinite(box.diagonal())) return found;
  PointCells cells(width);
  std::vector<VertexId> vertex_of_point;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    const Eigen::Vector3d x = mesh.vertices[v] - box.low;
    const std::int32_t point = cells.near(x, width);
    if (point >= 0) {
      found.first_at[v] = vertex_of_point[point];
      ++found.pairs;
      continue;
    }
    cells.add(x);
    vertex_of_point.push_back(static_cast<VertexId>(v));
  }
  return found;
}

void merge_vertices(const Coincidences& found, TetMesh& mesh) {
  if (found.pairs == 0) return;
  const auto first = [&](VertexId v) {
    return is_index(v, found.first_at.size()) ? found.first_at[v] : v;
  };
  for (Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId& v : tet) v = first(v);
  for (auto& [name, set] : mesh.node_sets) {
    for (VertexId& v : set) v = first(v);
    std::sort(set.begin(), set.end());
    set.erase(std::unique(set.begin(), set.end()), set.end());
  }
  for (MeshEdge& edge : mesh.edges) {
    edge.point = first(edge.point);
    std::tie(edge.a, edge.b) = std::minmax({first(edge.a), first(edge.b)});
  }
  const auto key = [](const MeshEdge& edge) { return std::tie(edge.point, edge.a, edge.b); };
  std::sort(mesh.edges.begin(), mesh.edges.end(),
            [&](const MeshEdge& x, const MeshEdge& y) { return key(x) < key(y); });
  mesh.edges.erase(
      std::unique(mesh.edges.begin(), mesh.edges.end(),
                  [&](const MeshEdge& x, const MeshEdge& y) { return key(x) == key(y); }),
      mesh.edges.end());
}

}  // namespace tremolo
