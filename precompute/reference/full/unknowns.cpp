#include "precompute/reference/full/unknowns.h"

#include <algorithm>

#include "precompute/system/failure.h"

namespace tremolo {
namespace {

int free_axes(const Unknowns& unknowns, int node) {
  const int dof = 3 * unknowns.map.vertex_of_node[node];
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) count += unknowns.of_dof[dof + axis] >= 0 ? 1 : 0;
  return count;
}

int block_of(const Pattern& pattern, int node, int other) {
  const auto first = pattern.node.begin() + pattern.block[node];
  const auto last = pattern.node.begin() + pattern.block[node + 1];
  return static_cast<int>(std::lower_bound(first, last, other) - pattern.node.begin());
}

void list_blocks(const Unknowns& unknowns, Pattern& pattern) {
  const Graph& graph = unknowns.map.graph;
  pattern.block.push_back(0);
  pattern.start.push_back(0);
  for (int node = 0; node < unknowns.map.nodes(); ++node) {
    std::vector<int> row(graph.neighbours.begin() + graph.start[node],
                         graph.neighbours.begin() + graph.start[node + 1]);
    row.insert(std::lower_bound(row.begin(), row.end(), node), node);
    std::vector<int> columns;
    for (int other : row) {
      pattern.node.push_back(other);
      pattern.offset.push_back(static_cast<int>(columns.size()));
      for (int axis = 0; axis < 3; ++axis) {
        const int unknown = unknowns.of_dof[3 * unknowns.map.vertex_of_node[other] + axis];
        if (unknown >= 0) columns.push_back(unknown);
      }
    }
    pattern.block.push_back(static_cast<int>(pattern.node.size()));
    for (int k = free_axes(unknowns, node); k > 0; --k) {
      pattern.column.insert(pattern.column.end(), columns.begin(), columns.end());
      pattern.start.push_back(static_cast<int>(pattern.column.size()));
    }
  }
}

template <class Visit>
void for_each_part(const TetMesh& mesh, const Unknowns& unknowns, const Pattern& pattern,
                   const Visit& visit) {
  const std::vector<int>& node = unknowns.map.node_of_vertex;
  const int count = pattern.nodes;
  for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
    const ElementNodes nodes = element_nodes(mesh, e);
    for (int a = 0; a < count; ++a)
      for (int b = 0; b < count; ++b) {
        const int row = node[nodes[a]], column = node[nodes[b]];
        if (row >= 0 && column >= 0)
          visit(block_of(pattern, row, column), (static_cast<int>(e) * count + a) * count + b);
      }
  }
}

}  // namespace

Unknowns make_unknowns(const TetMesh& mesh, const std::vector<VertexId>& fixed,
                       const std::array<std::vector<VertexId>, 3>& held) {
  std::vector<int> is_held(3 * mesh.vertices.size(), 0);
  for (VertexId v : fixed)
    for (int axis = 0; axis < 3; ++axis) is_held[3 * v + axis] = 1;
  for (int axis = 0; axis < 3; ++axis)
    for (VertexId v : held[axis]) is_held[3 * v + axis] = 1;
  std::vector<VertexId> all;
  for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v)
    if (is_held[3 * v] + is_held[3 * v + 1] + is_held[3 * v + 2] == 3) all.push_back(v);
  Unknowns unknowns;
  unknowns.map = make_dof_map(mesh, all, 1);
  unknowns.of_dof.assign(is_held.size(), -1);
  for (int vertex : unknowns.map.vertex_of_node)
    for (int dof = 3 * vertex; dof < 3 * vertex + 3; ++dof)
      if (is_held[dof] == 0) {
        unknowns.of_dof[dof] = static_cast<int>(unknowns.dof.size());
        unknowns.dof.push_back(dof);
      }
  return unknowns;
}

Vector expand(const Unknowns& unknowns, const Vector& x) {
  Vector field = Vector::Zero(unknowns.of_dof.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) field[unknowns.dof[i]] = x[i];
  return field;
}

Vector restrict_to(const Unknowns& unknowns, const Vector& field) {
  Vector x(unknowns.count());
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = field[unknowns.dof[i]];
  return x;
}

int Pattern::self(int node_index) const {
  return block_of(*this, node_index, node_index);
}

Pattern make_pattern(const TetMesh& mesh, const Unknowns& unknowns) {
  Pattern pattern;
  pattern.nodes = mesh.edge_points.empty() ? 4 : kMostNodes;
  const std::size_t most = 0x7fffffff / (pattern.nodes * pattern.nodes);
  if (mesh.tetrahedra.size() > most)
    throw Failure(content_error("the reference takes at most " + std::to_string(most) +
                                " tetrahedra of this order"));
  list_blocks(unknowns, pattern);
  pattern.begin.assign(pattern.node.size() + 1, 0);
  for_each_part(mesh, unknowns, pattern, [&](int block, int) { ++pattern.begin[block + 1]; });
  for (std::size_t b = 1; b < pattern.begin.size(); ++b) pattern.begin[b] += pattern.begin[b - 1];
  pattern.part.resize(pattern.begin.back());
  std::vector<int> next(pattern.begin.begin(), pattern.begin.end() - 1);
  for_each_part(mesh, unknowns, pattern,
                [&](int block, int part) { pattern.part[next[block]++] = part; });
  return pattern;
}

}  // namespace tremolo
