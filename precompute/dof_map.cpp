#include "precompute/dof_map.h"

#include <algorithm>
#include <numeric>

#include <metis.h>

#include "precompute/failure.h"
#include "precompute/term_signal.h"

namespace tremolo {
namespace {

static_assert(sizeof(idx_t) == sizeof(int), "METIS is built with 32-bit indices");

constexpr idx_t kSeed = 1;  // METIS draws random numbers: the same mesh must give the same order

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

// Which rank each node of the graph belongs to.
std::vector<int> partition(Graph& graph, int count, int ranks) {
  std::vector<int> part(static_cast<std::size_t>(count), 0);
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
  return part;
}

// The part of the graph inside `members` (ascending), renumbered by position.
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

// Position i of the result is the member that comes i-th in nested dissection.
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
  for (idx_t i : order) ordered.push_back(members[static_cast<std::size_t>(i)]);
  return ordered;
}

}  // namespace

Graph node_graph(const TetMesh& mesh, const std::vector<int>& number, int count) {
  std::vector<std::vector<int>> rows(static_cast<std::size_t>(count));
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId a : tet)
      for (VertexId b : tet)
        if (a != b && number[a] >= 0 && number[b] >= 0) rows[number[a]].push_back(number[b]);
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

DofMap make_dof_map(const TetMesh& mesh, const std::vector<VertexId>& fixed, int ranks) {
  std::vector<int> number(mesh.vertices.size(), -1);
  for (const Tetrahedron& tet : mesh.tetrahedra)
    for (VertexId v : tet) number[v] = 0;
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

LocalDofs local_dofs(const TetMesh& mesh, const DofMap& map, int rank) {
  LocalDofs local;
  local.first_node = map.rank_begin[rank];
  local.nodes = map.rank_begin[rank + 1] - local.first_node;
  local.row_of_vertex.assign(mesh.vertices.size(), -1);
  for (int i = 0; i < local.nodes; ++i)
    local.row_of_vertex[map.vertex_of_node[local.first_node + i]] = 3 * i;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const Tetrahedron& tet = mesh.tetrahedra[e];
    if (std::any_of(tet.begin(), tet.end(),
                    [&](VertexId v) { return local.row_of_vertex[v] >= 0; }))
      local.elements.push_back(static_cast<int>(e));
  }
  return local;
}

}  // namespace tremolo
