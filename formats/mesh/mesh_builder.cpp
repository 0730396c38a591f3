#include "formats/mesh/mesh_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/mesh/mesh_cells.h"

namespace tremolo {

bool MeshBuilder::refuse(std::string complaint) {
  complaint_ = std::move(complaint);
  return false;
}

void MeshBuilder::reserve_vertices(std::size_t count) {
  mesh_.vertices.reserve(count);
  ids_.reserve(count);
}

bool MeshBuilder::add_vertex(std::int64_t id, const Eigen::Vector3d& x) {
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isfinite(x[axis]))
      return refuse("the " + std::string(1, "xyz"[axis]) + " coordinate of vertex " +
                    std::to_string(id) + " is " + std::to_string(x[axis]) +
                    ", expected a finite number");
  if (std::cmp_greater_equal(mesh_.vertices.size(), std::numeric_limits<VertexId>::max()))
    return refuse("expected fewer than 2^31 vertices");
  if (ids_.empty()) first_id_ = lowest_id_ = highest_id_ = id;
  // Compared with the neighbour rather than with first + size, which could overflow.
  if (!ids_.empty() &&
      (ids_.back() == std::numeric_limits<std::int64_t>::max() || id != ids_.back() + 1))
    consecutive_ = false;
  lowest_id_ = std::min(lowest_id_, id);
  highest_id_ = std::max(highest_id_, id);
  ids_.push_back(id);
  mesh_.vertices.push_back(x);
  return true;
}

