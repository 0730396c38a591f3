#include "precompute/ranks/row_gather.h"

#include <algorithm>
#include <utility>

#include "common/elements/element.h"
#include "precompute/system/petsc.h"

namespace tremolo {
namespace {

// One block of the file. owner(i): rank that holds the three rows of item i; -1 if they are zero.
// fill(i, out): writes them row-major; called on the owner only.
struct SpreadRows {
  std::size_t items = 0;
  std::function<int(std::size_t)> owner;
  std::function<void(std::size_t, double*)> fill;
};

// Returns the rows of a vertex of this rank's part.
auto rows_of(const SpreadBasis& basis, VertexId vertex) {
  const std::vector<VertexId>& ids = basis.local.vertices;
  return basis.rows.middleRows<3>(3 *
                                  (std::lower_bound(ids.begin(), ids.end(), vertex) - ids.begin()));
}

SpreadRows rows_of_vertices(const SpreadBasis& basis, const std::vector<VertexId>& ids) {
  const auto fill = [&basis, &ids](std::size_t i, double* out) {
    Eigen::Map<BasisRows> rows(out, 3, basis.rows.cols());
    rows = rows_of(basis, ids[i]);
    // The displacement of the edge's middle from the control values (common/mesh/edge_points.h).
    if (const MeshEdge* edge = edge_of_point(basis.mesh, ids[i]))
      rows = 0.25 * (rows_of(basis, edge->a) + 2.0 * rows + rows_of(basis, edge->b));
  };
  const auto owner = [&basis, &ids](std::size_t i) {
    return rank_of_node(basis.map, basis.map.node_of_vertex[ids[i]]);
  };
  return {ids.size(), owner, fill};
}

SpreadRows rows_of_render(const SpreadBasis& basis) {
  const Embedding& embedding = basis.embedding;
  const auto fill = [&basis, &embedding](std::size_t i, double* out) {
    const ElementNodes nodes = element_nodes(basis.mesh, embedding.tetrahedra[i]);
    const Eigen::Vector4d& l = embedding.weights[i];
    const std::array<double, kMostNodes> weights =
        polynomials_at(nodes.count == 4 ? 1 : 2, {l[0], l[1], l[2], l[3]});
    Eigen::Map<BasisRows> rows(out, 3, basis.rows.cols());
    rows.setZero();
    for (int c = 0; c < nodes.count; ++c) rows += weights[c] * rows_of(basis, nodes[c]);
  };
  const auto owner = [&basis, &embedding](std::size_t i) {
    return element_rank(basis.map, element_nodes(basis.mesh, embedding.tetrahedra[i]));
  };
  return {embedding.tetrahedra.size(), owner, fill};
}

// Gathers items first .. first+count-1 into `out` on rank 0; `out` is not used on other ranks.
void gather(const SpreadRows& rows, Eigen::Index columns, std::size_t first, std::size_t count,
            double* out) {
  const std::size_t numbers = 3 * columns;
  const int rank = mpi_rank();
  std::vector<int> owners(count), counts(mpi_ranks(), 0);
  std::vector<double> local_values;
  for (std::size_t i = 0; i < count; ++i) {
    owners[i] = rows.owner(first + i);
    if (owners[i] >= 0) ++counts[owners[i]];
    if (owners[i] != rank) continue;
    local_values.resize(local_values.size() + numbers);
    rows.fill(first + i, local_values.data() + local_values.size() - numbers);
  }
  std::vector<int> starts(counts.size(), 0);
  for (std::size_t k = 1; k < counts.size(); ++k) starts[k] = starts[k - 1] + counts[k - 1];
  std::vector<double> all(rank == 0 ? count * numbers : 0);
  MPI_Datatype item = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(numbers), MPI_DOUBLE, &item);
  MPI_Type_commit(&item);
  MPI_Gatherv(local_values.data(), counts[rank], item, all.data(), counts.data(), starts.data(),
              item, 0, PETSC_COMM_WORLD);
  MPI_Type_free(&item);
  if (rank != 0) return;
  for (std::size_t i = 0; i < count; ++i) {
    double* target = out + i * numbers;
    if (owners[i] < 0) {
      std::fill(target, target + numbers, 0.0);
      continue;
    }
    const double* from = all.data() + numbers * static_cast<std::size_t>(starts[owners[i]]++);
    std::copy(from, from + numbers, target);
  }
}

// Returns the blocks in the order of the file.
std::vector<SpreadRows> blocks_of(const SpreadBasis& basis, const BasisData& data) {
  return {rows_of_vertices(basis, data.surface.vertex_ids), rows_of_render(basis),
          rows_of_vertices(basis, data.interior.vertex_ids)};
}

}  // namespace

RowSources gathered_rows(const SpreadBasis& basis, const BasisData& data) {
  const auto source = [columns = basis.rows.cols()](SpreadRows rows) -> RowSource {
    return [columns, rows = std::move(rows)](std::size_t first, std::size_t count, double* out) {
      gather(rows, columns, first, count, out);
      return Status(Success{});
    };
  };
  std::vector<SpreadRows> blocks = blocks_of(basis, data);
  return {source(std::move(blocks[0])), source(std::move(blocks[2])), source(std::move(blocks[1]))};
}

void serve_rows(const SpreadBasis& basis, const BasisData& data) {
  for (const SpreadRows& rows : blocks_of(basis, data))
    for (std::size_t first = 0; first < rows.items; first += kRowsAtOnce)
      gather(rows, basis.rows.cols(), first, std::min(kRowsAtOnce, rows.items - first), nullptr);
}

GatheredRows gather_rows(const SpreadBasis& basis, const BasisData& data) {
  GatheredRows rows;
  BasisRows* targets[] = {&rows.surface, &rows.render, &rows.interior};
  const std::vector<SpreadRows> blocks = blocks_of(basis, data);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const std::size_t items = blocks[b].items;
    const Eigen::Index columns = basis.rows.cols();
    if (mpi_rank() == 0) targets[b]->resize(3 * static_cast<Eigen::Index>(items), columns);
    for (std::size_t first = 0; first < items; first += kRowsAtOnce)
      gather(blocks[b], columns, first, std::min(kRowsAtOnce, items - first),
             mpi_rank() == 0 ? targets[b]->data() + 3 * first * static_cast<std::size_t>(columns)
                             : nullptr);
  }
  return rows;
}

void collect_rows(const SpreadBasis& basis, BasisData& data) {
  GatheredRows rows = gather_rows(basis, data);
  data.surface.rows = std::move(rows.surface);
  if (data.render) data.render->rows = std::move(rows.render);
  data.interior.rows = std::move(rows.interior);
}

}  // namespace tremolo
