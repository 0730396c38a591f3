#include "precompute/fem/dof_map.h"

#include <algorithm>
#include <numeric>

#include <metis.h>

#include "precompute/system/failure.h"
#include "precompute/system/term_signal.h"

namespace tremolo {
namespace {

static_assert(sizeof(idx_t) == sizeof(int), "METIS is built with 32-bit indices");

constexpr idx_t kSeed = 1;  // METIS uses random numbers; a fixed seed makes the order reproducible

void require_metis(int status, const char* what) {
  if (status != METIS_OK)
    throw Failure(system_error(std::string("METIS failed to ") + what + " (status " +
                               std::to_string(status) + ")"));
}

void set_options(idx_t* options) {
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = kSeed;
  options[METIS_OPTION_NUMBERING] = 0;
}

// METIS may leave a part of a small graph empty, and a rank without rows would need special cases
// everywhere. There must be at least as many nodes as parts.
void fill_empty_parts(int parts, std::vector<int>& part) {
  std::vector<int> size(parts, 0);
  for (const int p : part) ++size[p];
  for (int empty = 0; empty < parts; ++empty) {
    if (size[empty] > 0) continue;
    const auto largest = std::max_element(size.begin(), size.end());
    *std::find(part.begin(), part.end(), static_cast<int>(largest - size.begin())) = empty;
    --*largest;
    size[empty] = 1;
  }
}

// Returns the rank of each node of the graph.
std::vector<int> partition(Graph& graph, int count, int ranks) {
  std::vector<int> part(count, 0);
  if (ranks == 1) return part;
  if (ranks > count)
    throw Failure(content_error(std::to_string(ranks) + " ranks for " + std::to_string(count) +
                                " free vertices: use fewer ranks"));
  idx_t options[METIS_NOPTIONS];
  set_options(options);
  const TermHeldBack held;
  idx_t nodes = count, constraints = 1, parts = ranks, cut = 0;
  require_metis(METIS_PartGraphKway(&nodes, &constraints, graph.start.data(),
                                    graph.neighbours.data(), nullptr, nullptr, nullptr, &parts,
                                    nullptr, nullptr, options, &cut, part.data()),
                "partition the mesh");
  fill_empty_parts(ranks, part);
  return part;
}

// Returns the subgraph of `members` (ascending), renumbered by their position.
Graph subgraph(const Graph& graph, const std::vector<int>& members, const std::vector<int>& part) {
  std::vector<int> position(graph.start.size(), -1);
  for (std::size_t i = 0; i < members.size(); ++i) position[members[i]] = static_cast<int>(i);
  Graph inner;
  inner.start.push_back(0);
  for (int node : members) {
    for (int at = graph.start[node]; at < graph.start[node + 1]; ++at) {
      const int neighbour = graph.neighbours[at];
      if (part[neighbour] == part[node]) inner.neighbours.push_back(position[neighbour]);
    }
    inner.start.push_back(static_cast<int>(inner.neighbours.size()));
  }
  return inner;
}

// Entry i of the result is the member that comes i-th in the nested dissection order.
std::vector<int> nested_dissection(const Graph& graph, const std::vector<int>& members,
                                   const std::vector<int>& part) {
  Graph inner = subgraph(graph, members, part);
  idx_t count = static_cast<idx_t>(members.size());
  // METIS refuses a graph without edges.
  if (inner.neighbours.empty()) return members;
  std::vector<idx_t> order(members.size()), inverse(members.size());
  idx_t options[METIS_NOPTIONS];
  set_options(options);
  const TermHeldBack held;
  require_metis(METIS_NodeND(&count, inner.start.data(), inner.neighbours.data(), nullptr, options,
                             order.data(), inverse.data()),
                "order the mesh");
  std::vector<int> ordered;
  for (idx_t i : order) ordered.push_back(members[i]);
  return ordered;
}

}  // namespace

Graph node_graph(const TetMesh& mesh, const std::vector<int>& number, int count) {
  std::vector<std::vector<int>> rows(count);
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const ElementNodes nodes = element_nodes(mesh, e);
    for (VertexId a : nodes)
      for (VertexId b : nodes)
        if (a != b && number[a] >= 0 && number[b] >= 0) rows[number[a]].push_back(number[b]);
  }
  Graph graph;
  graph.start.push_back(0);
  for (std::vector<int>& row : rows) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    graph.neighbours.insert(graph.neighbours.end(), row.begin(), row.end());
    graph.start.push_back(static_cast<int>(graph.neighbours.size()));
  }
  return graph;
}

std::vector<int> dissection_order(const Graph& graph) {
  std::vector<int> all(graph.start.size() - 1);
  std::iota(all.begin(), all.end(), 0);
  return nested_dissection(graph, all, std::vector<int>(all.size(), 0));
}