bool MeshBuilder::seal_vertices() {
  if (consecutive_) return true;
  index_of_id_.reserve(ids_.size());
  for (std::size_t v = 0; v < ids_.size(); ++v)
    index_of_id_.emplace_back(ids_[v], static_cast<VertexId>(v));
  std::sort(index_of_id_.begin(), index_of_id_.end());
  const auto twice =
      std::adjacent_find(index_of_id_.begin(), index_of_id_.end(),
                         [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice == index_of_id_.end()) return true;
  return refuse("vertex id " + std::to_string(twice->first) +
                " is given twice, expected every id once");
}

VertexId MeshBuilder::find(std::int64_t id) const {
  if (ids_.empty() || id < lowest_id_ || id > highest_id_) return -1;
  if (consecutive_) return static_cast<VertexId>(id - first_id_);
  const auto found = std::lower_bound(index_of_id_.begin(), index_of_id_.end(),
                                      std::pair<std::int64_t, VertexId>{id, -1});
  return found != index_of_id_.end() && found->first == id ? found->second : -1;
}

bool MeshBuilder::resolve(std::int64_t cell, std::span<const std::int64_t> nodes,
                          std::vector<VertexId>& vertices) {
  vertices.clear();
  for (std::int64_t id : nodes) {
    const VertexId vertex = find(id);
    if (vertex < 0)
      return refuse("element " + std::to_string(cell) + " refers to vertex " + std::to_string(id) +
                    ", expected one of the file's " + std::to_string(ids_.size()) +
                    " vertices, ids " + std::to_string(lowest_id_) + " to " +
                    std::to_string(highest_id_));
    vertices.push_back(vertex);
  }
  return true;
}

bool MeshBuilder::add_cell(std::int64_t cell, const CellKind& kind,
                           std::span<const VertexId> vertices, bool in_set) {
  if (kind.role == CellKind::Role::kHigherTetrahedron)
    return refuse(
        "element " + std::to_string(cell) + " is one of " + std::string(kind.plural) +
        ", expected linear or quadratic tetrahedra (4 or 10 nodes): export the mesh with order "
        "1 or 2");
  if (kind.is_cut()) return cut(cell, kind, vertices);
  if (kind.role == CellKind::Role::kOther) {
    Others& others = others_[kind.plural];
    ++(in_set ? others.in_sets : others.skipped);
    return true;
  }
  const std::size_t expected = kind.is_quadratic() ? 10 : 4;
  if (vertices.size() != expected)
    return refuse("element " + std::to_string(cell) + " is a tetrahedron with " +
                  std::to_string(vertices.size()) + " nodes, expected " + std::to_string(expected));
  mesh_.tetrahedra.push_back({vertices[0], vertices[1], vertices[2], vertices[3]});
  if (!kind.is_quadratic()) return true;
  constexpr std::array<std::array<std::size_t, 2>, 6> kEnds = {
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  for (std::size_t e = 0; e < 6; ++e) {
    const bool exchanged = kind.role == CellKind::Role::kGmshQuadraticTetrahedron && e >= 4;
    const VertexId point = vertices[exchanged ? 13 - e : 4 + e];
    const auto [a, b] = std::minmax(vertices[kEnds[e][0]], vertices[kEnds[e][1]]);
    mesh_.edges.push_back({point, a, b});
  }
  return true;
}

bool MeshBuilder::cut(std::int64_t cell, const CellKind& kind, std::span<const VertexId> vertices) {
  const std::size_t count = kind.corners();
  if (vertices.size() < count)
    return refuse("element " + std::to_string(cell) + " is one of " + std::string(kind.plural) +
                  " with " + std::to_string(vertices.size()) + " nodes, expected " +
                  std::to_string(count));
  if (ranks_.empty()) ranks_ = ranks_by_place(mesh_.vertices);
  std::array<VertexId, 8> corners{};
  std::copy_n(vertices.begin(), count, corners.begin());
  if (kind.role == CellKind::Role::kVoxel) {
    std::swap(corners[2], corners[3]);
    std::swap(corners[6], corners[7]);
  }
  const std::size_t before = mesh_.tetrahedra.size();
  const std::string complaint = cut_cell(kind, {corners.data(), count}, ranks_, mesh_);
  if (!complaint.empty())
    return refuse("element " + std::to_string(cell) + ", one of " + std::string(kind.plural) +
                  ", " + complaint);
  std::array<std::size_t, 2>& counted = cut_[kind.plural];
  ++counted[0];
  counted[1] += mesh_.tetrahedra.size() - before;
  return true;
}

void MeshBuilder::add_to_set(const std::string& name, std::span<const VertexId> vertices) {
  std::vector<VertexId>& set = mesh_.node_sets[name];
  set.insert(set.end(), vertices.begin(), vertices.end());
}

void MeshBuilder::set_regions(std::span<const std::int64_t> label_of_tet,
                              const std::function<std::string(std::int64_t)>& name) {
  std::map<std::int64_t, std::int32_t> region_of_label;
  std::map<std::string, std::int32_t> region_of_name;
  mesh_.region_names.clear();
  mesh_.region_of.clear();
  mesh_.region_of.reserve(label_of_tet.size());
  for (std::int64_t label : label_of_tet) {
    const auto [known, fresh] = region_of_label.try_emplace(label, -1);
    if (fresh) {
      const std::string text = name(label);
      if (!text.empty()) {
        const auto count = static_cast<std::int32_t>(mesh_.region_names.size());
        const auto [entry, unknown] = region_of_name.try_emplace(text, count);
        if (unknown) mesh_.region_names.push_back(text);
        known->second = entry->second;
      }
    }
    mesh_.region_of.push_back(known->second);
  }
  if (mesh_.region_names.empty()) mesh_.region_of.clear();
}

Result<MeshFile> MeshBuilder::finish(std::string format) {
  std::string others;
  const auto cells = [](std::size_t count, std::string_view plural) {
    return std::to_string(count) + " " + std::string(plural);
  };
  for (const auto& [plural, count] : others_) {
    if (count.in_sets > 0)
      notes_.push_back(cells(count.in_sets, plural) +
                       " are in named sets, for selectors; only tetrahedra are computed with");
    if (count.skipped > 0) notes_.push_back(cells(count.skipped, plural) + " skipped");
    others += (others.empty() ? "" : ", ") + cells(count.in_sets + count.skipped, plural);
  }
  for (const auto& [plural, count] : cut_)
    notes_.push_back(cells(count[0], plural) + " are cut into " + std::to_string(count[1]) +
                     " tetrahedra by their corners");
  if (mesh_.tetrahedra.empty())
    return content_error(file_ + ": expected tetrahedra, found " +
                         std::to_string(mesh_.vertices.size()) + " vertices and " +
                         (others.empty() ? "no cells" : others) + " (" + format + ")");
  // Each edge was there once for every tetrahedron around it. Points that two edges share, and
  // edges with two points, stay: straighten_edges() names them.
  const auto key = [](const MeshEdge& edge) { return std::array{edge.point, edge.a, edge.b}; };
  std::sort(mesh_.edges.begin(), mesh_.edges.end(),
            [&](const MeshEdge& x, const MeshEdge& y) { return key(x) < key(y); });
  const auto same = [&](const MeshEdge& x, const MeshEdge& y) { return key(x) == key(y); };
  mesh_.edges.erase(std::unique(mesh_.edges.begin(), mesh_.edges.end(), same), mesh_.edges.end());
  for (auto& [name, set] : mesh_.node_sets) {
    std::sort(set.begin(), set.end());
    set.erase(std::unique(set.begin(), set.end()), set.end());
  }
  return MeshFile{std::move(mesh_), std::move(format), std::move(notes_), std::move(materials_)};
}

}  // namespace tremolo