DofMap make_dof_map(const TetMesh& mesh, const std::vector<VertexId>& fixed, int ranks) {
  std::vector<int> number(mesh.vertices.size(), -1);
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e)
    for (VertexId v : element_nodes(mesh, e)) number[v] = 0;
  for (VertexId v : fixed) number[v] = -1;
  std::vector<int> vertex_of;
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] == 0) {
      number[v] = static_cast<int>(vertex_of.size());
      vertex_of.push_back(static_cast<int>(v));
    }
  const int count = static_cast<int>(vertex_of.size());
  if (count == 0)
    throw Failure(content_error("every vertex of the mesh is fixed: nothing is left to move"));

  Graph graph = node_graph(mesh, number, count);
  const std::vector<int> part = partition(graph, count, ranks);
  DofMap map;
  map.node_of_vertex.assign(mesh.vertices.size(), -1);
  for (int rank = 0; rank < ranks; ++rank) {
    map.rank_begin.push_back(static_cast<int>(map.vertex_of_node.size()));
    std::vector<int> members;
    for (int node = 0; node < count; ++node)
      if (part[node] == rank) members.push_back(node);
    for (int node : nested_dissection(graph, members, part)) {
      map.node_of_vertex[vertex_of[node]] = map.nodes();
      map.vertex_of_node.push_back(vertex_of[node]);
    }
  }
  map.rank_begin.push_back(count);
  map.graph = node_graph(mesh, map.node_of_vertex, count);
  return map;
}

int rank_of_node(const DofMap& map, int node) {
  if (node < 0) return -1;
  const auto after = std::upper_bound(map.rank_begin.begin(), map.rank_begin.end(), node);
  return static_cast<int>(after - map.rank_begin.begin()) - 1;
}

int element_rank(const DofMap& map, const ElementNodes& nodes) {
  int lowest = -1;
  for (const VertexId v : nodes) {
    const int node = map.node_of_vertex[v];
    if (node >= 0 && (lowest < 0 || node < lowest)) lowest = node;
  }
  return rank_of_node(map, lowest);
}

namespace {

// Selects the tetrahedra and vertices of one rank's part of the mesh.
void choose_part(const TetMesh& mesh, const DofMap& map, int rank, LocalDofs& local) {
  const auto is_owned = [&](VertexId v) {
    const int node = map.node_of_vertex[v] - local.first_node;
    return node >= 0 && node < local.nodes;
  };
  std::vector<std::size_t> others;
  std::vector<char> used(mesh.vertices.size(), 0);
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const ElementNodes nodes = element_nodes(mesh, e);
    if (std::none_of(nodes.begin(), nodes.end(), is_owned)) continue;
    (element_rank(map, nodes) == rank ? local.tetrahedra : others).push_back(e);
    for (const VertexId v : nodes) used[v] = 1;
  }
  local.counted = local.tetrahedra.size();
  local.tetrahedra.insert(local.tetrahedra.end(), others.begin(), others.end());
  for (std::size_t v = 0; v < used.size(); ++v)
    if (used[v] != 0) local.vertices.push_back(static_cast<VertexId>(v));
}

}  // namespace

LocalDofs local_dofs(const TetMesh& mesh, const DofMap& map, int rank) {
  LocalDofs local;
  local.first_node = map.rank_begin[rank];
  local.nodes = map.rank_begin[rank + 1] - local.first_node;
  if (map.rank_begin.size() == 2) {
    local.vertices.resize(mesh.vertices.size());
    std::iota(local.vertices.begin(), local.vertices.end(), 0);
    local.tetrahedra.resize(mesh.tetrahedra.size());
    std::iota(local.tetrahedra.begin(), local.tetrahedra.end(), std::size_t{0});
    local.counted = local.tetrahedra.size();
  } else {
    choose_part(mesh, map, rank, local);
  }
  for (const VertexId v : local.vertices) {
    const int node = map.node_of_vertex[v];
    const int row_node = node - local.first_node;
    local.node_of_vertex.push_back(node);
    local.row_of_vertex.push_back(
        node >= 0 && row_node >= 0 && row_node < local.nodes ? 3 * row_node : -1);
  }
  for (std::size_t i = 0; i < local.tetrahedra.size(); ++i) {
    const ElementNodes nodes = element_nodes(mesh, local.tetrahedra[i]);
    if (map.rank_begin.size() > 2 || std::any_of(nodes.begin(), nodes.end(), [&](VertexId v) {
          return map.node_of_vertex[v] >= 0;
        }))
      local.elements.push_back(static_cast<int>(i));
  }
  return local;
}

TetMesh part_mesh(const TetMesh& mesh, const LocalDofs& local) {
  TetMesh part;
  std::vector<VertexId> part_id(mesh.vertices.size(), -1);
  for (const VertexId v : local.vertices) {
    part_id[v] = static_cast<VertexId>(part.vertices.size());
    part.vertices.push_back(mesh.vertices[v]);
  }
  for (const std::size_t e : local.tetrahedra) {
    Tetrahedron tet = mesh.tetrahedra[e];
    for (VertexId& v : tet) v = part_id[v];
    part.tetrahedra.push_back(tet);
    if (mesh.edge_points.empty()) continue;
    TetEdges points = mesh.edge_points[e];
    for (VertexId& v : points) v = part_id[v];
    part.edge_points.push_back(points);
  }
  return part;
}

}  // namespace tremolo
